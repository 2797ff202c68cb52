// SPDX-License-Identifier: MIT
// A bounded queue between two threads without a lock: one pushes, one pops.
#pragma once
#include <atomic>
#include <cstddef>
#include <utility>

#include "core/base/span.hpp"

namespace loopsift {

/// Single producer, single consumer, first in first out. Capacity is the size of the storage, which the
/// caller keeps alive (an Arena's span); never allocates, never waits. Positions count up for ever; a slot is
/// position mod capacity.
template <class T>
class SpscRing {
 public:
  explicit SpscRing(Span<T> storage) : storage_(storage) {}
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  [[nodiscard]] std::size_t capacity() const { return storage_.size(); }
  /// Exact for the two threads that use the ring while the other rests; else a value that was true a moment
  /// ago.
  [[nodiscard]] std::size_t size() const {
    // Head first: it never overtakes the tail that is read after it.
    const std::size_t head = head_.load(std::memory_order_acquire);
    return tail_.load(std::memory_order_acquire) - head;
  }

  /// Producer only. False when the ring is full; `value` is then as it was.
  [[nodiscard]] bool try_push(T value) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == storage_.size()) return false;
    storage_[tail % storage_.size()] = std::move(value);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer only. False when the ring is empty.
  [[nodiscard]] bool try_pop(T* value) {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    *value = std::move(storage_[head % storage_.size()]);
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

 private:
  static constexpr std::size_t kCacheLine = 64;  // each side writes a line of its own
  Span<T> storage_;
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};  // next to pop; written by the consumer
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};  // next to push; written by the producer
};

}  // namespace loopsift
