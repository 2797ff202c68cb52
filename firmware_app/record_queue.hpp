// SPDX-License-Identifier: MIT
// A ring of records with its counters, in the arena. Any thread but the two at its ends may read the
// counters.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <string>

#include "core/base/arena.hpp"
#include "core/base/spsc_ring.hpp"
#include "core/pipeline/run_figures.hpp"

namespace loopsift {

/// One thread pushes, one pops; neither waits or allocates. A record that finds the ring full is refused and
/// counted.
template <class Record>
class RecordQueue {
 public:
  /// name: "part/what", a literal.
  RecordQueue(const char* name, std::size_t capacity, Arena& arena)
      : name_(name), ring_(arena.carve<Record>(name, capacity)) {}

  bool push(const Record& record) {
    if (!ring_.try_push(record)) {
      refused_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    const auto size = static_cast<std::int64_t>(ring_.size());
    high_water_.store(std::max(high_water_.load(std::memory_order_relaxed), size), std::memory_order_relaxed);
    return true;
  }
  bool pop(Record* record) { return ring_.try_pop(record); }
  /// Allocates.
  [[nodiscard]] PoolFigures figures() const {
    return {name_, static_cast<std::int64_t>(ring_.capacity()), high_water_.load(std::memory_order_relaxed),
            refused_.load(std::memory_order_relaxed)};
  }

 private:
  const char* name_;
  SpscRing<Record> ring_;
  std::atomic<std::int64_t> high_water_{0}, refused_{0};
};

}  // namespace loopsift
