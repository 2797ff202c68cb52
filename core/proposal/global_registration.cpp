// SPDX-License-Identifier: MIT
#include "core/proposal/global_registration.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace loopsift {

bool fit_rigid(Span<const Eigen::Vector3f> target, Span<const Eigen::Vector3f> source,
               Span<const std::uint32_t> pick, Se3* T_target_source) {
  if (pick.size() < 3) return false;
  Eigen::Vector3d mean_target = Eigen::Vector3d::Zero(), mean_source = Eigen::Vector3d::Zero();
  for (std::uint32_t k : pick) {
    mean_target += target[k].cast<double>();
    mean_source += source[k].cast<double>();
  }
  mean_target /= static_cast<double>(pick.size());
  mean_source /= static_cast<double>(pick.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::uint32_t k : pick)
    covariance +=
        (target[k].cast<double>() - mean_target) * (source[k].cast<double>() - mean_source).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& s = svd.singularValues();
  if (!(s(1) > 1e-6 * s(0)) || !(s(0) > 0)) return false;
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign(2) = -1;
  const Eigen::Matrix3d R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  *T_target_source = Se3(R, mean_target - R * mean_source);
  return T_target_source->is_valid();
}

void GlobalRegistration::build_compatibility(const RegistrationCloud& target,
                                             const RegistrationCloud& source) {
  count_ = std::min(target.size(), source.size());
  words_ = (count_ + 63) / 64;
  rows_.assign(count_ * words_, 0);
  // |cos a − cos b| ≤ |a − b|: a test on cosines that is strict only where angles are near 0 or π.
  const float cosine_tolerance = options_.normal_tolerance_rad;
  for (std::size_t a = 0; a < count_; ++a) {
    for (std::size_t b = a + 1; b < count_; ++b) {
      const float target_length = (target.points[a] - target.points[b]).norm();
      const float source_length = (source.points[a] - source.points[b]).norm();
      const float target_cosine = target.normals[a].dot(target.normals[b]);
      const float source_cosine = source.normals[a].dot(source.normals[b]);
      const bool compatible = std::abs(target_length - source_length) < options_.distance_tolerance_m &&
                              std::abs(target_cosine - source_cosine) < cosine_tolerance &&
                              target_length > options_.min_length_m;
      if (!compatible) continue;
      rows_[a * words_ + b / 64] |= std::uint64_t{1} << (b % 64);
      rows_[b * words_ + a / 64] |= std::uint64_t{1} << (a % 64);
    }
  }
}

int GlobalRegistration::common(std::size_t a, std::size_t b) const {
  int bits = 0;
  for (std::size_t w = 0; w < words_; ++w)
    bits += __builtin_popcountll(rows_[a * words_ + w] & rows_[b * words_ + w]);
  return bits;
}

namespace {

template <class Scored>
bool better(const Scored& a, const Scored& b) {
  return a.score != b.score ? a.score > b.score : a.match < b.match;
}

}  // namespace

void GlobalRegistration::choose_seeds() {
  seeds_.clear();
  for (std::size_t a = 0; a < count_; ++a) seeds_.push_back({common(a, a), static_cast<std::uint32_t>(a)});
  std::sort(seeds_.begin(), seeds_.end(), better<Scored>);
  seeds_.resize(std::min(seeds_.size(), static_cast<std::size_t>(options_.max_seeds)));
}

void GlobalRegistration::gather_companions(std::size_t seed) {
  companions_.clear();
  for (std::size_t w = 0; w < words_; ++w) {
    for (std::uint64_t bits = rows_[seed * words_ + w]; bits != 0; bits &= bits - 1) {
      const std::size_t other = w * 64 + static_cast<std::size_t>(__builtin_ctzll(bits));
      companions_.push_back({common(seed, other), static_cast<std::uint32_t>(other)});
    }
  }
  const std::size_t keep = std::min(companions_.size(), static_cast<std::size_t>(options_.companions));
  std::partial_sort(companions_.begin(), companions_.begin() + static_cast<std::ptrdiff_t>(keep),
                    companions_.end(), better<Scored>);
  companions_.resize(keep);
  agreeing_.assign(1, static_cast<std::uint32_t>(seed));
  for (const Scored& c : companions_) agreeing_.push_back(c.match);
}

bool GlobalRegistration::fit_companions(const RegistrationCloud& target, const RegistrationCloud& source,
                                        Se3* T) const {
  return fit_rigid(target.points, source.points, agreeing_, T);
}

int GlobalRegistration::refit(const RegistrationCloud& target, const RegistrationCloud& source, Se3* T) {
  for (int round = 0; round < 2; ++round) {
    const Se3f Tf(*T);
    const float squared_tolerance = options_.distance_tolerance_m * options_.distance_tolerance_m;
    agreeing_.clear();
    for (std::size_t k = 0; k < count_; ++k) {
      const bool near = (Tf * source.points[k] - target.points[k]).squaredNorm() < squared_tolerance;
      if (near && (Tf.R * source.normals[k]).dot(target.normals[k]) > 0.5F)
        agreeing_.push_back(static_cast<std::uint32_t>(k));
    }
    if (static_cast<int>(agreeing_.size()) < options_.min_agreeing) return 0;
    if (round == 0 && !fit_rigid(target.points, source.points, agreeing_, T)) return 0;
  }
  return static_cast<int>(agreeing_.size());
}

void GlobalRegistration::insert(const MotionHypothesis& hypothesis,
                                std::vector<MotionHypothesis>* hypotheses) const {
  for (MotionHypothesis& h : *hypotheses) {
    const Se3 difference = h.T_target_source.inverse() * hypothesis.T_target_source;
    if (difference.translation().norm() > static_cast<double>(options_.distinct_translation_m) ||
        difference.angle() > static_cast<double>(options_.distinct_rotation_rad))
      continue;
    if (h.agreeing < hypothesis.agreeing) h = hypothesis;
    return;
  }
  hypotheses->push_back(hypothesis);
}

void GlobalRegistration::run(const RegistrationCloud& target, const RegistrationCloud& source,
                             std::vector<MotionHypothesis>* hypotheses) {
  hypotheses->clear();
  build_compatibility(target, source);
  choose_seeds();
  for (const Scored& seed : seeds_) {
    if (seed.score + 1 < options_.min_agreeing) continue;
    gather_companions(seed.match);
    MotionHypothesis hypothesis;
    if (!fit_companions(target, source, &hypothesis.T_target_source)) continue;
    hypothesis.agreeing = refit(target, source, &hypothesis.T_target_source);
    if (hypothesis.agreeing > 0) insert(hypothesis, hypotheses);
  }
  std::stable_sort(
      hypotheses->begin(), hypotheses->end(),
      [](const MotionHypothesis& a, const MotionHypothesis& b) { return a.agreeing > b.agreeing; });
  if (hypotheses->size() > static_cast<std::size_t>(options_.max_hypotheses))
    hypotheses->resize(static_cast<std::size_t>(options_.max_hypotheses));
}

}  // namespace loopsift
