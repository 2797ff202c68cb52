// SPDX-License-Identifier: MIT
// The other end of a v4l2loopback device: writes depth images whose every pixel follows from their number.
#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace loopsift::test {

/// Pixel x, y of image `number`; the first pixel is the number itself.
[[nodiscard]] constexpr std::uint16_t loopback_pixel(int number, int x, int y) {
  const int value = x == 0 && y == 0 ? number : number * 7919 + x * 31 + y * 257;
  return static_cast<std::uint16_t>(value & 0xFFFF);
}

/// Writes about 30 images a second from construction to destruction.
class LoopbackWriter {
 public:
  LoopbackWriter(const std::string& path, int width, int height);
  ~LoopbackWriter();
  LoopbackWriter(const LoopbackWriter&) = delete;
  LoopbackWriter& operator=(const LoopbackWriter&) = delete;
  /// The device took the format.
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }

 private:
  void write_image(int number);
  void run();

  int fd_ = -1;
  const int width_, height_;
  std::vector<std::uint16_t> image_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace loopsift::test
