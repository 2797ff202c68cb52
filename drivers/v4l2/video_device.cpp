// SPDX-License-Identifier: MIT
#include "drivers/v4l2/video_device.hpp"

#include <cerrno>
#include <cstring>

namespace loopsift {
namespace {

ErrorCode code_of(int result) {
  switch (-result) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return ErrorCode::kNotFound;
    case EINVAL:
    case ENOTTY:
      return ErrorCode::kUnsupported;
    default:
      return ErrorCode::kIo;
  }
}

const char* advice(int result) {
  switch (-result) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "; is it plugged in? 'loopsift-tool devices' lists what is there";
    case EACCES:
    case EPERM:
      return "; the user must be in the group that owns the node, usually 'video'";
    case EBUSY:
      return "; another program uses it ('fuser -v' on the node names it)";
    default:
      return "";
  }
}

}  // namespace

Expected<VideoDevice> VideoDevice::open(VideoSystem& system, const std::string& path) {
  const int fd = system.open(path.c_str());
  VideoDevice device(system, path, fd);
  if (fd < 0) return device.system_error("cannot be opened", fd);
  return device;
}

VideoDevice::~VideoDevice() {
  if (fd_ >= 0) system_->close(fd_);
}

Error VideoDevice::error(ErrorCode code, const std::string& what) const {
  return {code, "v4l2:" + path_ + ": " + what};
}

Error VideoDevice::system_error(const std::string& what, int result) const {
  return error(code_of(result), what + ": " + std::strerror(-result) + advice(result));
}

}  // namespace loopsift
