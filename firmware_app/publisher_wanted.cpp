// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_wanted.hpp"

#include <algorithm>

namespace loopsift {

bool WantedChunks::add(const ChunkWindow& window) {
  if (window.empty()) return true;
  for (std::size_t k = 0; k < size_; ++k) {
    ChunkWindow& entry = at(k);
    if (entry.object != window.object || entry.first != window.first) continue;
    for (std::size_t word = 0; word < entry.bits.size(); ++word) entry.bits[word] |= window.bits[word];
    return true;
  }
  if (size_ == kEntries) return false;
  at(size_++) = window;
  return true;
}

bool WantedChunks::add_all(std::int32_t object, std::int32_t count) {
  bool all = true;
  for (std::int32_t first = 0; first < count; first += ChunkWindow::kChunks) {
    ChunkWindow window;
    window.object = object;
    window.first = first;
    const int chunks = std::min(ChunkWindow::kChunks, count - first);
    for (int k = 0; k < chunks; ++k) window.set(k);
    all = add(window) && all;
  }
  return all;
}

bool WantedChunks::remove(std::int32_t object) {
  bool any = false;
  for (std::size_t k = 0; k < size_; ++k) {
    if (at(k).object != object || at(k).empty()) continue;
    at(k).bits = {};
    any = true;
  }
  drop_emptied();
  return any;
}

bool WantedChunks::next(std::int32_t* object, std::int32_t* chunk) {
  drop_emptied();
  if (size_ == 0) return false;
  ChunkWindow& oldest = at(0);
  std::size_t word = 0;
  while (oldest.bits[word] == 0) ++word;
  const int bit = __builtin_ctzll(oldest.bits[word]);
  oldest.bits[word] &= oldest.bits[word] - 1;  // the lowest bit goes
  *object = oldest.object;
  *chunk = oldest.first + static_cast<std::int32_t>(word) * 64 + bit;
  drop_emptied();
  return true;
}

void WantedChunks::drop_emptied() {
  while (size_ > 0 && at(0).empty()) {
    head_ = (head_ + 1) % kEntries;
    --size_;
  }
}

}  // namespace loopsift
