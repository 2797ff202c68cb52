// SPDX-License-Identifier: MIT
// What a device is asked for, and what it was found to give. A driver may answer a request with something
// else without an error; everything is looked at again. Set-up only; allocates.
#pragma once
#include <string>
#include <vector>

#include "drivers/v4l2/pixel_format.hpp"
#include "drivers/v4l2/video_device.hpp"

namespace loopsift {

/// What the device will deliver.
struct StreamFormat {
  const PixelFormat* pixels = nullptr;
  int width = 0, height = 0;
  std::size_t stride_bytes = 0;  ///< from row to row; 0 when compressed
  YuvRange range = YuvRange::kLimited;
  double rate_hz = 0;  ///< 0: the device does not say

  /// What an image takes at least; a compressed one any.
  [[nodiscard]] std::size_t image_bytes() const {
    const std::size_t rows = static_cast<std::size_t>(height);
    return pixels->compressed() ? 1 : stride_bytes * (rows - 1) + pixels->row_bytes(width);
  }
};

/// An Error when the node does not capture, or cannot map its buffers.
[[nodiscard]] Status check_capture(const VideoDevice& device);
/// What the device calls itself; empty if it does not answer.
[[nodiscard]] std::string device_name(const VideoDevice& device);
/// The formats that the device offers, known to us or not.
[[nodiscard]] std::vector<std::uint32_t> offered_formats(const VideoDevice& device);
/// The format of that name, or for an empty name the first of known_pixel_formats() that is offered.
[[nodiscard]] Expected<const PixelFormat*> choose_format(const VideoDevice& device, const std::string& name);
/// Sets format and size. An Error when the device gives others, or an image that does not fit its buffer.
[[nodiscard]] Expected<StreamFormat> set_format(const VideoDevice& device, const PixelFormat& pixels,
                                                int width, int height);
/// Asks for a frame rate; what the device answers, 0 if it does not take part.
[[nodiscard]] double set_rate(const VideoDevice& device, double rate_hz);

}  // namespace loopsift
