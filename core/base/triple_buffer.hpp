// SPDX-License-Identifier: MIT
// The newest value, from one thread to another, without a lock: values that were overtaken are skipped.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace loopsift {

/// One writer, one reader, neither ever waits. Three slots: one is the writer's, one the reader's, and one
/// lies between them. Never allocates by itself.
template <class T>
class TripleBuffer {
 public:
  explicit TripleBuffer(std::array<T, 3> slots = {}) : slots_(std::move(slots)) {}
  TripleBuffer(const TripleBuffer&) = delete;
  TripleBuffer& operator=(const TripleBuffer&) = delete;

  /// Writer only: the slot to fill, with an old value in it; then publish().
  [[nodiscard]] T& writable() { return slots_[writer_]; }
  void publish() {
    const std::uint8_t filled = static_cast<std::uint8_t>(writer_ | kFresh);
    writer_ = between_.exchange(filled, std::memory_order_acq_rel) & kIndex;
  }

  /// Reader only: makes the newest value readable(). False when there is none newer than that one.
  bool update() {
    if ((between_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reader_ = between_.exchange(reader_, std::memory_order_acq_rel) & kIndex;
    return true;
  }
  [[nodiscard]] const T& readable() const { return slots_[reader_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;  // bits of between_
  std::array<T, 3> slots_;
  std::uint8_t writer_ = 0, reader_ = 1;
  std::atomic<std::uint8_t> between_{2};
};

}  // namespace loopsift
