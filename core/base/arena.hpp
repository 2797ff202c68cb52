// SPDX-License-Identifier: MIT
// All memory of the mapping process in one block, reserved and touched before the first frame.
//
// Parts take their stores in their constructors with carve() and keep them for the run. The same constructors
// run twice: first on a measuring arena, which hands out null spans and only records the budget, then on one
// of exactly that size. So the budget that is printed and what is carved cannot differ. A constructor must
// not touch what it carves (it comes zeroed).
#pragma once
#include <cstddef>
#include <string>
#include <type_traits>

#include "core/base/memory_budget.hpp"
#include "core/base/span.hpp"

namespace loopsift {

/// A bump allocator that never frees. One thread, set-up only.
class Arena {
 public:
  /// Measuring: reserves nothing.
  Arena() = default;
  /// Reserves, zeroes (touches) and, where the rights exist, locks `bytes` of memory.
  explicit Arena(std::size_t bytes);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// `count` zeroed T for `owner` ("part/what"), aligned to 64 bytes. A span of null on a measuring arena.
  /// Running out on a real one is a bug of ours (the measured budget was not honoured) and throws
  /// std::bad_alloc.
  template <class T>
  [[nodiscard]] Span<T> carve(const std::string& owner, std::size_t count) {
    static_assert(std::is_trivially_destructible_v<T>, "the arena never runs destructors");
    return Span<T>(static_cast<T*>(take(owner, count, count * sizeof(T))), count);
  }
  [[nodiscard]] bool measuring() const { return block_ == nullptr; }
  [[nodiscard]] bool locked() const { return locked_; }
  [[nodiscard]] std::size_t used_bytes() const { return used_; }
  [[nodiscard]] std::size_t capacity_bytes() const { return capacity_; }
  [[nodiscard]] const MemoryBudget& budget() const { return budget_; }

 private:
  void* take(const std::string& owner, std::size_t count, std::size_t bytes);

  std::byte* block_ = nullptr;
  std::size_t capacity_ = 0;
  std::size_t used_ = 0;
  bool locked_ = false;
  MemoryBudget budget_;
};

}  // namespace loopsift
