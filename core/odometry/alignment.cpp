// SPDX-License-Identifier: MIT
#include "core/odometry/alignment.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {

constexpr double kConvergedStep = 1e-5;  // metres or radians
constexpr int kMinPixels = 200;
constexpr double kGapBegins = 1.5;       // frame periods since the last frame
constexpr int kGapIterations = 3;        // times as many iterations after a gap
constexpr float kGatePerPeriod = 0.07F;  // how much wider the coarsest gate grows with each period of a gap
constexpr float kMinOverlap = 0.25F;     // of a keyframe that has a say
constexpr double kNoiseShare = 0.1;      // of the information in a direction; less is the normals' noise
constexpr double kVariancePerView = 14;  // of the geometry, in units of correlated_pixels' …
constexpr double kWellKnown = 0.1;       // … where nothing is left to learn about the depths' error
constexpr double kLeastView = 0.01;      // a camera that stands still errs, too
constexpr float kLeastScale = 0.004F;    // log intensity: a tenth of the noise of a good camera

// What the intensities cannot know better: colour that is not registered to depth, or taken a little later.
Matrix6d floor_covariance(const OdometryOptions& o) {
  Vector6d d;
  d.head<3>().setConstant(std::pow(static_cast<double>(o.photometric_floor_m), 2));
  d.tail<3>().setConstant(std::pow(static_cast<double>(o.photometric_floor_rad), 2));
  return d.asDiagonal();
}

// (H⁻¹ + F)⁻¹ = (1 + H F)⁻¹ H: an information that is never better than a floor F. The bracket, factorised.
Eigen::PartialPivLU<Matrix6d> floor_of(const Matrix6d& H, const Matrix6d& floor) {
  return Eigen::PartialPivLU<Matrix6d>(Matrix6d::Identity() + H * floor);
}

Matrix6d bounded(const Eigen::PartialPivLU<Matrix6d>& bound, const Matrix6d& H) {
  const Matrix6d solved = bound.solve(H);
  return 0.5 * (solved + solved.transpose());
}

}  // namespace

Matrix6d prior_information(const OdometryOptions& o, double periods) {
  Vector6d d;
  d.head<3>().setConstant(1.0 / std::pow(periods * static_cast<double>(o.prior_sigma_m), 2));
  d.tail<3>().setConstant(1.0 / std::pow(periods * static_cast<double>(o.prior_sigma_rad), 2));
  return d.asDiagonal();
}

Alignment::Alignment(const OdometryOptions& options, const Frame& frame, const ModelView& model,
                     const Se3& T_odom_predicted, double periods, const Keyframe* keyframe)
    : options_(options),
      frame_(frame),
      model_(model),
      keyframe_(keyframe),
      finest_(std::min(options.finest_level, frame.level_count - 1)),
      periods_(periods),
      prior_(prior_information(options, periods)),
      T_view_predicted_(model.T_odom_view.inverse() * T_odom_predicted),
      T_view_camera_(T_view_predicted_) {}

// With w the weights of Student's t, (ν + 1) / ν at most: ½ (ν + 1) Σ (1 − w ν / (ν + 1)) is the cost of
// Geman & McClure, with the curvature of Student's t at zero. It is taken over what can be compared, and
// counts for all: what the other image does not show speaks for neither pose.
double Alignment::cost(const Se3& T_view_camera) const {
  const auto mismatch = [](double all, int compared, double weight) {
    return compared == 0 ? 3.0 * all : 3.0 * all * (1.0 - weight / (1.2 * compared));
  };
  const int level = frame_.level_count - 1;
  const FrameLevel& frame = frame_.levels[static_cast<std::size_t>(level)];
  const IcpSystem geometry = linearize(frame, model_, T_view_camera, settings(level));
  double sum = mismatch(geometry.valid, geometry.met, geometry.weight);
  if (keyframe_ != nullptr) {
    const Keyframe::Level& key = keyframe_->level(level);
    const Se3 T_camera_key = (model_.T_odom_view * T_view_camera).inverse() * keyframe_->T_odom_key();
    const PhotometricSystem intensities = linearize_photometric(
        frame, key, T_camera_key, {options_.gate_fine_m, photometric_scale_, exposure_});
    const auto points = static_cast<double>(share_of(key)) * keyframe_->valid();
    sum += mismatch(points, intensities.inside, intensities.weight);
  }
  const Vector6d moved = (T_view_predicted_.inverse() * T_view_camera).log();
  return sum / static_cast<double>(options_.correlated_pixels) + 0.5 * moved.dot(prior_ * moved);
}

void Alignment::consider(const Se3& T_odom_other) {
  const Se3 T_view_other = model_.T_odom_view.inverse() * T_odom_other;
  if (cost(T_view_other) < cost(T_view_camera_)) T_view_camera_ = T_view_other;
}

void Alignment::run() {
  for (int l = frame_.level_count - 1; l >= finest_; --l) {
    int limit = l == finest_ ? options_.iterations_fine : options_.iterations_coarse;
    if (periods_ > kGapBegins) limit *= kGapIterations;
    for (int i = 0; i < limit && !step(l); ++i) ++iterations_;
  }
  linearize_at(finest_);
}

// Of the pixels of the keyframe's finest level.
float Alignment::share_of(const Keyframe::Level& key) const {
  return static_cast<float>(key.depth_m.size()) / static_cast<float>(keyframe_->level(0).depth_m.size());
}

void Alignment::linearize_at(int level) {
  add_geometry(level);
  add_intensities(level);
}

IcpSettings Alignment::settings(int level) const {
  const auto above = static_cast<float>(level - finest_);
  const float s = above / static_cast<float>(std::max(1, frame_.level_count - 1 - finest_));
  const float coarse = options_.gate_coarse_m * (1.0F + kGatePerPeriod * static_cast<float>(periods_ - 1.0));
  return {options_.gate_fine_m + s * (coarse - options_.gate_fine_m), options_.min_normal_cosine,
          options_.noise_floor_m, options_.noise_slope, scale_};
}

// In a direction in which only the noise of the normals says something, the surface says nothing. Λ, the
// share of the information that is not noise, comes from the crossed information: with H = L Lᵀ, the
// eigenvalues of L⁻¹ crossed L⁻ᵀ. The surface's estimate −H⁻¹ b stays, its information becomes L V Λ Vᵀ Lᵀ.
void Alignment::add_geometry(int level) {
  system_ =
      linearize(frame_.levels[static_cast<std::size_t>(level)], model_, T_view_camera_, settings(level));
  geometric_ = {};
  if (system_.partners < kMinPixels) return;
  scale_ = static_cast<float>(std::sqrt(system_.scaled_squares / system_.partners));
  scale_ = std::clamp(scale_, 0.1F, 100.0F);
  const Matrix6d A = T_view_camera_.adjoint();
  const double thinning = 1.0 / static_cast<double>(options_.correlated_pixels);
  const Matrix6d H = thinning * A.transpose() * system_.H * A + 1e-9 * prior_;
  const Matrix6d crossed = thinning * A.transpose() * system_.crossed * A;
  const Vector6d b = thinning * A.transpose() * system_.b;
  const Eigen::LLT<Matrix6d> llt(H);
  const Matrix6d half = llt.matrixL().solve(crossed);
  const Matrix6d share = llt.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(0.5 * (share + share.transpose()));
  const Vector6d kept = ((eigen.eigenvalues().array() - kNoiseShare) / (1.0 - kNoiseShare)).max(0.0).min(1.0);
  const Matrix6d root = llt.matrixL() * eigen.eigenvectors();
  geometric_.H = root * kept.asDiagonal() * root.transpose();
  geometric_.b = root * (kept.asDiagonal() * (eigen.eigenvectors().transpose() * llt.matrixL().solve(b)));
}

void Alignment::add_intensities(int level) {
  photometric_ = {};
  intensities_.setZero();
  overlap_ = 0.0F;
  if (keyframe_ == nullptr) return;
  const Keyframe::Level& key = keyframe_->level(level);
  const Se3 T_camera_key = T_odom_camera().inverse() * keyframe_->T_odom_key();
  const PhotometricSystem system =
      linearize_photometric(frame_.levels[static_cast<std::size_t>(level)], key, T_camera_key,
                            {options_.gate_fine_m, photometric_scale_, exposure_});
  const float points = share_of(key) * static_cast<float>(keyframe_->valid());
  overlap_ = static_cast<float>(system.seen) / std::max(1.0F, points);
  if (overlap_ < kMinOverlap) {
    overlap_ = 0.0F;
    return;
  }
  photometric_scale_ = std::max(system.scale, kLeastScale);
  exposure_ = system.exposure;
  const double thinning = 1.0 / static_cast<double>(options_.correlated_pixels);
  intensities_ = thinning * system.H;
  const Eigen::PartialPivLU<Matrix6d> bound = floor_of(intensities_, floor_covariance(options_));
  photometric_.H = bounded(bound, intensities_);
  photometric_.b = bound.solve(thinning * system.b);
}

Matrix6d Alignment::information_since(const Se3& T_odom_before) const {
  const double view =
      std::clamp(share_of_view((T_odom_before.inverse() * T_odom_camera()).log()), kLeastView, 1.0);
  const double unknown = std::sqrt(static_cast<double>(model_.disparity_unknown));
  const double alike =
      kVariancePerView * view * (kWellKnown + unknown) * std::sqrt(static_cast<double>(scale_));
  const double factor = alike + 1.0 / static_cast<double>(options_.correlated_pixels);
  const Matrix6d floor = view * floor_covariance(options_);
  return geometric_.H / factor + bounded(floor_of(intensities_, floor), intensities_) + prior_;
}

// (M + P) ξ = −(b + P e), T ← T exp(ξ).
bool Alignment::step(int level) {
  linearize_at(level);
  const Matrix6d H = measured() + prior_;
  const Vector6d gradient = geometric_.b + photometric_.b + prior_ * from_prediction();
  const Vector6d xi = -H.ldlt().solve(gradient);
  if (!xi.allFinite()) return true;
  T_view_camera_ = (T_view_camera_ * Se3::exp(xi)).normalized();
  return xi.cwiseAbs().maxCoeff() < kConvergedStep;
}

}  // namespace loopsift
