// SPDX-License-Identifier: MIT
// Records how long a scope took. Any thread that owns the histogram. Never allocates.
#pragma once
#include <cstdint>

#include "core/base/latency_histogram.hpp"
#include "core/base/steady_time.hpp"

namespace loopsift {

class LatencyTimer {
 public:
  /// times must outlive this.
  explicit LatencyTimer(LatencyHistogram* times) : times_(times), start_ns_(steady_now_ns()) {}
  ~LatencyTimer() { times_->record_ns(steady_now_ns() - start_ns_); }
  LatencyTimer(const LatencyTimer&) = delete;
  LatencyTimer& operator=(const LatencyTimer&) = delete;

 private:
  LatencyHistogram* times_;
  std::int64_t start_ns_;
};

}  // namespace loopsift
