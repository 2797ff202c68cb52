// SPDX-License-Identifier: MIT
#include "core/base/latency_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {
constexpr double kFirstEdgeNs = 1e3;  // bucket 0 holds everything up to here
constexpr double kGrowth = 1.02;

// Only one thread writes: a plain sum, which others may read half done.
template <class T>
void add(std::atomic<T>* sum, T more) {
  sum->store(sum->load(std::memory_order_relaxed) + more, std::memory_order_relaxed);
}

void raise(std::atomic<std::int64_t>* most, std::int64_t value) {
  if (value > most->load(std::memory_order_relaxed)) most->store(value, std::memory_order_relaxed);
}

}  // namespace

LatencyHistogram& LatencyHistogram::operator=(const LatencyHistogram& other) {
  if (this == &other) return *this;
  for (auto& bucket : buckets_) bucket.store(0, std::memory_order_relaxed);
  count_.store(0, std::memory_order_relaxed);
  max_ns_.store(0, std::memory_order_relaxed);
  merge(other);
  return *this;
}

void LatencyHistogram::record_ns(std::int64_t duration_ns) {
  const std::int64_t duration = std::max<std::int64_t>(duration_ns, 0);
  const double steps = std::ceil(
      std::log(std::max(static_cast<double>(duration), kFirstEdgeNs) / kFirstEdgeNs) / std::log(kGrowth));
  const auto bucket = std::min(static_cast<std::size_t>(steps), buckets_.size() - 1);
  add(&buckets_[bucket], 1U);
  add(&count_, std::int64_t{1});
  raise(&max_ns_, duration);
}

void LatencyHistogram::merge(const LatencyHistogram& other) {
  for (std::size_t i = 0; i < buckets_.size(); ++i)
    add(&buckets_[i], other.buckets_[i].load(std::memory_order_relaxed));
  add(&count_, other.count());
  raise(&max_ns_, other.max_ns_.load(std::memory_order_relaxed));
}

double LatencyHistogram::percentile_ms(double fraction) const {
  const std::int64_t count = this->count();
  if (count == 0) return 0;
  const double clamped = std::clamp(fraction, 0.0, 1.0);
  const auto rank = std::max<std::int64_t>(1, std::llround(std::ceil(clamped * static_cast<double>(count))));
  std::int64_t seen = 0;
  std::size_t bucket = 0;
  while (bucket + 1 < buckets_.size() && (seen += buckets_[bucket].load(std::memory_order_relaxed)) < rank)
    ++bucket;
  if (bucket + 1 == buckets_.size()) return max_ms();  // open-ended
  const double upper_edge_ms = kFirstEdgeNs * std::pow(kGrowth, static_cast<double>(bucket)) * 1e-6;
  return std::min(upper_edge_ms, max_ms());
}

}  // namespace loopsift
