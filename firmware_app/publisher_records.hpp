// SPDX-License-Identifier: MIT
// What the other threads hand to the publisher, and what it hands to them: fixed-size values in camera axes
// (x right, y down, z forward), copied through a ring. Never allocates.
#pragma once
#include <array>
#include <cstdint>
#include <limits>

#include "core/geometry/se3.hpp"

namespace loopsift {

/// The newest pose. Goes out as POSE_ODOM, LOOPSIFT_POSE and, where it is anchored, POSE.
struct PoseRecord {
  std::int64_t timestamp_ns = 0;  ///< of the depth image
  Se3 T_odom_camera;
  Se3 T_map_odom;          ///< of the correction that is in force
  std::int32_t epoch = 0;  ///< of that correction
  Matrix6d information =
      Matrix6d::Zero();          ///< of the motion since the pose before, as in TrackingResult; zero: unknown
  std::int64_t captured_ns = 0;  ///< steady clock, when the frame reached the program
  std::int32_t piece = 0;        ///< number of the frame that the piece of odometry began with
  bool anchored = true;  ///< false: tracking was lost before the piece, no accepted loop joins it to the map
};

/// A correction that was just applied. Goes out as LOOPSIFT_CORRECTION and, where the newest pose is
/// anchored, LOOPSIFT_UPDATE.
struct CorrectionRecord {
  std::int64_t timestamp_ns = 0;    ///< of the newest frame when it was applied
  std::int32_t epoch = 0;           ///< from 1; 0 is the uncorrected start
  std::int32_t frame_decided = -1;  ///< newest frame when the map was solved
  Se3 T_odom_camera;                ///< newest pose, by which the jump is measured
  Se3 T_map_odom;
  Se3 T_map_odom_before;
  std::int32_t piece = 0;  ///< of the newest fragment when the map was solved: frame that it began with
  bool anchored = true;    ///< whether that piece is joined to the map; else T_map_odom is not known
  std::int64_t covariance_timestamp_ns = 0;  ///< of the pose that covariance is of
  Matrix6d covariance = Matrix6d::Constant(
      std::numeric_limits<double>::quiet_NaN());  ///< of T_map_camera at that time, (t, ω),
                                                  ///< perturbed on the right; NaN: not known
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

/// As the constants of loopsift.command_t.
enum class CommandKind : std::int8_t { kSave = 1, kPause = 2, kResume = 3, kResend = 4, kFinish = 5 };

/// Who wants what: enough to answer.
struct Command {
  std::int64_t sender = 0;
  std::int32_t number = 0;
  CommandKind kind = CommandKind::kResume;
};

/// As the constants of loopsift.ack_t.
enum class AckStatus : std::int8_t { kDone = 0, kStarted = 1, kRefused = 2 };

/// The answer to a command. Goes out as LOOPSIFT_ACK.
struct AckRecord {
  Command command;
  AckStatus status = AckStatus::kDone;
  std::array<char, 128> message{};  ///< zero-terminated, cut to fit
};

/// With a message that is cut to fit.
[[nodiscard]] AckRecord answer(const Command& command, AckStatus status, const char* message);

}  // namespace loopsift
