// SPDX-License-Identifier: MIT
// The loops that the sifter knows, in a fixed number of places, and their ranking. In: loops, and their
// improvements once they are scored. Out: the ranked list, best first. Capacity: max_loops; when it is full
// the lowest ranked loop that is not accepted gives way, and where none is ranked yet the newcomer is
// refused; both are counted, and the last kDroppedKept of them can be had. Thread: back. Allocates in the
// constructor only (loops are plain values).
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/arena.hpp"
#include "core/sifter/sifted_loop.hpp"

namespace loopsift {

class LoopList {
 public:
  static constexpr std::size_t kDroppedKept = 256;

  LoopList(std::size_t max_loops, Arena& arena);

  /// False when there was no place.
  bool add(const Loop& loop);
  /// Puts a loop just scored in its place. Ties by id, so that the order does not depend on how loops
  /// arrived.
  void rank(std::size_t record);
  /// Takes all loops out of the ranking, to be scored and tested again; their decisions stay until then.
  void start_again();
  /// All as they are now, to go back to.
  [[nodiscard]] std::vector<SiftedLoop> snapshot() const { return {records().begin(), records().end()}; }
  void restore(const std::vector<SiftedLoop>& snapshot);
  /// The one added last.
  [[nodiscard]] SiftedLoop& newest() { return records_[newest_]; }
  /// In no particular order.
  [[nodiscard]] Span<const SiftedLoop> records() const { return {records_.data(), size_}; }
  [[nodiscard]] SiftedLoop& operator[](std::size_t record) { return records_[record]; }
  [[nodiscard]] const SiftedLoop& operator[](std::size_t record) const { return records_[record]; }
  /// Indices into records(), best first.
  [[nodiscard]] const std::vector<std::size_t>& ranking() const { return ranking_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return records_.size(); }
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }
  /// Next of the dropped loops that nobody took yet, oldest first; of more than kDroppedKept the newest.
  [[nodiscard]] bool take_dropped(SiftedLoop* record);

 private:
  void renumber(std::size_t from);
  void drop(const SiftedLoop& record);

  Span<SiftedLoop> records_;
  std::size_t size_ = 0;
  std::vector<std::size_t> ranking_;
  std::size_t newest_ = 0;
  Span<SiftedLoop> dropped_loops_;  // a ring
  std::int64_t dropped_ = 0, dropped_taken_ = 0;
};

}  // namespace loopsift
