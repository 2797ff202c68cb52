// SPDX-License-Identifier: MIT
// A bounded queue between two threads whose producer never waits: it takes the oldest entry out to make room.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/span.hpp"

namespace loopsift {

/// Single producer, single consumer, first in first out, of indices into a store of the caller's. As
/// SpscRing, but the producer too may pop, so the head moves by compare-and-swap. Positions count up for ever
/// (64 bits: no ABA), and a slot can only be overwritten once the head has passed it, so an entry that was
/// read before a successful swap is the right one. Never allocates, never waits.
class DropOldestRing {
 public:
  using Slot = std::atomic<std::uint32_t>;

  explicit DropOldestRing(Span<Slot> storage) : storage_(storage) {}
  DropOldestRing(const DropOldestRing&) = delete;
  DropOldestRing& operator=(const DropOldestRing&) = delete;

  [[nodiscard]] std::size_t capacity() const { return storage_.size(); }

  /// Producer only. False when the ring is full.
  [[nodiscard]] bool try_push(std::uint32_t value) {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == storage_.size()) return false;
    storage_[tail % storage_.size()].store(value, std::memory_order_relaxed);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Producer or consumer: the oldest entry. False when the ring is empty.
  [[nodiscard]] bool try_pop(std::uint32_t* value) {
    std::uint64_t head = head_.load(std::memory_order_acquire);
    while (head != tail_.load(std::memory_order_acquire)) {
      *value = storage_[head % storage_.size()].load(std::memory_order_relaxed);
      if (head_.compare_exchange_weak(head, head + 1, std::memory_order_acq_rel, std::memory_order_acquire))
        return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kCacheLine = 64;
  Span<Slot> storage_;
  alignas(kCacheLine) std::atomic<std::uint64_t> head_{0};
  alignas(kCacheLine) std::atomic<std::uint64_t> tail_{0};
};

}  // namespace loopsift
