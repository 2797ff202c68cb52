// SPDX-License-Identifier: MIT
// The system calls that a V4L2 device is used through, and the clock its frames are timed with: the seam at
// which a test stands in for the kernel. Every call returns at least 0, or −errno. Interrupted calls (EINTR)
// are made again by the implementation.
#pragma once
#include <cstddef>
#include <cstdint>

namespace loopsift {

class VideoSystem {
 public:
  virtual ~VideoSystem() = default;
  /// Opens for reading and writing, without blocking. A file descriptor.
  [[nodiscard]] virtual int open(const char* path) = 0;
  virtual void close(int fd) = 0;
  [[nodiscard]] virtual int ioctl(int fd, unsigned long request, void* argument) = 0;
  /// Maps a buffer of the device, shared.
  [[nodiscard]] virtual int map(int fd, std::size_t bytes, std::int64_t offset, void** memory) = 0;
  virtual void unmap(void* memory, std::size_t bytes) = 0;
  /// Waits until a frame can be taken or the device is in trouble. The events of poll(2); 0: time is over.
  [[nodiscard]] virtual int poll(int fd, int timeout_ms) = 0;
  /// CLOCK_MONOTONIC.
  [[nodiscard]] virtual std::int64_t now_ns() = 0;
};

/// The kernel's own. Any thread.
[[nodiscard]] VideoSystem& kernel_video_system();

}  // namespace loopsift
