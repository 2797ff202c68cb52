// SPDX-License-Identifier: MIT
// A recording and somebody's trajectory of it as fragments, ready for sifting. In: a source of known length,
// its odometry, the frames per fragment. Out: fragments with score views in a store, and back ends that hold
// them. Capacity: measured from the source's length, so that everything fits; one arena. Desk code: one
// thread besides the one that decodes, deterministic.
//
// Numbering: fragment k has the frames K·k … K·k+K−1 of the recording, counted with those that cannot be
// read or have no pose. (The onboard front end counts the frames that it fuses instead; without such frames
// the two agree.) So a loop list made for the recording keeps its meaning when a frame is broken. A
// fragment's frame is its first frame that could be used.
#pragma once
#include <deque>
#include <memory>
#include <vector>

#include "core/base/arena.hpp"
#include "core/fragment/fragment_builder.hpp"
#include "core/fragment/fragment_store.hpp"
#include "core/frame/frame.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/corrected_trajectory.hpp"
#include "core/pipeline/run_figures.hpp"
#include "tools/loopsift_tool/posed_sequence.hpp"

namespace loopsift::tool {

struct OfflineMapOptions {
  int fragment_frames = 50;
  int views = 3;  ///< per fragment
  /// One back end for each. The plain score is the paper's and comes without hindsight.
  std::vector<ScoreKind> back_ends = {ScoreKind::kPosterior};
};
[[nodiscard]] Status validate(const OfflineMapOptions& options);

/// Fragments in a recording of so many frames, the last one shorter than the others.
[[nodiscard]] int fragments_in(std::int64_t frame_count, int fragment_frames);

class OfflineMap {
 public:
  /// Reads the whole recording. Errors: a source of unknown length, no frame with a pose, a fragment without
  /// any usable frame before others that have some (its number could not be held), a source that is lost.
  [[nodiscard]] static Expected<std::unique_ptr<OfflineMap>> build(FrameSource& source,
                                                                   const GivenOdometry& odometry,
                                                                   const OfflineMapOptions& options);

  [[nodiscard]] Span<const Fragment> fragments() const { return parts_.store.fragments(); }
  /// All frames of all fragments, in order, with the poses that they were given.
  [[nodiscard]] const std::vector<OdometryPose>& frames() const { return frames_; }
  /// With every fragment and the odometry's graph; no loops yet. In the order of the options.
  [[nodiscard]] BackEnd& back_end(std::size_t which) { return parts_.back_ends[which]; }
  /// What reading and fusing came to: source, frames, times, memory. Figures of loops are not filled in.
  [[nodiscard]] const RunFigures& figures() const { return figures_; }

 private:
  // What lives in the arena; made once to measure and once for the work.
  struct Parts {
    Parts(FrameSource& source, const GivenOdometry& odometry, const OfflineMapOptions& options, Arena& arena);
    PosedSequence sequence;
    FragmentStore store;
    FramePreprocessor preprocessor;
    FragmentBuilder builder;
    std::deque<BackEnd> back_ends;
  };

  OfflineMap(FrameSource& source, const GivenOdometry& odometry, const OfflineMapOptions& options,
             std::size_t arena_bytes);
  [[nodiscard]] Status read_all(const GivenOdometry& odometry, std::int64_t frame_count);
  [[nodiscard]] Status start_fragment(int fragment);
  [[nodiscard]] Status close_fragment();
  void fuse(const PosedFrame& posed);

  OfflineMapOptions options_;
  Arena arena_;
  Parts parts_;
  std::vector<OdometryPose> frames_;
  RunFigures figures_;
};

}  // namespace loopsift::tool
