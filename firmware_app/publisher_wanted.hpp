// SPDX-License-Identifier: MIT
// What is still to be sent of the map, chunk by chunk: of fragments that just closed, of a new graph, and of
// whatever a subscriber asked for again. Capacity: kEntries windows of 256 chunks; a request that finds no
// room is refused (its sender asks again). Asking twice for what still waits changes nothing. Thread:
// publish. Never allocates.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace loopsift {

/// As the constants of loopsift.command_t; fragments have their number.
inline constexpr std::int32_t kGraphObject = -1, kLoopsObject = -2, kStateObject = -3;

/// Chunks [first, first + 256) of an object, one bit each.
struct ChunkWindow {
  static constexpr int kChunks = 256;
  std::int32_t object = 0;
  std::int32_t first = 0;
  std::array<std::uint64_t, kChunks / 64> bits{};

  void set(int k) { bits[static_cast<std::size_t>(k) / 64] |= std::uint64_t{1} << (k % 64); }
  [[nodiscard]] bool empty() const { return (bits[0] | bits[1] | bits[2] | bits[3]) == 0; }
};

class WantedChunks {
 public:
  static constexpr std::size_t kEntries = 512;

  /// Appends a window, or adds its bits to one with the same object and first chunk. False when full.
  bool add(const ChunkWindow& window);
  /// The chunks [0, count) of an object. False when not all found room.
  bool add_all(std::int32_t object, std::int32_t count);
  /// Forgets what waits of an object; whether there was anything.
  bool remove(std::int32_t object);
  /// The next chunk, oldest request first. False when nothing waits.
  bool next(std::int32_t* object, std::int32_t* chunk);

  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  [[nodiscard]] ChunkWindow& at(std::size_t k) { return entries_[(head_ + k) % kEntries]; }
  void drop_emptied();

  std::array<ChunkWindow, kEntries> entries_;
  std::size_t head_ = 0, size_ = 0;
};

}  // namespace loopsift
