// SPDX-License-Identifier: MIT
// An open device node. One thread; set-up allocates, ioctl does not.
#pragma once
#include <string>
#include <utility>

#include "core/base/result.hpp"
#include "drivers/v4l2/video_system.hpp"

namespace loopsift {

class VideoDevice {
 public:
  /// Errors: no such node, no permission, used by another program, gone.
  [[nodiscard]] static Expected<VideoDevice> open(VideoSystem& system, const std::string& path);

  ~VideoDevice();
  VideoDevice(VideoDevice&& other) noexcept
      : system_(other.system_), path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}
  VideoDevice& operator=(VideoDevice&&) = delete;

  /// `argument` is the struct that belongs to the request. At least 0, or −errno.
  template <class Argument>
  [[nodiscard]] int ioctl(unsigned long request, Argument* argument) const {
    return system_->ioctl(fd_, request, argument);
  }
  [[nodiscard]] VideoSystem& system() const { return *system_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int fd() const { return fd_; }

  /// "v4l2:PATH: what".
  [[nodiscard]] Error error(ErrorCode code, const std::string& what) const;
  /// "v4l2:PATH: what: the system's reason", with what to do where that is known; result is −errno.
  [[nodiscard]] Error system_error(const std::string& what, int result) const;

 private:
  VideoDevice(VideoSystem& system, std::string path, int fd)
      : system_(&system), path_(std::move(path)), fd_(fd) {}

  VideoSystem* system_;
  std::string path_;
  int fd_;
};

}  // namespace loopsift
