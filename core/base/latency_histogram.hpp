// SPDX-License-Identifier: MIT
// Latencies in a fixed number of counters, so that a run of any length gives percentiles without memory that
// grows.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>

namespace loopsift {

/// Counts in 931 logarithmic buckets, each 2 % wide, from 1 µs to 100 s; what lies outside is counted in the
/// first or last. Never allocates. One thread records; any may read meanwhile, and then sees all records but
/// perhaps the newest.
class LatencyHistogram {
 public:
  LatencyHistogram() = default;
  LatencyHistogram(const LatencyHistogram& other) { merge(other); }
  LatencyHistogram& operator=(const LatencyHistogram& other);
  /// Adds one duration; negative ones count as 0.
  void record_ns(std::int64_t duration_ns);
  /// Adds all of another's counts.
  void merge(const LatencyHistogram& other);

  [[nodiscard]] std::int64_t count() const { return count_.load(std::memory_order_relaxed); }
  /// The longest duration, exactly; 0 when empty.
  [[nodiscard]] double max_ms() const {
    return static_cast<double>(max_ns_.load(std::memory_order_relaxed)) * 1e-6;
  }
  /// The duration that `fraction` (0 to 1) of the records do not exceed, at most 2 % above the true one and
  /// never above max_ms(); 0 when empty. Nearest-rank definition.
  [[nodiscard]] double percentile_ms(double fraction) const;

 private:
  static constexpr int kBuckets = 931;  // ⌈ln(10⁸) / ln(1.02)⌉
  std::array<std::atomic<std::uint32_t>, kBuckets> buckets_{};
  std::atomic<std::int64_t> count_{0};
  std::atomic<std::int64_t> max_ns_{0};
};

}  // namespace loopsift
