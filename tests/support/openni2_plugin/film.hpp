// SPDX-License-Identifier: MIT
// What the test camera plays: a file that is mapped, not read. A header, then per frame its device time, the
// depth image and, in a film with colour, the colour image, all in the machine's own byte order.
#pragma once
#include <cstddef>
#include <cstdint>

namespace loopsift::test {

struct FilmHeader {
  static constexpr std::uint64_t kMagic = 0x31306d6c6966736cULL;
  std::uint64_t magic = kMagic;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t frames = 0;
  std::uint32_t has_color = 0;

  [[nodiscard]] std::size_t pixels() const { return std::size_t{width} * height; }
  [[nodiscard]] std::size_t depth_bytes() const { return pixels() * sizeof(std::uint16_t); }
  [[nodiscard]] std::size_t color_bytes() const { return has_color != 0 ? pixels() * 3 : 0; }
  /// Of one frame: its time stamp in µs (std::int64_t), depth, colour.
  [[nodiscard]] std::size_t frame_bytes() const {
    return sizeof(std::int64_t) + depth_bytes() + color_bytes();
  }
};

}  // namespace loopsift::test
