// SPDX-License-Identifier: MIT
#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/simd.hpp"
#include "core/proposal/fpfh.hpp"

namespace loopsift {
namespace {

constexpr float kFar = std::numeric_limits<float>::max();
constexpr float kBeyondAll = 1e30F;  // squared norm of the lanes that fill the last block

/// One histogram of the source with that of one lane. Written out, so that the sum stays in a register.
template <std::size_t... Bin>
[[gnu::always_inline]] inline float dot(const float* source, const float* lane, std::index_sequence<Bin...>) {
  return ((source[Bin] * lane[Bin * FeatureMatcher::kLanes]) + ...);
}

float squared_norm_of(const Fpfh& f) {
  float sum = 0;
  for (float v : f) sum += v * v;
  return sum;
}

}  // namespace

void FeatureMatcher::set_target(Span<const Fpfh> features) {
  target_count_ = features.size();
  blocks_.assign((target_count_ + kLanes - 1) / kLanes, Block{});
  for (std::size_t t = 0; t < blocks_.size() * kLanes; ++t) {
    Block& block = blocks_[t / kLanes];
    const std::size_t lane = t % kLanes;
    block.squared_norms[lane] = t < target_count_ ? squared_norm_of(features[t]) : kBeyondAll;
    for (std::size_t d = 0; t < target_count_ && d < kFpfhSize; ++d) block.features[d][lane] = features[t][d];
  }
}

/// Distances of one source to 32 targets, |t|² + |s|² − 2 t·s, kept where they are the best so far.
LOOPSIFT_SIMD void FeatureMatcher::compare(const Fpfh& source, float squared_norm, std::int32_t source_index,
                                           const Block& block, std::int32_t block_index, Best* of_source,
                                           Best* of_targets) {
  float distance[kLanes];
  for (std::size_t l = 0; l < kLanes; ++l) distance[l] = block.squared_norms[l] + squared_norm;
  for (std::size_t h = 0; h < kFpfhSize; h += kFpfhBins)
    for (std::size_t l = 0; l < kLanes; ++l)
      distance[l] -= 2.0F * dot(&source[h], &block.features[h][l], std::make_index_sequence<kFpfhBins>());
  for (std::size_t l = 0; l < kLanes; ++l) {
    const bool nearer = distance[l] < of_source->distances[l];
    of_source->distances[l] = nearer ? distance[l] : of_source->distances[l];
    of_source->indices[l] = nearer ? block_index : of_source->indices[l];
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    const bool nearer = distance[l] < of_targets->distances[l];
    of_targets->distances[l] = nearer ? distance[l] : of_targets->distances[l];
    of_targets->indices[l] = nearer ? source_index : of_targets->indices[l];
  }
}

void FeatureMatcher::match(Span<const Fpfh> source, int max_matches, std::vector<Match>* matches) {
  matches->clear();
  Best none;
  std::fill(std::begin(none.distances), std::end(none.distances), kFar);
  std::fill(std::begin(none.indices), std::end(none.indices), -1);
  best_of_targets_.assign(blocks_.size(), none);
  best_of_sources_.clear();
  if (target_count_ == 0) return;
  for (std::size_t s = 0; s < source.size(); ++s) {
    Best best = none;
    const float squared_norm = squared_norm_of(source[s]);
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      compare(source[s], squared_norm, static_cast<std::int32_t>(s), blocks_[b], static_cast<std::int32_t>(b),
              &best, &best_of_targets_[b]);
    std::size_t lane = 0;
    for (std::size_t l = 1; l < kLanes; ++l)
      if (best.distances[l] < best.distances[lane]) lane = l;
    const auto block = static_cast<std::size_t>(best.indices[lane]);
    best_of_sources_.push_back({static_cast<std::uint16_t>(block * kLanes + lane),
                                static_cast<std::uint16_t>(s), best.distances[lane]});
  }
  for (const Match& m : best_of_sources_) {
    const Best& of_target = best_of_targets_[m.target / kLanes];
    if (of_target.indices[m.target % kLanes] == static_cast<std::int32_t>(m.source)) matches->push_back(m);
  }
  std::sort(matches->begin(), matches->end(), [](const Match& a, const Match& b) {
    return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance
                                                    : a.source < b.source;
  });
  if (matches->size() > static_cast<std::size_t>(max_matches))
    matches->resize(static_cast<std::size_t>(max_matches));
}

}  // namespace loopsift
