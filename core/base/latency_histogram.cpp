// SPDX-License-Identifier: MIT
#include "core/base/latency_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {
constexpr double kFirstEdgeNs = 1e3;  // bucket 0 holds everything up to here
constexpr double kGrowth = 1.02;
}  // namespace

void LatencyHistogram::record_ns(std::int64_t duration_ns) {
  const std::int64_t duration = std::max<std::int64_t>(duration_ns, 0);
  const double steps = std::ceil(
      std::log(std::max(static_cast<double>(duration), kFirstEdgeNs) / kFirstEdgeNs) / std::log(kGrowth));
  const auto bucket = std::min(static_cast<std::size_t>(steps), buckets_.size() - 1);
  ++buckets_[bucket];
  ++count_;
  max_ns_ = std::max(max_ns_, duration);
}

void LatencyHistogram::merge(const LatencyHistogram& other) {
  for (std::size_t i = 0; i < buckets_.size(); ++i) buckets_[i] += other.buckets_[i];
  count_ += other.count_;
  max_ns_ = std::max(max_ns_, other.max_ns_);
}

double LatencyHistogram::percentile_ms(double fraction) const {
  if (count_ == 0) return 0;
  const double clamped = std::clamp(fraction, 0.0, 1.0);
  const auto rank = std::max<std::int64_t>(1, std::llround(std::ceil(clamped * static_cast<double>(count_))));
  std::int64_t seen = 0;
  std::size_t bucket = 0;
  while (bucket + 1 < buckets_.size() && (seen += buckets_[bucket]) < rank) ++bucket;
  if (bucket + 1 == buckets_.size()) return max_ms();  // open-ended
  const double upper_edge_ms = kFirstEdgeNs * std::pow(kGrowth, static_cast<double>(bucket)) * 1e-6;
  return std::min(upper_edge_ms, max_ms());
}

}  // namespace loopsift
