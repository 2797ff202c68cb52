// SPDX-License-Identifier: MIT
#include "core/odometry/odometry.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/odometry/alignment.hpp"

namespace loopsift {
namespace {

constexpr float kSureInliers = 0.75F;     // of the pixels that fall on the model: of a pose after a gap
constexpr float kSureDegeneracy = 0.15F;  // the same
constexpr int kMinPixels = 200;           // with depth, or with a partner, on the finest level used

Status out_of_range(const char* key, const char* range) {
  return Error{ErrorCode::kUsage, std::string("odometry.") + key + " must be " + range};
}

// Share of the prior in the least known direction: 1 / (1 + smallest eigenvalue of P^-½ M P^-½).
float degeneracy_of(const Matrix6d& measured, const Matrix6d& prior) {
  const Vector6d s = prior.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d scaled = s.asDiagonal() * measured * s.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scaled, Eigen::EigenvaluesOnly);
  return static_cast<float>(1.0 / (1.0 + std::max(0.0, eigen.eigenvalues()[0])));
}

LostReason check(const OdometryOptions& o, const IcpSystem& system, const Vector6d& from_prediction) {
  if (system.valid < kMinPixels) return LostReason::kNoDepth;
  if (system.partners < kMinPixels) return LostReason::kNoModel;
  if (static_cast<float>(system.inliers) < o.min_inlier_fraction * static_cast<float>(system.valid))
    return LostReason::kFewInliers;
  if (from_prediction.head<3>().norm() > static_cast<double>(o.max_step_m) ||
      from_prediction.tail<3>().norm() > static_cast<double>(o.max_step_rad))
    return LostReason::kLargeMotion;
  return LostReason::kNone;
}

// The keyframe where its intensities can be compared, else null.
const Keyframe* with_intensity(const OdometryOptions& o, const Frame& frame, const Keyframe* keyframe) {
  const bool both = keyframe != nullptr && keyframe->has_intensity() && !frame.levels[0].intensity.empty();
  return o.photometric && both ? keyframe : nullptr;
}

}  // namespace

const char* to_string(LostReason reason) {
  switch (reason) {
    case LostReason::kNone:
      return "tracked";
    case LostReason::kNoDepth:
      return "too little depth (lens covered, too near, too far)";
    case LostReason::kNoModel:
      return "the map is out of sight";
    case LostReason::kFewInliers:
      return "too little agrees with the map";
    case LostReason::kLargeMotion:
      return "too large a motion";
    case LostReason::kNoPose:
      return "the odometry given has no pose for this time";
    case LostReason::kBadTime:
      return "time stamp not after the one before";
  }
  return "unknown";
}

Status validate(const OdometryOptions& o) {
  if (o.finest_level < 0) return out_of_range("finest_level", "0 or more");
  if (o.iterations_coarse < 1) return out_of_range("iterations_coarse", "1 or more");
  if (o.iterations_fine < 1) return out_of_range("iterations_fine", "1 or more");
  if (!(o.gate_coarse_m > 0)) return out_of_range("gate_coarse_m", "more than 0");
  if (!(o.gate_fine_m > 0)) return out_of_range("gate_fine_m", "more than 0");
  if (!(o.min_normal_cosine >= 0 && o.min_normal_cosine < 1))
    return out_of_range("min_normal_cosine", "from 0 to below 1");
  if (!(o.noise_floor_m > 0)) return out_of_range("noise_floor_m", "more than 0");
  if (!(o.noise_slope >= 0)) return out_of_range("noise_slope", "0 or more");
  if (!(o.prior_sigma_m > 0)) return out_of_range("prior_sigma_m", "more than 0");
  if (!(o.prior_sigma_rad > 0)) return out_of_range("prior_sigma_rad", "more than 0");
  if (!(o.correlated_pixels >= 1)) return out_of_range("correlated_pixels", "1 or more");
  if (!(o.photometric_floor_m > 0)) return out_of_range("photometric_floor_m", "more than 0");
  if (!(o.photometric_floor_rad > 0)) return out_of_range("photometric_floor_rad", "more than 0");
  if (!(o.min_inlier_fraction > 0 && o.min_inlier_fraction < 1))
    return out_of_range("min_inlier_fraction", "between 0 and 1");
  if (!(o.max_step_m > 0)) return out_of_range("max_step_m", "more than 0");
  if (!(o.max_step_rad > 0)) return out_of_range("max_step_rad", "more than 0");
  return {};
}

Odometry::Odometry(const OdometryOptions& options) : options_(options) {}

Se3 Odometry::predict(std::int64_t timestamp_ns) const {
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_);
  if (!moving_ || dt_s <= 0 || dt_s > kMaxPredictionS) return T_odom_camera_;
  return T_odom_camera_ * Se3::exp(velocity_ * dt_s);
}

TrackingResult Odometry::track(const Frame& frame, const ModelView& model, const Keyframe* keyframe,
                               const Se3* T_odom_other) {
  const double periods = periods_to(frame.timestamp_ns);
  Alignment alignment(options_, frame, model, predict(frame.timestamp_ns), periods,
                      with_intensity(options_, frame, keyframe));
  if (T_odom_other != nullptr) alignment.consider(*T_odom_other);
  alignment.run();
  const IcpSystem& system = alignment.system();
  TrackingResult result;
  result.T_odom_camera = T_odom_camera_;
  result.iterations = alignment.iterations();
  result.reason = check(options_, system, alignment.from_prediction());
  if (system.valid > 0)
    result.inlier_fraction = static_cast<float>(system.inliers) / static_cast<float>(system.valid);
  if (system.inliers > 0)
    result.residual_rms_m = static_cast<float>(std::sqrt(system.squares_m2 / system.inliers));
  result.degeneracy = degeneracy_of(alignment.measured(), prior_information(options_, 1.0));
  const bool sure = static_cast<float>(system.inliers) >= kSureInliers * static_cast<float>(system.met) &&
                    result.degeneracy <= kSureDegeneracy;
  if (result.reason == LostReason::kNone && periods >= kGapPeriods && !sure)
    result.reason = LostReason::kFewInliers;
  if (result.reason != LostReason::kNone) return result;

  result.status = TrackingStatus::kTracked;
  result.T_odom_camera = alignment.T_odom_camera();
  result.information = alignment.information_since(T_odom_camera_);
  result.keyframe_overlap = alignment.keyframe_overlap();
  move_to(result.T_odom_camera, frame.timestamp_ns);
  return result;
}

double Odometry::periods_to(std::int64_t timestamp_ns) const {
  return std::clamp(1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_) / kPeriodS, 1.0, kMaxPeriods);
}

void Odometry::move_to(const Se3& T_odom_camera, std::int64_t timestamp_ns) {
  const double dt_s = 1e-9 * static_cast<double>(timestamp_ns - timestamp_ns_);
  moving_ = dt_s > 0 && dt_s <= kMaxPredictionS;
  if (moving_) velocity_ = (T_odom_camera_.inverse() * T_odom_camera).log() / dt_s;
  T_odom_camera_ = T_odom_camera;
  timestamp_ns_ = timestamp_ns;
}

TrackingResult Odometry::start(const Frame& frame, const Se3& T_odom_camera) {
  TrackingResult result;
  result.T_odom_camera = T_odom_camera;
  if (frame.valid_fraction * static_cast<float>(frame.levels[0].depth_m.size()) <
      static_cast<float>(kMinPixels)) {
    result.reason = LostReason::kNoDepth;
    return result;
  }
  T_odom_camera_ = T_odom_camera;
  timestamp_ns_ = frame.timestamp_ns;
  moving_ = false;
  result.status = TrackingStatus::kFirst;
  return result;
}

}  // namespace loopsift
