// SPDX-License-Identifier: MIT
// From the program's records to LCM messages. Messages use axes X forward, Y left, Z up, as bot_core.pose_t
// wants them, so every transform T between camera-like frames goes out as B T B⁻¹ with B the turn from camera
// to body axes. Thread: publish. The functions write into messages that exist already and do not allocate
// once these have room (reserve()).
#pragma once
#include <bot_core/pose_t.hpp>
#include <bot_frames/update_t.hpp>
#include <loopsift/ack_t.hpp>
#include <loopsift/correction_t.hpp>
#include <loopsift/fragment_t.hpp>
#include <loopsift/loop_t.hpp>
#include <loopsift/pose_t.hpp>

#include "core/fragment/fragment.hpp"
#include "firmware_app/publisher_records.hpp"

namespace loopsift {

/// T between camera-like frames, in body axes.
[[nodiscard]] Se3 in_body_axes(const Se3& T);
/// The same by permuting and negating elements alone: turning back gives every bit again.
[[nodiscard]] Se3 exactly_in_body_axes(const Se3& T);
/// A covariance or information of (t, ω) perturbed on the right, in body axes.
[[nodiscard]] Matrix6d in_body_axes(const Matrix6d& matrix);

/// Velocities for pose_t, from one odometry pose to the next: m/s and rad/s in the later body frame. Zero for
/// the first pose, after more than a second without one, and when time does not advance.
class BodyVelocity {
 public:
  void update(std::int64_t timestamp_ns, const Se3& T_odom_body);
  [[nodiscard]] const Vector6d& value() const { return value_; }  ///< (v, ω)

 private:
  bool has_previous_ = false;
  std::int64_t previous_ns_ = 0;
  Se3 T_odom_previous_;
  Vector6d value_ = Vector6d::Zero();
};

// run is left to the caller where a message has it.
void fill(transform_t* message, const Se3& T);  ///< T between camera-like frames
void fill(bot_core::pose_t* message, std::int64_t timestamp_ns, const Se3& T_local_body,
          const Vector6d& velocity);
void fill(pose_t* message, const PoseRecord& record, const Matrix6d& covariance);
void fill(bot_frames::update_t* message, const CorrectionRecord& record);
/// covariance: of the newest camera pose in map.
void fill(correction_t* message, const CorrectionRecord& record, const Matrix6d& covariance);
void fill(loop_t* message, const LoopRecord& record);
void fill(ack_t* message, const AckRecord& record);
/// Chunk k, which the fragment has.
void fill(fragment_t* message, const Fragment& fragment, std::int32_t chunk);
/// Messages that a fragment's surfels take; at least 1.
[[nodiscard]] std::int32_t chunk_count(const Fragment& fragment);

/// Makes room for the largest record.
void reserve(bot_frames::update_t* message);
void reserve(loop_t* message);
void reserve(ack_t* message);

}  // namespace loopsift
