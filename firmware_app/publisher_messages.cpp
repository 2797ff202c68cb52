// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_messages.hpp"

#include <algorithm>
#include <cstring>

namespace loopsift {
namespace {

/// Body X is the camera's z, body Y its −x, body Z its −y.
Eigen::Matrix3d camera_to_body() { return (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished(); }

std::int64_t microseconds(std::int64_t timestamp_ns) { return timestamp_ns / 1000; }

/// trans and quat (w, x, y, z) of any of the messages.
template <class Scalar>
void set_transform(const Se3& T, Scalar (&trans)[3], Scalar (&quat)[4]) {
  const Eigen::Quaterniond q = T.quaternion();
  for (int i = 0; i < 3; ++i) trans[i] = T.translation()[i];
  quat[0] = q.w();
  quat[1] = q.x();
  quat[2] = q.y();
  quat[3] = q.z();
}

}  // namespace

Se3 in_body_axes(const Se3& T) {
  const Eigen::Matrix3d R = camera_to_body();
  return {R * T.rotation() * R.transpose(), R * T.translation()};
}

void BodyVelocity::update(std::int64_t timestamp_ns, const Se3& T_odom_body) {
  const double dt_s = static_cast<double>(timestamp_ns - previous_ns_) * 1e-9;
  if (has_previous_ && dt_s > 0 && dt_s <= 1.0) {
    // log of the motion is a constant twist; it is the same in the body frames at both its ends.
    value_ = (T_odom_previous_.inverse() * T_odom_body).log() / dt_s;
  } else {
    value_.setZero();
  }
  has_previous_ = true;
  previous_ns_ = timestamp_ns;
  T_odom_previous_ = T_odom_body;
}

void fill(bot_core::pose_t* message, std::int64_t timestamp_ns, const Se3& T_local_body,
          const Vector6d& velocity) {
  message->utime = microseconds(timestamp_ns);
  set_transform(T_local_body, message->pos, message->orientation);
  for (int i = 0; i < 3; ++i) {
    message->vel[i] = velocity[i];
    message->rotation_rate[i] = velocity[3 + i];
    message->accel[i] = 0;
  }
}

void fill(bot_frames::update_t* message, const CorrectionRecord& record) {
  message->utime = microseconds(record.timestamp_ns);
  message->frame = "odom";
  message->relative_to = "map";
  set_transform(in_body_axes(record.T_map_odom), message->trans, message->quat);
}

void fill(correction_t* message, const CorrectionRecord& record) {
  message->utime = microseconds(record.timestamp_ns);
  message->epoch = record.epoch;
  message->frame_decided = record.frame_decided;
  message->T_map_odom.utime = message->utime;
  set_transform(in_body_axes(record.T_map_odom), message->T_map_odom.trans, message->T_map_odom.quat);
  const Se3 jump =
      (record.T_map_odom_before * record.T_odom_camera).inverse() * record.T_map_odom * record.T_odom_camera;
  message->jump_translation_m = jump.translation().norm();
  message->jump_rotation_rad = jump.angle();
  Matrix6d J = Matrix6d::Zero();  // (t, ω) of the camera to (t, ω) of the body
  J.topLeftCorner<3, 3>() = camera_to_body();
  J.bottomRightCorner<3, 3>() = camera_to_body();
  const Matrix6d covariance = J * record.covariance * J.transpose();
  for (int row = 0; row < 6; ++row)
    for (int col = 0; col < 6; ++col) message->covariance[6 * row + col] = covariance(row, col);
  const auto count = std::clamp<std::size_t>(static_cast<std::size_t>(std::max(record.fragment_count, 0)), 0,
                                             CorrectionRecord::kMaxFragments);
  message->n_fragments = static_cast<std::int32_t>(count);
  message->T_map_fragment.resize(count);
  for (std::size_t f = 0; f < count; ++f)
    set_transform(in_body_axes(record.T_map_fragment[f]), message->T_map_fragment[f].trans,
                  message->T_map_fragment[f].quat);
}

void fill(loop_t* message, const LoopRecord& record) {
  message->utime = microseconds(record.timestamp_ns);
  message->id = record.id;
  message->fragment_i = record.fragment_i;
  message->fragment_j = record.fragment_j;
  set_transform(in_body_axes(record.T_i_j), message->T_i_j.trans, message->T_i_j.quat);
  message->single_dmp = record.single_dmp;
  message->rank = record.rank;
  message->tested_dmp = record.tested_dmp;
  message->best_dmp_before = record.best_dmp_before;
  message->decision = static_cast<std::int8_t>(record.decision);
  message->reason.assign(record.reason.data(), strnlen(record.reason.data(), record.reason.size() - 1));
  message->frame_decided = record.frame_decided;
}

void reserve(bot_frames::update_t* message) {
  message->frame.reserve(16);
  message->relative_to.reserve(16);
}

void reserve(correction_t* message) { message->T_map_fragment.reserve(CorrectionRecord::kMaxFragments); }

void reserve(loop_t* message) { message->reason.reserve(std::tuple_size_v<decltype(LoopRecord::reason)>); }

}  // namespace loopsift
