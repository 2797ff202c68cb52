// SPDX-License-Identifier: MIT
#include "drivers/v4l2/negotiation.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {

std::string size_text(unsigned width, unsigned height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

std::string offer(const VideoDevice& device) {
  std::string text;
  for (const std::uint32_t code : offered_formats(device))
    text += (text.empty() ? "" : ", ") + fourcc_name(code);
  return text.empty() ? "nothing" : text;
}

std::string readable_formats() {
  std::string text;
  for (const PixelFormat& format : known_pixel_formats())
    text += (text.empty() ? "" : ", ") + fourcc_name(format.code);
  return text;
}

// Interlaced images come as two fields, of two moments.
bool is_progressive(std::uint32_t field) { return field == V4L2_FIELD_NONE || field == V4L2_FIELD_ANY; }

Expected<StreamFormat> check_format(const VideoDevice& device, const PixelFormat& pixels, int width,
                                    int height, const v4l2_pix_format& given) {
  if (given.pixelformat != pixels.code) {
    return device.error(ErrorCode::kUnsupported, "asked for " + fourcc_name(pixels.code) +
                                                     ", the device gives " + fourcc_name(given.pixelformat) +
                                                     "; set v4l2.format to one of " + offer(device));
  }
  if (given.width != static_cast<unsigned>(width) || given.height != static_cast<unsigned>(height)) {
    return device.error(ErrorCode::kUnsupported,
                        "asked for " +
                            size_text(static_cast<unsigned>(width), static_cast<unsigned>(height)) +
                            ", the device gives " + size_text(given.width, given.height) +
                            " pixels; set v4l2.width and v4l2.height to a size it has");
  }
  if (!is_progressive(given.field))
    return device.error(ErrorCode::kUnsupported, "the device gives interlaced images, which are not read");
  StreamFormat format{&pixels, width, height};
  if (given.quantization == V4L2_QUANTIZATION_FULL_RANGE) format.range = YuvRange::kFull;
  if (!pixels.compressed())
    format.stride_bytes = std::max<std::size_t>(given.bytesperline, pixels.row_bytes(width));
  const bool stride_too_small = given.bytesperline != 0 && given.bytesperline < pixels.row_bytes(width);
  if (stride_too_small || given.sizeimage < format.image_bytes()) {
    return device.error(ErrorCode::kUnsupported, "the device's " + fourcc_name(pixels.code) + " images are " +
                                                     std::to_string(given.sizeimage) + " bytes in rows of " +
                                                     std::to_string(given.bytesperline) + ", too small for " +
                                                     size_text(given.width, given.height) + " pixels");
  }
  return format;
}

}  // namespace

Status check_capture(const VideoDevice& device) {
  v4l2_capability capability{};
  if (const int result = device.ioctl(VIDIOC_QUERYCAP, &capability); result < 0)
    return device.system_error("is no V4L2 device", result);
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps
                                                                                  : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0) {
    return device.error(ErrorCode::kUnsupported,
                        "this node captures no images (a camera may have several nodes; 'loopsift-tool "
                        "devices' lists those that do)");
  }
  if ((can & V4L2_CAP_STREAMING) == 0)
    return device.error(ErrorCode::kUnsupported, "the device cannot map its buffers (no streaming I/O)");
  return {};
}

std::string device_name(const VideoDevice& device) {
  v4l2_capability capability{};
  if (device.ioctl(VIDIOC_QUERYCAP, &capability) < 0) return "";
  const char* const card = reinterpret_cast<const char*>(capability.card);
  return {card, std::find(card, card + sizeof capability.card, '\0')};
}

std::vector<std::uint32_t> offered_formats(const VideoDevice& device) {
  std::vector<std::uint32_t> codes;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  while (device.ioctl(VIDIOC_ENUM_FMT, &description) >= 0) {
    codes.push_back(description.pixelformat);
    description.index = static_cast<std::uint32_t>(codes.size());
  }
  return codes;
}

Expected<const PixelFormat*> choose_format(const VideoDevice& device, const std::string& name) {
  const std::vector<std::uint32_t> offered = offered_formats(device);
  for (const PixelFormat& format : known_pixel_formats()) {
    const bool is_offered = std::find(offered.begin(), offered.end(), format.code) != offered.end();
    if (name.empty() ? is_offered : fourcc_name(format.code) == name) return &format;
  }
  if (!name.empty()) {
    return device.error(ErrorCode::kUsage,
                        "format '" + name + "' is not read; known are " + readable_formats());
  }
  return device.error(ErrorCode::kUnsupported, "offers no format that is read: it has " + offer(device) +
                                                   ", known are " + readable_formats());
}

Expected<StreamFormat> set_format(const VideoDevice& device, const PixelFormat& pixels, int width,
                                  int height) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int result = device.ioctl(VIDIOC_G_FMT, &format); result < 0)
    return device.system_error("does not say its format", result);
  v4l2_pix_format& asked = format.fmt.pix;
  asked.width = static_cast<std::uint32_t>(width);
  asked.height = static_cast<std::uint32_t>(height);
  asked.pixelformat = pixels.code;
  asked.field = V4L2_FIELD_NONE;
  asked.bytesperline = asked.sizeimage = 0;
  if (const int result = device.ioctl(VIDIOC_S_FMT, &format); result < 0) {
    return device.system_error(
        "refuses " + fourcc_name(pixels.code) + " at " + size_text(asked.width, asked.height) + " pixels",
        result);
  }
  return check_format(device, pixels, width, height, format.fmt.pix);
}

double set_rate(const VideoDevice& device, double rate_hz) {
  constexpr double kTicksPerSecond = 1000;  // a frame interval is a fraction; 29.97 Hz = 29970/1000
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (device.ioctl(VIDIOC_G_PARM, &parameters) < 0) return 0;
  v4l2_captureparm& capture = parameters.parm.capture;
  if ((capture.capability & V4L2_CAP_TIMEPERFRAME) != 0 && rate_hz > 0) {
    capture.timeperframe.numerator = static_cast<std::uint32_t>(kTicksPerSecond);
    capture.timeperframe.denominator = static_cast<std::uint32_t>(std::lround(rate_hz * kTicksPerSecond));
    if (device.ioctl(VIDIOC_S_PARM, &parameters) < 0) return 0;
  }
  const v4l2_fract& interval = capture.timeperframe;
  return interval.numerator > 0 ? static_cast<double>(interval.denominator) / interval.numerator : 0.0;
}

}  // namespace loopsift
