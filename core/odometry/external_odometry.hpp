// SPDX-License-Identifier: MIT
// Poses that someone else tracks: from a file, or as they come. In: a frame's number and time stamp. Out: a
// TrackingResult as the built-in odometry gives it. Such poses do not say how sure they are: that is assumed,
// by the length of the motion. Thread: front.
#pragma once
#include <cstdint>
#include <string>

#include "core/base/ids.hpp"
#include "core/geometry/se3.hpp"
#include "core/odometry/odometry.hpp"

namespace loopsift {

/// What is assumed of the error of a motion.
struct MotionNoise {
  float sigma_m_per_m = 0.02F;      ///< drift per metre of path
  float sigma_rad_per_rad = 0.02F;  ///< the same for rotation
  float sigma_floor_m = 0.001F;     ///< per frame
  float sigma_floor_rad = 0.001F;   ///< per frame
  /// The information of one motion, (t, ω).
  [[nodiscard]] Matrix6d information(const Se3& T_before_now) const;
};

class ExternalOdometry {
 public:
  virtual ~ExternalOdometry() = default;
  /// kLost (kNoPose) where there is no pose for this time; kFirst at the first pose and after a loss.
  [[nodiscard]] virtual TrackingResult track(FrameId frame, std::int64_t timestamp_ns) = 0;
  /// For a person, at the end of a run: what came, and what was wrong with it. Empty: nothing to say.
  /// Allocates.
  [[nodiscard]] virtual std::string summary() const { return {}; }
};

/// The results of poses found one after the other. Never allocates.
class PoseChain {
 public:
  explicit PoseChain(const MotionNoise& noise) : noise_(noise) {}
  [[nodiscard]] TrackingResult found(const Se3& T_odom_camera);
  [[nodiscard]] TrackingResult missing();
  /// What comes next does not hang together with what was.
  void cut() { tracking_ = false; }

 private:
  MotionNoise noise_;
  Se3 T_odom_camera_;
  bool tracking_ = false;
};

}  // namespace loopsift
