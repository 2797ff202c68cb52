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
#include <optional>
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
  int views = 3;                 ///< per fragment
  int view_width = 40;           ///< pixels that views are reduced to; smaller images are reduced less
  int map_width = 160;           ///< pixels that images are reduced to before they are fused
  std::size_t max_loops = 4096;  ///< that a back end can be given
  /// One back end for each; there may be none. The plain score is the paper's and comes without hindsight.
  std::vector<ScoreKind> back_ends = {ScoreKind::kPosterior};
};
[[nodiscard]] Status validate(const OfflineMapOptions& options);

/// Fragments in a recording of so many frames, the last one shorter than the others.
[[nodiscard]] int fragments_in(std::int64_t frame_count, int fragment_frames);

/// A back end with memory of its own, so that several can work side by side. It refers to the fragments of
/// the map that it was made from, which must outlive it.
class DetachedBackEnd {
 public:
  /// The odometry's information is multiplied by `odometry_factor` before the back end sees it.
  DetachedBackEnd(const BackEndOptions& options, Span<const Fragment> fragments, double odometry_factor);
  [[nodiscard]] BackEnd& operator*() { return *back_end_; }
  [[nodiscard]] BackEnd* operator->() { return &*back_end_; }

 private:
  Arena arena_;
  std::vector<std::vector<FragmentFrame>> frames_;
  std::vector<Fragment> fragments_;
  std::optional<BackEnd> back_end_;
};

class OfflineMap {
 public:
  /// Reads the whole recording. Errors: a source of unknown length, no frame with a pose, a fragment without
  /// any usable frame before others that have some (its number could not be held), fewer than three frames
  /// with a pose, depth that gives no surfel at all, a source that is lost.
  [[nodiscard]] static Expected<std::unique_ptr<OfflineMap>> build(FrameSource& source,
                                                                   const GivenOdometry& odometry,
                                                                   const OfflineMapOptions& options);

  [[nodiscard]] Span<const Fragment> fragments() const { return parts_.store.fragments(); }
  /// All frames of all fragments, in order, with the poses that they were given.
  [[nodiscard]] const std::vector<OdometryPose>& frames() const { return frames_; }
  /// With every fragment and the odometry's graph; no loops yet. In the order of the options.
  [[nodiscard]] BackEnd& back_end(std::size_t which) { return parts_.back_ends[which]; }
  /// With every fragment; for any thread, while others make and use theirs.
  [[nodiscard]] std::unique_ptr<DetachedBackEnd> make_back_end(ScoreKind score, double odometry_factor) const;
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
  [[nodiscard]] Status check_content() const;
  [[nodiscard]] Status start_fragment(int fragment);
  [[nodiscard]] Status close_fragment();
  void fuse(const PosedFrame& posed);

  OfflineMapOptions options_;
  SourceInfo info_;
  Arena arena_;
  Parts parts_;
  std::vector<OdometryPose> frames_;
  RunFigures figures_;
};

}  // namespace loopsift::tool
