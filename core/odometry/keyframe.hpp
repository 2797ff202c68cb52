// SPDX-License-Identifier: MIT
// A frame kept to track against besides the model: its points and intensities. In: a Frame at a known pose.
// Out: what photometric.hpp compares later frames with. Capacity: one frame, from the arena. Thread: front.
// No allocation after construction.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/frame/frame.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift {

/// A motion in units of one after which a camera sees its surroundings in other places of its image, and
/// needs another keyframe: 0.3 m or 0.35 rad. (t, ω).
[[nodiscard]] inline double share_of_view(const Vector6d& moved) {
  return std::max(moved.head<3>().norm() / 0.3, moved.tail<3>().norm() / 0.35);
}

class Keyframe {
 public:
  struct Level {
    PinholeCamera camera;
    ImageView<const float> depth_m;    ///< metres; 0 where there is no depth or no normal (an edge)
    ImageView<const float> intensity;  ///< logarithmic
  };

  /// For frames whose level 0 has this camera.
  Keyframe(const PinholeCamera& working, int levels, Arena& arena);
  /// Copies the frame.
  void keep(const Frame& frame, const Se3& T_odom_key);
  void clear() { level_count_ = 0; }
  [[nodiscard]] bool empty() const { return level_count_ == 0; }
  /// Whether it can be compared by intensity.
  [[nodiscard]] bool has_intensity() const { return !empty() && has_intensity_; }
  /// Unit normal of level 0 where level(0) has a depth, keyframe's camera.
  [[nodiscard]] Eigen::Vector3f normal(int x, int y) const {
    const auto k = static_cast<std::size_t>(y * levels_[0].camera.width + x);
    return {normals_[0][k], normals_[1][k], normals_[2][k]};
  }
  /// By which its depth was corrected.
  [[nodiscard]] const DisparityCoefficients& disparity_coefficients() const {
    return disparity_coefficients_;
  }
  [[nodiscard]] const Se3& T_odom_key() const { return T_odom_key_; }
  [[nodiscard]] const Level& level(int l) const { return levels_[static_cast<std::size_t>(l)]; }
  /// Pixels of level 0 that have depth.
  [[nodiscard]] int valid() const { return valid_; }

 private:
  struct Storage {
    Span<float> depth, intensity;
  };
  std::array<Storage, kMaxFrameLevels> storage_;
  std::array<Level, kMaxFrameLevels> levels_;
  std::array<Span<float>, 3> normals_;
  Se3 T_odom_key_;
  DisparityCoefficients disparity_coefficients_ = DisparityCoefficients::Zero();
  bool has_intensity_ = false;
  int level_count_ = 0, valid_ = 0;
};

}  // namespace loopsift
