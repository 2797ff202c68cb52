// SPDX-License-Identifier: MIT
#include "core/fragment/front_end.hpp"

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr float kKeyframeOverlap = 0.6F;  // of its points in sight

}  // namespace

Status validate(const FrontEndOptions& o) {
  for (Status status : {validate(o.frame), validate(o.odometry), validate(o.fragment), validate(o.model),
                        validate(o.depth_calibration)})
    if (!status) return status;
  if (o.lost_patience_frames < 0)
    return Error{ErrorCode::kUsage, "odometry.lost_patience_frames must be 0 or more"};
  return {};
}

FrontEnd::FrontEnd(const PinholeCamera& camera, double depth_unit_m, const FrontEndOptions& options,
                   FragmentStore* store, Arena& arena)
    : options_(options),
      store_(store),
      preprocessor_(camera, depth_unit_m, options.frame, arena),
      odometry_(options.odometry),
      builder_(options.fragment, preprocessor_.working_camera(), camera, arena),
      renderer_(options.model, preprocessor_.working_camera(), arena),
      keyframe_(preprocessor_.working_camera(), options.frame.levels, arena),
      turns_(preprocessor_.coarsest_camera(), arena),
      depth_calibration_(options.depth_calibration) {}

FrontEndResult FrontEnd::process(const RawFrame& raw) {
  const std::int64_t begin = steady_now_ns();
  const Frame& frame = preprocessor_.process(raw);
  const std::int64_t preprocessed = steady_now_ns();
  const TrackingResult tracking = track(frame, raw.session);
  keep_keyframe(frame, tracking);
  if (tracking.status != TrackingStatus::kLost) turns_.keep(frame);
  const std::int64_t tracked = steady_now_ns();
  FrontEndResult result = integrate(frame, tracking);
  result.times = {preprocessed - begin, tracked - preprocessed, steady_now_ns() - tracked};
  return result;
}

FrontEndResult FrontEnd::process(const RawFrame& raw, const TrackingResult& given) {
  const std::int64_t begin = steady_now_ns();
  const Frame& frame = preprocessor_.process(raw);
  const std::int64_t preprocessed = steady_now_ns();
  keep_keyframe(frame, given);
  FrontEndResult result = integrate(frame, given);
  result.times = {preprocessed - begin, 0, steady_now_ns() - preprocessed};
  return result;
}

TrackingResult FrontEnd::track(const Frame& frame, std::int32_t session) {
  // A clock that was set back for good makes a new piece, once patience is at its end.
  const bool impatient = lost_frames_ > options_.lost_patience_frames;
  const bool reopened = session != session_;
  if (frame.id.value > 0 && frame.timestamp_ns <= newest_timestamp_ns_ && !impatient) {
    TrackingResult refused;
    refused.reason = LostReason::kBadTime;
    refused.T_odom_camera = odometry_.T_odom_camera();
    return refused;
  }
  newest_timestamp_ns_ = frame.timestamp_ns;
  const Span<const Fragment> all = store_->fragments();
  const Span<const Fragment> piece(all.data() + piece_begin_, all.size() - piece_begin_);
  const bool no_model = builder_.empty() && piece.empty();
  if (no_model || impatient || reopened) {
    const TrackingResult started = odometry_.start(frame, odometry_.T_odom_camera());
    if (started.status == TrackingStatus::kFirst) session_ = session;
    return started;
  }
  const Se3 T_odom_predicted = odometry_.predict(frame.timestamp_ns);
  const ModelView& model = renderer_.render(piece, builder_.active().surfels(), builder_.T_odom_fragment(),
                                            T_odom_predicted, builder_.disparity_unknown());
  const Eigen::Matrix3d& R_odom_kept = odometry_.T_odom_camera().rotation();
  const auto R_kept_camera = turns_.find(frame, R_odom_kept.transpose() * T_odom_predicted.rotation());
  if (!R_kept_camera) return odometry_.track(frame, model, &keyframe_);
  const Se3 T_odom_turned(R_odom_kept * *R_kept_camera, T_odom_predicted.translation());
  return odometry_.track(frame, model, &keyframe_, &T_odom_turned);
}

// A new keyframe once the last one is largely out of sight or seen from elsewhere, and after a loss. The two
// show the same things in different places of the image, which tells the camera's error.
void FrontEnd::keep_keyframe(const Frame& frame, const TrackingResult& tracking) {
  if (tracking.status == TrackingStatus::kLost) return;
  if (tracking.status == TrackingStatus::kTracked && !keyframe_.empty()) {
    const Vector6d moved = (keyframe_.T_odom_key().inverse() * tracking.T_odom_camera).log();
    const bool near = share_of_view(moved) < 1;
    const bool in_sight = tracking.keyframe_overlap == 0 || tracking.keyframe_overlap > kKeyframeOverlap;
    const bool enough = keyframe_.has_intensity() == !frame.levels[0].intensity.empty();
    if (near && in_sight && enough) return;
    if (options_.depth_calibration.enabled &&
        depth_calibration_.add_pair(keyframe_, frame, tracking.T_odom_camera)) {
      preprocessor_.set_disparity(depth_calibration_.coefficients(), depth_calibration_.unknown());
    }
  }
  keyframe_.keep(frame, tracking.T_odom_camera);
}

FrontEndResult FrontEnd::integrate(const Frame& frame, const TrackingResult& tracking) {
  FrontEndResult result;
  result.frame = frame.id;
  result.timestamp_ns = frame.timestamp_ns;
  result.tracking = tracking;
  if (tracking.status == TrackingStatus::kLost) {
    ++lost_frames_;
    return result;
  }
  lost_frames_ = 0;
  if (tracking.status == TrackingStatus::kFirst) {
    result.closed = builder_.close(store_);  // what a loss left unfinished
    piece_begin_ = store_->fragments().size();
  }
  builder_.integrate(frame, tracking.T_odom_camera, tracking.information,
                     tracking.status == TrackingStatus::kTracked);
  if (builder_.full()) result.closed = builder_.close(store_);
  return result;
}

}  // namespace loopsift
