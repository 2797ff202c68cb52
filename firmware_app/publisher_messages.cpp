// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_messages.hpp"

#include <algorithm>
#include <cstring>

namespace loopsift {
namespace {

/// Body X is the camera's z, body Y its −x, body Z its −y.
Eigen::Matrix3d camera_to_body() { return (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished(); }

constexpr std::int32_t kPerChunk = fragment_t::SURFELS_PER_CHUNK;

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

void set_matrix(const Matrix6d& matrix, double (&out)[36]) {
  for (int row = 0; row < 6; ++row)
    for (int col = 0; col < 6; ++col) out[6 * row + col] = matrix(row, col);
}

/// A zero-terminated text into a string that has room for it.
template <std::size_t N>
void set_text(const std::array<char, N>& text, std::string* out) {
  out->assign(text.data(), strnlen(text.data(), N - 1));
}

}  // namespace

Se3 in_body_axes(const Se3& T) {
  const Eigen::Matrix3d R = camera_to_body();
  return {R * T.rotation() * R.transpose(), R * T.translation()};
}

Se3 exactly_in_body_axes(const Se3& T) {
  constexpr int kAxis[3] = {2, 0, 1};  // of the camera, along which the body's lie
  constexpr double kSign[3] = {1, -1, -1};
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  for (int i = 0; i < 3; ++i) {
    t[i] = kSign[i] * T.translation()[kAxis[i]];
    for (int j = 0; j < 3; ++j) R(i, j) = kSign[i] * kSign[j] * T.rotation()(kAxis[i], kAxis[j]);
  }
  return {R, t};
}

Matrix6d in_body_axes(const Matrix6d& matrix) {
  Matrix6d J = Matrix6d::Zero();  // (t, ω) of the camera to (t, ω) of the body
  J.topLeftCorner<3, 3>() = camera_to_body();
  J.bottomRightCorner<3, 3>() = camera_to_body();
  return J * matrix * J.transpose();
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

void fill(transform_t* message, const Se3& T) {
  set_transform(in_body_axes(T), message->trans, message->quat);
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

void fill(pose_t* message, const PoseRecord& record, const Matrix6d& covariance) {
  message->utime = microseconds(record.timestamp_ns);
  message->epoch = record.epoch;
  fill(&message->T_odom_body, record.T_odom_camera);
  message->piece = record.piece;
  message->anchored = record.anchored ? 1 : 0;
  fill(&message->T_map_body, record.T_map_odom * record.T_odom_camera);
  set_matrix(in_body_axes(covariance), message->covariance);
}

void fill(bot_frames::update_t* message, const CorrectionRecord& record) {
  message->utime = microseconds(record.timestamp_ns);
  message->frame = "odom";
  message->relative_to = "map";
  set_transform(in_body_axes(record.T_map_odom), message->trans, message->quat);
}

void fill(correction_t* message, const CorrectionRecord& record, const Matrix6d& covariance) {
  message->utime = microseconds(record.timestamp_ns);
  message->epoch = record.epoch;
  message->frame_decided = record.frame_decided;
  message->anchored = record.anchored ? 1 : 0;
  message->T_map_odom.utime = message->utime;
  set_transform(in_body_axes(record.T_map_odom), message->T_map_odom.trans, message->T_map_odom.quat);
  const Se3 jump =
      (record.T_map_odom_before * record.T_odom_camera).inverse() * record.T_map_odom * record.T_odom_camera;
  message->jump_translation_m = jump.translation().norm();
  message->jump_rotation_rad = jump.angle();
  set_matrix(in_body_axes(covariance), message->covariance);
}

void fill(loop_t* message, const LoopRecord& record) {
  message->utime = microseconds(record.timestamp_ns);
  message->id = record.id;
  message->fragment_i = record.fragment_i;
  message->fragment_j = record.fragment_j;
  fill(&message->T_i_j, record.T_i_j);
  message->single_dmp = record.single_dmp;
  message->rank = record.rank;
  message->tested_dmp = record.tested_dmp;
  message->best_dmp_before = record.best_dmp_before;
  message->decision = static_cast<std::int8_t>(record.decision);
  set_text(record.reason, &message->reason);
  message->frame_decided = record.frame_decided;
}

void fill(ack_t* message, const AckRecord& record) {
  message->sender = record.command.sender;
  message->number = record.command.number;
  message->command = static_cast<std::int8_t>(record.command.kind);
  message->status = static_cast<std::int8_t>(record.status);
  set_text(record.message, &message->message);
}

std::int32_t chunk_count(const Fragment& fragment) {
  const auto surfels = static_cast<std::int32_t>(fragment.surfels.size());
  return std::max(1, (surfels + kPerChunk - 1) / kPerChunk);
}

void fill(fragment_t* message, const Fragment& fragment, std::int32_t chunk) {
  const SurfelSpan& s = fragment.surfels;
  const std::size_t first = static_cast<std::size_t>(chunk) * kPerChunk;
  const std::size_t count = std::min<std::size_t>(s.size() - first, kPerChunk);
  *message = fragment_t{};
  message->utime = fragment.frames.empty() ? 0 : microseconds(fragment.frames[0].timestamp_ns);
  message->fragment = fragment.id.value;
  message->surfel_count = static_cast<std::int32_t>(s.size());
  message->chunk_count = chunk_count(fragment);
  message->chunk = chunk;
  message->n = static_cast<std::int32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {  // body X is the camera's z, Y its −x, Z its −y
    const std::size_t from = first + i;
    message->x[i] = s.z[from];
    message->y[i] = -s.x[from];
    message->z[i] = -s.y[from];
    message->nx[i] = s.nz[from];
    message->ny[i] = -s.nx[from];
    message->nz[i] = -s.ny[from];
    message->radius[i] = s.radius[from];
    message->confidence[i] = s.weight[from];
    message->red[i] = static_cast<std::uint8_t>(s.rgb[from] >> 16);
    message->green[i] = static_cast<std::uint8_t>(s.rgb[from] >> 8);
    message->blue[i] = static_cast<std::uint8_t>(s.rgb[from]);
  }
}

void reserve(bot_frames::update_t* message) {
  message->frame.reserve(16);
  message->relative_to.reserve(16);
}

void reserve(loop_t* message) { message->reason.reserve(std::tuple_size_v<decltype(LoopRecord::reason)>); }

void reserve(ack_t* message) { message->message.reserve(std::tuple_size_v<decltype(AckRecord::message)>); }

AckRecord answer(const Command& command, AckStatus status, const char* message) {
  AckRecord record;
  record.command = command;
  record.status = status;
  std::strncpy(record.message.data(), message, record.message.size() - 1);
  return record;
}

}  // namespace loopsift
