// SPDX-License-Identifier: MIT
// How well the newest corrected pose is known: what the map says about an older pose, plus what the odometry
// added since. Covariances are of T_map_camera, (t, ω), perturbed on the right. In the odometry's world,
// increments add up (Σ_w += Ad(T) Σ_motion Adᵀ), so the growth between any two times is a difference; a ring
// of the last kHistory frames remembers the sums. Thread: publish. Never allocates.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/geometry/se3.hpp"

namespace loopsift {

class CovarianceTracker {
 public:
  static constexpr std::size_t kHistory = 1024;  // half a minute of frames

  /// The next frame. information: of the motion since the frame before; zero or singular: unknown, which adds
  /// nothing.
  void add(std::int64_t timestamp_ns, const Se3& T_odom_camera, const Matrix6d& information);
  /// The map's word on the pose at a time: replaces what was known. A time that is no longer remembered
  /// counts as the oldest one that is; a covariance that is not finite is ignored.
  void correct(std::int64_t timestamp_ns, const Matrix6d& covariance);
  /// Of the newest pose. Zero before the second one: the map begins at the first.
  [[nodiscard]] Matrix6d newest() const;

 private:
  struct Entry {
    std::int64_t timestamp_ns = 0;
    Se3 T_odom_camera;
    Matrix6d sum = Matrix6d::Zero();  // of all motions so far, perturbed on the left, odom
  };
  [[nodiscard]] const Entry& newest_entry() const { return ring_[(count_ - 1) % kHistory]; }
  [[nodiscard]] const Entry& entry_at(std::int64_t timestamp_ns) const;

  std::array<Entry, kHistory> ring_;
  std::size_t count_ = 0;                 // of frames so far
  Matrix6d base_ = Matrix6d::Zero();      // what the map knew at its time, perturbed on the left, odom
  Matrix6d base_sum_ = Matrix6d::Zero();  // the sum at that time
};

}  // namespace loopsift
