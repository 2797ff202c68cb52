// SPDX-License-Identifier: MIT
// What a run measured about itself, in one plain struct: filled by the pipeline and the program around it,
// written as run.json. Allocates only in `source` and `pools` (set-up and end of a run).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/base/latency_histogram.hpp"

namespace loopsift {

/// What is timed. The names in run.json are those of stage_name(), in this order.
enum class Stage {
  kOdometry,       ///< front thread: tracking one frame
  kFusion,         ///< front thread: fusing one frame
  kFrame,          ///< front thread: one frame, everything
  kCaptureToPose,  ///< from the frame's arrival on the host to its pose leaving the front thread
  kProposal,       ///< back thread: all registrations of one new fragment
  kLoopSolve,      ///< back thread: one pose graph solve
  kLoopScore,      ///< back thread: one evaluation of the score
  kLoopTest,       ///< back thread: one loop, solved and scored
  kCorrection,     ///< from the arrival of the deciding frame to the correction leaving the back thread
};
inline constexpr std::size_t kStageCount = 9;
inline constexpr std::array<const char*, kStageCount> kStageNames = {
    "odometry",   "fusion",     "frame",     "capture_to_pose", "proposal",
    "loop_solve", "loop_score", "loop_test", "correction"};

/// A fixed-size store at the end of a run.
struct PoolFigures {
  std::string name;             ///< "part/what"
  std::int64_t capacity = 0;    ///< elements
  std::int64_t high_water = 0;  ///< most that were in use at once
  std::int64_t refused = 0;     ///< requests while full
};

struct RunFigures {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  std::string source;              ///< as SourceInfo::description
  double sequence_duration_s = 0;  ///< last minus first time stamp
  double wall_s = 0;               ///< first frame read to last file written

  struct Frames {
    std::int64_t received = 0;  ///< delivered by the source, unusable ones included
    std::int64_t dropped = 0;   ///< unusable, or pushed out of a full queue
    std::int64_t tracked = 0;
    std::int64_t lost = 0;  ///< looked at, but without a pose
  } frames;

  std::array<LatencyHistogram, kStageCount> latency;
  LatencyHistogram& operator[](Stage stage) { return latency[static_cast<std::size_t>(stage)]; }

  struct Loops {
    std::int64_t proposed = 0;
    std::int64_t scored = 0;    ///< step 1 of Algorithm 1: alone
    std::int64_t tested = 0;    ///< step 3 of Algorithm 1: on top of the accepted ones
    std::int64_t accepted = 0;  ///< at the end
    std::int64_t revoked = 0;   ///< once accepted, taken back
    std::int64_t dropped = 0;   ///< pushed out of a full list
    std::int64_t pending = 0;   ///< not looked at when the run ended
  } loops;

  /// Dense map posterior over the score views, m²; kUnknown when it was not evaluated.
  struct Dmp {
    double odometry_m2 = kUnknown;  ///< of the map without any loop
    double final_m2 = kUnknown;
    std::int64_t views = 0;
  } dmp;

  /// Heap figures are absent when the run did not count them.
  struct Memory {
    std::int64_t budget_bytes = 0;
    std::int64_t cap_bytes = 0;
    std::int64_t peak_rss_bytes = 0;  ///< largest resident set of the process
    std::optional<std::int64_t> capture_heap_calls;
    std::optional<std::int64_t> front_heap_calls;
    std::optional<std::int64_t> publish_heap_calls;
    std::optional<std::int64_t> camera_library_heap_calls;  ///< of the capture thread, within the library
    std::optional<std::int64_t> fence_peak_bytes;
    std::optional<std::int64_t> fence_refusals;
  } memory;

  std::vector<PoolFigures> pools;
};

}  // namespace loopsift
