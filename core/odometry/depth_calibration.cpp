// SPDX-License-Identifier: MIT
#include "core/odometry/depth_calibration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/simd.hpp"
#include "core/odometry/icp.hpp"
#include "core/odometry/normal_equations.hpp"

namespace loopsift {
namespace {

constexpr int kColumns = 6 + kDisparityTerms;
constexpr int kTriangle = kColumns * (kColumns + 1) / 2;
constexpr int kSums = sum_count(kColumns, 0);
constexpr float kGateM = 0.06F, kGatePerM = 0.02F;
constexpr float kMinCosine = 0.8F;  // of the angle between the normals of a pair
constexpr float kSigmas = 2.0F;     // depth noise of two reduced frames, with what is not smooth, in σ(z)
constexpr float kStudentNu = 5.0F;
constexpr int kMinPartners = 2000;
constexpr float kFloorM = 0.0012F, kSlope = 0.003F;
constexpr double kLeastShare = 1e-3;      // of a pair's information; directions with less are left out
constexpr double kFirstVariance = 50.0;   // of pairs, before their scatter is known …
constexpr double kFirstDirections = 9.0;  // … worth as much as one pair

struct Block {
  alignas(32) float J[kColumns][kBlock], r[kBlock], w[kBlock];
  int count = 0;
};

using Sums = float[kSums][kLanes];

LOOPSIFT_SIMD void accumulate(const Block& s, Sums& __restrict sums) {
  accumulate_system<kColumns>(s.J, s.r, s.w, s.count, sums);
}

// Mean of φ φᵀ over the image: tr(Σ · this) is the mean variance of an error with coefficients of variance Σ.
Eigen::Matrix<double, kDisparityTerms, kDisparityTerms> image_moments() {
  constexpr int kGrid = 16;
  Eigen::Matrix<double, kDisparityTerms, kDisparityTerms> sum;
  sum.setZero();
  for (int v = 0; v < kGrid; ++v) {
    for (int u = 0; u < kGrid; ++u) {
      float terms[kDisparityTerms];
      disparity_terms(image_coordinate(u, kGrid), image_coordinate(v, kGrid), terms);
      const DisparityCoefficients phi =
          Eigen::Map<const Eigen::Matrix<float, kDisparityTerms, 1>>(terms).cast<double>();
      sum += phi * phi.transpose();
    }
  }
  return sum / (kGrid * kGrid);
}

// All that one pair adds.
class PairSystem {
 public:
  PairSystem(const Keyframe& key, const Frame& frame, const Se3& T_odom_frame)
      : key_(key),
        frame_(frame),
        level_(frame.levels[0]),
        T_key_frame_(key.T_odom_key().inverse() * T_odom_frame) {
    for (int y = 0; y < level_.camera.height; ++y) add_row(y);
    flush();
  }
  [[nodiscard]] int partners() const { return partners_; }
  // Information about the coefficients and its product with them, the pose eliminated.
  void eliminate_pose(Eigen::Matrix<double, kDisparityTerms, kDisparityTerms>* information,
                      DisparityCoefficients* gradient) const {
    Eigen::Matrix<double, kColumns, kColumns> H;
    Eigen::Matrix<double, kColumns, 1> b;
    int term = 0;
    for (int a = 0; a < kColumns; ++a) {
      for (int c = a; c < kColumns; ++c, ++term) H(a, c) = H(c, a) = total_[term];
      b[a] = total_[kTriangle + a];
    }
    const Matrix6d pose = H.topLeftCorner<6, 6>() + 1e-3 * Matrix6d::Identity();
    const Eigen::Matrix<double, 6, kDisparityTerms> mixed = H.topRightCorner<6, kDisparityTerms>();
    const Eigen::LDLT<Matrix6d> factors(pose);
    *information =
        H.bottomRightCorner<kDisparityTerms, kDisparityTerms>() - mixed.transpose() * factors.solve(mixed);
    *gradient = -(b.tail<kDisparityTerms>() - mixed.transpose() * factors.solve(b.head<6>()));
  }

 private:
  void add_row(int y) {
    const Se3f T(T_key_frame_);
    for (int x = 0; x < level_.camera.width; ++x) {
      if (level_.nz(x, y) == 0.0F) continue;
      add_pixel(T, x, y);
      if (block_.count == kBlock) flush();
    }
  }

  void add_pixel(const Se3f& T, int x, int y) {
    const PinholeCamera& camera = level_.camera;
    const Keyframe::Level& key = key_.level(0);
    const float z = level_.depth_m(x, y);
    const Eigen::Vector3f ray = T.R * camera.unproject(static_cast<float>(x), static_cast<float>(y), 1.0F);
    const Eigen::Vector3f p = z * ray + T.t;
    float u = 0, v = 0;
    if (!key.camera.project(p, &u, &v) || !key.camera.contains(u, v)) return;
    const int ku = static_cast<int>(u + 0.5F), kv = static_cast<int>(v + 0.5F);
    const float kz = key.depth_m(ku, kv);
    if (kz <= 0.0F) return;
    const Eigen::Vector3f key_ray =
        key.camera.unproject(static_cast<float>(ku), static_cast<float>(kv), 1.0F);
    const Eigen::Vector3f n = key_.normal(ku, kv), d = p - kz * key_ray;
    const Eigen::Vector3f frame_normal(level_.nx(x, y), level_.ny(x, y), level_.nz(x, y));
    const float gate = kGateM + kGatePerM * z;
    if (d.squaredNorm() > gate * gate || n.dot(T.R * frame_normal) < kMinCosine) return;
    float terms[kDisparityTerms], key_terms[kDisparityTerms];
    disparity_terms(image_coordinate(x, camera.width), image_coordinate(y, camera.height), terms);
    disparity_terms(image_coordinate(ku, camera.width), image_coordinate(kv, camera.height), key_terms);
    const float by_frame = -n.dot(ray) * z * z, by_key = n.dot(key_ray) * kz * kz;
    const auto i = static_cast<std::size_t>(block_.count++);
    const Eigen::Vector3f turn = p.cross(n);
    float r = n.dot(d);
    for (std::size_t k = 0; k < 3; ++k) {
      block_.J[k][i] = n[static_cast<int>(k)];
      block_.J[k + 3][i] = turn[static_cast<int>(k)];
    }
    // The residual as it would be without any correction.
    for (int k = 0; k < kDisparityTerms; ++k) {
      const float frame_part = by_frame * terms[k], key_part = by_key * key_terms[k];
      block_.J[6 + k][i] = frame_part + key_part;
      r -= frame_part * static_cast<float>(frame_.disparity_coefficients[k]) +
           key_part * static_cast<float>(key_.disparity_coefficients()[k]);
    }
    const float sigma = kSigmas * depth_sigma(z, kFloorM, kSlope);
    const float now = n.dot(d) / sigma;
    block_.r[i] = r;
    block_.w[i] = (kStudentNu + 1.0F) / ((kStudentNu + now * now) * sigma * sigma);
    ++partners_;
  }

  void flush() {
    const int padded = (block_.count + kLanes - 1) / kLanes * kLanes;
    for (int i = block_.count; i < padded; ++i) {
      for (auto& column : block_.J) column[i] = 0.0F;
      block_.r[i] = block_.w[i] = 0.0F;
    }
    block_.count = padded;
    Sums sums = {};
    accumulate(block_, sums);
    add_sums(sums, kSums, total_);
    block_.count = 0;
  }

  const Keyframe& key_;
  const Frame& frame_;
  const FrameLevel& level_;
  Se3 T_key_frame_;
  Block block_;
  double total_[kSums] = {};
  int partners_ = 0;
};

}  // namespace

Status validate(const DepthCalibrationOptions& o) {
  const auto out_of_range = [](const char* key, const char* range) {
    return Error{ErrorCode::kUsage, std::string("depth_calibration.") + key + " must be " + range};
  };
  if (!(o.sigma_per_m > 0)) return out_of_range("sigma_per_m", "more than 0");
  if (!(o.caution >= 1)) return out_of_range("caution", "1 or more");
  if (!(o.memory > 0 && o.memory <= 1)) return out_of_range("memory", "above 0 and at most 1");
  return {};
}

DepthCalibration::DepthCalibration(const DepthCalibrationOptions& options) : options_(options) {}

bool DepthCalibration::add_pair(const Keyframe& key, const Frame& frame, const Se3& T_odom_frame) {
  const PairSystem pair(key, frame, T_odom_frame);
  if (pair.partners() < kMinPartners) return false;
  Information information;
  DisparityCoefficients gradient;
  pair.eliminate_pose(&information, &gradient);
  add(information, gradient);
  const double thinning = 1.0 / (static_cast<double>(options_.caution) * variance());
  const double prior = 1.0 / std::pow(static_cast<double>(options_.sigma_per_m), 2);
  const Information posterior = thinning * information_ + prior * Information::Identity();
  const Eigen::LDLT<Information> factors(posterior);
  coefficients_ = factors.solve(thinning * gradient_);
  const Information moments = image_moments();
  unknown_ = static_cast<float>(prior * factors.solve(moments).trace() / moments.trace());
  return true;
}

// In the directions of which the pair says something: H, g = H ĉ and ĉᵀ H ĉ for its own estimate ĉ.
void DepthCalibration::add(const Information& information, const DisparityCoefficients& gradient) {
  const Eigen::SelfAdjointEigenSolver<Information> eigen(information);
  const auto memory = static_cast<double>(options_.memory);
  information_ *= memory;
  gradient_ *= memory;
  squares_ *= memory;
  directions_ *= memory;
  for (int k = 0; k < kDisparityTerms; ++k) {
    const double known = eigen.eigenvalues()[k];
    if (known < kLeastShare * eigen.eigenvalues()[kDisparityTerms - 1]) continue;
    const DisparityCoefficients direction = eigen.eigenvectors().col(k);
    const double along = direction.dot(gradient);
    information_ += known * direction * direction.transpose();
    gradient_ += along * direction;
    squares_ += along * along / known;
    directions_ += 1.0;
  }
}

// Σ (ĉ − c)ᵀ H (ĉ − c) over the directions: 1 if every pixel erred by itself as the sensor's noise says.
double DepthCalibration::variance() const {
  const double scatter =
      squares_ - 2.0 * coefficients_.dot(gradient_) + coefficients_.dot(information_ * coefficients_);
  return (std::max(0.0, scatter) + kFirstDirections * kFirstVariance) / (directions_ + kFirstDirections);
}

}  // namespace loopsift
