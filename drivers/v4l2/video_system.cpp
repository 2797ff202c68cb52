// SPDX-License-Identifier: MIT
#include "drivers/v4l2/video_system.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

class Kernel final : public VideoSystem {
 public:
  int open(const char* path) override {
    return again([&] { return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); });
  }
  void close(int fd) override { ::close(fd); }
  int ioctl(int fd, unsigned long request, void* argument) override {
    return again([&] { return ::ioctl(fd, request, argument); });
  }
  int map(int fd, std::size_t bytes, std::int64_t offset, void** memory) override {
    void* mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, offset);
    if (mapped == MAP_FAILED) return -errno;
    *memory = mapped;
    return 0;
  }
  void unmap(void* memory, std::size_t bytes) override { ::munmap(memory, bytes); }
  int poll(int fd, int timeout_ms) override {
    const std::int64_t deadline_ns = steady_now_ns() + std::int64_t{timeout_ms} * kNsPerMs;
    pollfd waited{fd, POLLIN, 0};
    const int ready = again([&] {
      const std::int64_t left_ns = std::max<std::int64_t>(0, deadline_ns - steady_now_ns());
      return ::poll(&waited, 1, static_cast<int>((left_ns + kNsPerMs - 1) / kNsPerMs));
    });
    return ready > 0 ? waited.revents : ready;
  }
  std::int64_t now_ns() override { return steady_now_ns(); }

 private:
  static constexpr std::int64_t kNsPerMs = 1'000'000;

  template <class Call>
  static int again(Call&& call) {
    int result = 0;
    while ((result = call()) < 0 && errno == EINTR) {
    }
    return result < 0 ? -errno : result;
  }
};

}  // namespace

VideoSystem& kernel_video_system() {
  static Kernel kernel;
  return kernel;
}

}  // namespace loopsift
