// SPDX-License-Identifier: MIT
// Odometry from a file: poses that someone else tracked, with the same result type.
// In: a Trajectory (TUM or redwood .log). Out: TrackingResult per frame. Thread: front. Allocates when opened
// only.
#pragma once
#include <cstdint>
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/trajectory.hpp"
#include "core/odometry/external_odometry.hpp"

namespace loopsift {

struct TrajectoryOdometryOptions : MotionNoise {
  double max_gap_s = 0.1;  ///< poses farther apart are not interpolated
};

class TrajectoryOdometry final : public ExternalOdometry {
 public:
  /// Errors: those of read_trajectory, and a file without poses.
  [[nodiscard]] static Expected<TrajectoryOdometry> open(const std::string& path,
                                                         const TrajectoryOdometryOptions& options);
  TrajectoryOdometry(Trajectory trajectory, const TrajectoryOdometryOptions& options);
  /// The pose of a frame: by its number when the trajectory is indexed, else by its time stamp.
  TrackingResult track(FrameId frame, std::int64_t timestamp_ns) override;

 private:
  Trajectory trajectory_;
  double max_gap_s_;
  PoseChain chain_;
};

}  // namespace loopsift
