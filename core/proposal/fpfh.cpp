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

/// Calls f(index, squared distance) for every other point in the neighbourhood. Looked up anew each time:
/// kept as lists, the neighbourhoods would take more memory than all the rest.
template <class F>
void FpfhExtractor::for_each_neighbour(const RegistrationCloud& cloud, std::size_t point, F f) const {
  index_.for_each_within(cloud.points[point], options_.radius_m, [&](std::uint32_t other, float d2) {
    if (other != point && d2 > 0) f(static_cast<std::size_t>(other), d2);
  });
}

void FpfhExtractor::accumulate_simplified(const RegistrationCloud& cloud) {
  simplified_.assign(cloud.size(), Fpfh{});
  neighbour_counts_.assign(cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for_each_neighbour(cloud, i, [&](std::size_t j, float) {
      ++neighbour_counts_[i];
      int bins[3];
      if (j < i || !pair_bins(cloud.points[i], cloud.normals[i], cloud.points[j], cloud.normals[j], bins))
        return;
      for (int h = 0; h < 3; ++h) {
        const auto b = static_cast<std::size_t>(h * kFpfhBins + bins[h]);
        simplified_[i][b] += 1;
        simplified_[j][b] += 1;
      }
    });
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto count = static_cast<float>(std::max(1, neighbour_counts_[i]));
    for (float& b : simplified_[i]) b /= count;
  }
}

/// FPFH(p) = SPFH(p) + 1/k Σ SPFH(p_k) / w_k with w_k the squared distance (the common choice), normalised.
Fpfh FpfhExtractor::weighted(const RegistrationCloud& cloud, std::size_t point) const {
  Fpfh f{};
  float sum = 0;
  for_each_neighbour(cloud, point, [&](std::size_t j, float d2) {
    const Fpfh& s = simplified_[j];
    const float weight = 1.0F / d2;
    sum += weight;
    for (std::size_t d = 0; d < f.size(); ++d) f[d] += weight * s[d];
  });
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
  if (keypoints->features.capacity() < cloud.size()) {  // a list that grew would be held twice on the way
    std::vector<Fpfh>().swap(keypoints->features);
    keypoints->features.reserve(cloud.size());
  }
  index_.build(cloud.points, options_.radius_m);
  accumulate_simplified(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (neighbour_counts_[i] < options_.min_neighbours) continue;
    keypoints->points.push_back(static_cast<std::uint16_t>(i));
    keypoints->features.push_back(weighted(cloud, i));
    for (std::size_t d = 0; d < keypoints->mean.size(); ++d)
      keypoints->mean[d] += keypoints->features.back()[d];
  }
  for (float& m : keypoints->mean) m /= static_cast<float>(std::max<std::size_t>(1, keypoints->size()));
  keep_distinctive(keypoints);
}

}  // namespace loopsift
