// SPDX-License-Identifier: MIT
#include "core/proposal/fpfh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace loopsift {
namespace {

int bin(float value, float low, float high) {
  const int b = static_cast<int>((value - low) / (high - low) * static_cast<float>(kFpfhBins));
  return std::clamp(b, 0, kFpfhBins - 1);
}

/// The bins of a point pair's Darboux angles (Rusu et al. 2009, eq. 1). The end whose normal makes the
/// smaller angle with the connecting line is the source, so that the pair's order does not matter.
bool pair_bins(const Eigen::Vector3f& p_a, const Eigen::Vector3f& n_a, const Eigen::Vector3f& p_b,
               const Eigen::Vector3f& n_b, int bins[3]) {
  constexpr float kPi = 3.14159265F;
  Eigen::Vector3f line = (p_b - p_a).normalized();
  const bool swap = std::abs(n_a.dot(line)) < std::abs(n_b.dot(line));
  if (swap) line = -line;
  const Eigen::Vector3f& u = swap ? n_b : n_a;
  const Eigen::Vector3f& n_t = swap ? n_a : n_b;
  Eigen::Vector3f v = line.cross(u);
  const float length = v.norm();
  if (!(length > 1e-6F)) return false;
  v /= length;
  const Eigen::Vector3f w = u.cross(v);
  bins[0] = bin(v.dot(n_t), -1, 1);
  bins[1] = bin(u.dot(line), -1, 1);
  bins[2] = bin(std::atan2(w.dot(n_t), u.dot(n_t)), -kPi, kPi);
  return true;
}

float squared_distance(const Fpfh& a, const Fpfh& b) {
  float sum = 0;
  for (std::size_t d = 0; d < a.size(); ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

/// Scales each of the three histograms to sum 1 and takes square roots.
void normalise(Fpfh* f) {
  for (int h = 0; h < 3; ++h) {
    float* begin = f->data() + h * kFpfhBins;
    const float sum = std::accumulate(begin, begin + kFpfhBins, 0.0F);
    for (int b = 0; b < kFpfhBins; ++b) begin[b] = sum > 0 ? std::sqrt(begin[b] / sum) : 0.0F;
  }
}

}  // namespace

void FpfhExtractor::collect_neighbours(const RegistrationCloud& cloud) {
  index_.build(cloud.points, options_.radius_m);
  // Counted first: a list that grew would be held twice on the way.
  std::size_t count = 0;
  for (const Eigen::Vector3f& p : cloud.points)
    index_.for_each_within(p, options_.radius_m, [&](std::uint32_t, float) { ++count; });
  if (neighbours_.capacity() < count) std::vector<std::uint16_t>().swap(neighbours_);
  neighbours_.reserve(count);
  starts_.assign(1, 0);
  neighbours_.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    index_.for_each_within(cloud.points[i], options_.radius_m, [&](std::uint32_t j, float d2) {
      if (j != i && d2 > 0) neighbours_.push_back(static_cast<std::uint16_t>(j));
    });
    starts_.push_back(neighbours_.size());
  }
}

void FpfhExtractor::accumulate_simplified(const RegistrationCloud& cloud) {
  simplified_.assign(cloud.size(), Fpfh{});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (std::size_t k = starts_[i]; k < starts_[i + 1]; ++k) {
      const std::size_t j = neighbours_[k];
      int bins[3];
      if (j < i || !pair_bins(cloud.points[i], cloud.normals[i], cloud.points[j], cloud.normals[j], bins))
        continue;
      for (int h = 0; h < 3; ++h) {
        const auto b = static_cast<std::size_t>(h * kFpfhBins + bins[h]);
        simplified_[i][b] += 1;
        simplified_[j][b] += 1;
      }
    }
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float count = static_cast<float>(std::max<std::size_t>(1, starts_[i + 1] - starts_[i]));
    for (float& b : simplified_[i]) b /= count;
  }
}

/// FPFH(p) = SPFH(p) + 1/k Σ SPFH(p_k) / w_k with w_k the squared distance (the common choice), normalised.
Fpfh FpfhExtractor::weighted(const RegistrationCloud& cloud, std::size_t point) const {
  Fpfh f{};
  float sum = 0;
  for (std::size_t k = starts_[point]; k < starts_[point + 1]; ++k) {
    const Fpfh& s = simplified_[neighbours_[k]];
    const float weight = 1.0F / (cloud.points[neighbours_[k]] - cloud.points[point]).squaredNorm();
    sum += weight;
    for (std::size_t d = 0; d < f.size(); ++d) f[d] += weight * s[d];
  }
  for (std::size_t d = 0; d < f.size(); ++d) f[d] = f[d] / std::max(sum, 1e-12F) + simplified_[point][d];
  normalise(&f);
  return f;
}

void FpfhExtractor::keep_distinctive(Keypoints* keypoints) {
  const auto limit = static_cast<std::size_t>(options_.max_keypoints);
  const std::size_t count = keypoints->size();
  if (count <= limit) return;
  distinctiveness_.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    distinctiveness_[i] = squared_distance(keypoints->features[i], keypoints->mean);
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
    return distinctiveness_[a] != distinctiveness_[b] ? distinctiveness_[a] > distinctiveness_[b] : a < b;
  });
  std::sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(limit));
  for (std::size_t k = 0; k < limit; ++k) {
    keypoints->points[k] = keypoints->points[order_[k]];
    keypoints->features[k] = keypoints->features[order_[k]];
  }
  keypoints->points.resize(limit);
  keypoints->features.resize(limit);
}

void FpfhExtractor::extract(const RegistrationCloud& cloud, Keypoints* keypoints) {
  keypoints->points.clear();
  keypoints->features.clear();
  keypoints->mean = {};
  collect_neighbours(cloud);
  accumulate_simplified(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (starts_[i + 1] - starts_[i] < static_cast<std::size_t>(options_.min_neighbours)) continue;
    keypoints->points.push_back(static_cast<std::uint16_t>(i));
    keypoints->features.push_back(weighted(cloud, i));
    for (std::size_t d = 0; d < keypoints->mean.size(); ++d)
      keypoints->mean[d] += keypoints->features.back()[d];
  }
  for (float& m : keypoints->mean) m /= static_cast<float>(std::max<std::size_t>(1, keypoints->size()));
  keep_distinctive(keypoints);
}

}  // namespace loopsift
