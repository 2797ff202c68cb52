// SPDX-License-Identifier: MIT
#include <linux/videodev2.h>

#include "drivers/v4l2/negotiation.hpp"
#include "drivers/v4l2/v4l2_source.hpp"

namespace loopsift {
namespace {

constexpr int kMostNodes = 64;

std::string size_text(unsigned width, unsigned height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// "640x480, 1280x720", or the range of sizes that any in it may be chosen from.
std::string sizes(const VideoDevice& device, std::uint32_t code) {
  std::string text;
  v4l2_frmsizeenum size{};
  size.pixel_format = code;
  while (device.ioctl(VIDIOC_ENUM_FRAMESIZES, &size) >= 0) {
    if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
      return size_text(size.stepwise.min_width, size.stepwise.min_height) + " to " +
             size_text(size.stepwise.max_width, size.stepwise.max_height);
    }
    text += (text.empty() ? "" : ", ") + size_text(size.discrete.width, size.discrete.height);
    ++size.index;
  }
  return text;
}

std::vector<std::string> readable_formats(const VideoDevice& device) {
  std::vector<std::string> formats;
  for (const std::uint32_t code : offered_formats(device)) {
    const PixelFormat* known = find_pixel_format(code);
    if (known == nullptr) continue;
    formats.push_back(fourcc_name(code) + (known->is_depth ? " (depth) " : " (color) ") +
                      sizes(device, code));
  }
  return formats;
}

}  // namespace

std::vector<DeviceInfo> list_v4l2_devices(VideoSystem& system) {
  std::vector<DeviceInfo> devices;
  for (int k = 0; k < kMostNodes; ++k) {
    const Expected<VideoDevice> device = VideoDevice::open(system, "/dev/video" + std::to_string(k));
    if (!device || !check_capture(*device)) continue;
    std::vector<std::string> formats = readable_formats(*device);
    if (!formats.empty())
      devices.push_back({"v4l2:" + device->path(), device_name(*device), std::move(formats)});
  }
  return devices;
}

std::vector<DeviceInfo> list_v4l2_devices() { return list_v4l2_devices(kernel_video_system()); }

}  // namespace loopsift
