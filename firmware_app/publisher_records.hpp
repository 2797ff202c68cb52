// SPDX-License-Identifier: MIT
// What the front and back threads hand to the publisher: fixed-size values in camera axes (x right, y down, z
// forward), copied through a ring. Never allocates.
#pragma once
#include <array>
#include <cstdint>
#include <limits>

#include "core/geometry/se3.hpp"

namespace loopsift {

/// The newest pose. Goes out as POSE_ODOM and POSE.
struct PoseRecord {
  std::int64_t timestamp_ns = 0;  ///< of the depth image
  Se3 T_odom_camera;
  Se3 T_map_odom;  ///< of the correction that is in force
};

/// A correction that was just applied. Goes out as LOOPSIFT_CORRECTION and LOOPSIFT_UPDATE.
struct CorrectionRecord {
  static constexpr std::size_t kMaxFragments = 1024;  ///< keeps the message below 60 kB

  std::int64_t timestamp_ns = 0;    ///< of the newest frame when it was applied
  std::int32_t epoch = 0;           ///< from 1; 0 is the uncorrected start
  std::int32_t frame_decided = -1;  ///< newest frame when the map was solved
  Se3 T_odom_camera;                ///< newest pose, by which the jump is measured
  Se3 T_map_odom;
  Se3 T_map_odom_before;
  Matrix6d covariance =
      Matrix6d::Constant(std::numeric_limits<double>::quiet_NaN());  ///< of T_map_camera, (t, ω), perturbed
                                                                     ///< on the right; NaN: not known
  std::int32_t fragment_count = 0;                                   ///< at most kMaxFragments
  std::array<Se3, kMaxFragments> T_map_fragment;                     ///< the first fragment_count are valid
};

/// As the constants of loopsift.loop_t.
enum class LoopDecision : std::int8_t { kRejected = 0, kAccepted = 1, kRevoked = 2, kDropped = 3 };

/// A decision about one loop. Goes out as LOOPSIFT_LOOP.
struct LoopRecord {
  std::int64_t timestamp_ns = 0;  ///< of the newest frame at the decision
  std::int32_t id = -1;
  std::int32_t fragment_i = -1;
  std::int32_t fragment_j = -1;
  Se3 T_i_j;
  double single_dmp = 0;  ///< m²
  std::int32_t rank = -1;
  double tested_dmp = std::numeric_limits<double>::quiet_NaN();       ///< m²; NaN: not tested
  double best_dmp_before = std::numeric_limits<double>::quiet_NaN();  ///< m²; NaN: not tested
  LoopDecision decision = LoopDecision::kRejected;
  std::array<char, 64> reason{};  ///< zero-terminated, cut to fit
  std::int32_t frame_decided = -1;
};

}  // namespace loopsift
