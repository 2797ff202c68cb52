// SPDX-License-Identifier: MIT
#include "core/odometry/odometry.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/odometry/icp.hpp"

namespace loopsift {
namespace {

constexpr double kConvergedStep = 1e-5;  // metres or radians
constexpr int kMinPixels = 200;          // with depth, or with a partner, on the finest level used

Status out_of_range(const char* key, const char* range) {
  return Error{ErrorCode::kUsage, std::string("odometry.") + key + " must be " + range};
}

// The prior's information about the motion of one frame.
Matrix6d prior_information(const OdometryOptions& o) {
  Vector6d d;
  d.head<3>().setConstant(1.0 / std::pow(static_cast<double>(o.prior_sigma_m), 2));
  d.tail<3>().setConstant(1.0 / std::pow(static_cast<double>(o.prior_sigma_rad), 2));
  return d.asDiagonal();
}

// Share of the prior in the least known direction: 1 / (1 + smallest eigenvalue of P^-½ M P^-½).
float degeneracy_of(const Matrix6d& measured, const Matrix6d& prior) {
  const Vector6d s = prior.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d scaled = s.asDiagonal() * measured * s.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scaled, Eigen::EigenvaluesOnly);
  return static_cast<float>(1.0 / (1.0 + std::max(0.0, eigen.eigenvalues()[0])));
}

// Coarse to fine Gauss–Newton on T_view_camera, with everything that the result needs of the last system.
class Alignment {
 public:
  Alignment(const OdometryOptions& options, const Frame& frame, const ModelView& model,
            const Se3& T_odom_predicted)
      : options_(options),
        frame_(frame),
        model_(model),
        finest_(std::min(options.finest_level, frame.level_count - 1)),
        prior_(prior_information(options)),
        T_view_predicted_(model.T_odom_view.inverse() * T_odom_predicted),
        T_view_camera_(T_view_predicted_) {}

  void run() {
    for (int l = frame_.level_count - 1; l >= finest_; --l) {
      const int limit = l == finest_ ? options_.iterations_fine : options_.iterations_coarse;
      for (int i = 0; i < limit && !step(l); ++i) ++iterations_;
    }
    system_ = linearize(frame_.levels[static_cast<std::size_t>(finest_)], model_, T_view_camera_,
                        settings(finest_));
    update_scale();
  }
  [[nodiscard]] const IcpSystem& system() const { return system_; }
  [[nodiscard]] const Matrix6d& prior() const { return prior_; }
  [[nodiscard]] int iterations() const { return iterations_; }
  [[nodiscard]] Se3 T_odom_camera() const { return model_.T_odom_view * T_view_camera_; }
  [[nodiscard]] Vector6d from_prediction() const {
    return (T_view_predicted_.inverse() * T_view_camera_).log();
  }
  /// JᵀWJ of the measurements alone, right perturbation, thinned by the pixels that err together.
  [[nodiscard]] Matrix6d measured() const {
    const Matrix6d A = T_view_camera_.adjoint();
    return A.transpose() * system_.H * A / static_cast<double>(options_.correlated_pixels);
  }

 private:
  [[nodiscard]] IcpSettings settings(int level) const {
    const auto above = static_cast<float>(level - finest_);
    const float s = above / static_cast<float>(std::max(1, frame_.level_count - 1 - finest_));
    return {options_.gate_fine_m + s * (options_.gate_coarse_m - options_.gate_fine_m),
            options_.min_normal_cosine, options_.noise_floor_m, options_.noise_slope, scale_};
  }
  void update_scale() {
    if (system_.partners < kMinPixels) return;
    scale_ = static_cast<float>(std::sqrt(system_.scaled_squares / system_.partners));
    scale_ = std::clamp(scale_, 0.1F, 100.0F);
  }
  // (M + P) ξ = −(Aᵀ b / c + P e), T ← T exp(ξ); true once the step is negligible.
  bool step(int level) {
    system_ =
        linearize(frame_.levels[static_cast<std::size_t>(level)], model_, T_view_camera_, settings(level));
    update_scale();
    const Matrix6d A = T_view_camera_.adjoint();
    const double thinning = 1.0 / static_cast<double>(options_.correlated_pixels);
    const Vector6d gradient = A.transpose() * system_.b * thinning + prior_ * from_prediction();
    const Vector6d xi = -(measured() + prior_).ldlt().solve(gradient);
    if (!xi.allFinite()) return true;
    T_view_camera_ = (T_view_camera_ * Se3::exp(xi)).normalized();
    return xi.cwiseAbs().maxCoeff() < kConvergedStep;
  }

  const OdometryOptions& options_;
  const Frame& frame_;
  const ModelView& model_;
  int finest_;
  Matrix6d prior_;
  Se3 T_view_predicted_, T_view_camera_;
  IcpSystem system_;
  float scale_ = 2.0F;
  int iterations_ = 0;
};

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

}  // namespace

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

TrackingResult Odometry::track(const Frame& frame, const ModelView& model) {
  Alignment alignment(options_, frame, model, predict(frame.timestamp_ns));
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
  if (result.reason != LostReason::kNone) return result;

  result.status = TrackingStatus::kTracked;
  result.T_odom_camera = alignment.T_odom_camera();
  result.information = alignment.measured() + alignment.prior();
  result.degeneracy = degeneracy_of(alignment.measured(), alignment.prior());
  move_to(result.T_odom_camera, frame.timestamp_ns);
  return result;
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
