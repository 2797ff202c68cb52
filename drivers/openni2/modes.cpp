// SPDX-License-Identifier: MIT
#include "drivers/openni2/modes.hpp"

#include <algorithm>
#include <cstdlib>

namespace loopsift::openni2 {
namespace {

const char* format_name(openni::PixelFormat format) {
  switch (format) {
    case openni::PIXEL_FORMAT_DEPTH_1_MM:
      return "1 mm";
    case openni::PIXEL_FORMAT_DEPTH_100_UM:
      return "0.1 mm";
    case openni::PIXEL_FORMAT_SHIFT_9_2:
    case openni::PIXEL_FORMAT_SHIFT_9_3:
      return "shift";
    case openni::PIXEL_FORMAT_RGB888:
      return "RGB";
    case openni::PIXEL_FORMAT_YUV422:
    case openni::PIXEL_FORMAT_YUYV:
      return "YUV";
    case openni::PIXEL_FORMAT_GRAY8:
    case openni::PIXEL_FORMAT_GRAY16:
      return "grey";
    case openni::PIXEL_FORMAT_JPEG:
      return "JPEG";
  }
  return "unknown";
}

Error no_mode(const openni::SensorInfo& sensor, const std::string& wanted) {
  std::string message = "the device has no mode " + wanted + "; it has";
  for (const std::string& mode : mode_texts(sensor)) message += " [" + mode + "]";
  return {ErrorCode::kUnsupported, message + "; set camera.width, camera.height, openni2.rate_hz, " +
                                       "openni2.fine_depth or openni2.color accordingly"};
}

}  // namespace

std::string to_text(const openni::VideoMode& mode) {
  return std::to_string(mode.getResolutionX()) + "x" + std::to_string(mode.getResolutionY()) + " " +
         std::to_string(mode.getFps()) + " Hz, " + format_name(mode.getPixelFormat());
}

std::vector<std::string> mode_texts(const openni::SensorInfo& sensor) {
  std::vector<std::string> texts;
  const openni::Array<openni::VideoMode>& modes = sensor.getSupportedVideoModes();
  for (int k = 0; k < modes.getSize(); ++k) {
    std::string text = to_text(modes[k]);
    if (std::find(texts.begin(), texts.end(), text) == texts.end()) texts.push_back(std::move(text));
  }
  return texts;
}

double depth_unit_m(openni::PixelFormat format) {
  if (format == openni::PIXEL_FORMAT_DEPTH_1_MM) return 1e-3;
  return format == openni::PIXEL_FORMAT_DEPTH_100_UM ? 1e-4 : 0;
}

bool is_color(openni::PixelFormat format) {
  return format == openni::PIXEL_FORMAT_RGB888 || format == openni::PIXEL_FORMAT_GRAY8;
}

Expected<openni::VideoMode> choose_depth_mode(const openni::SensorInfo& sensor, int width, int height,
                                              const OpenNi2Options& options) {
  openni::VideoMode wanted;
  wanted.setResolution(width, height);
  wanted.setFps(options.rate_hz);
  wanted.setPixelFormat(options.fine_depth ? openni::PIXEL_FORMAT_DEPTH_100_UM
                                           : openni::PIXEL_FORMAT_DEPTH_1_MM);
  const openni::Array<openni::VideoMode>& modes = sensor.getSupportedVideoModes();
  for (int k = 0; k < modes.getSize(); ++k) {
    const openni::VideoMode& mode = modes[k];
    if (mode.getResolutionX() == width && mode.getResolutionY() == height &&
        mode.getFps() == options.rate_hz && mode.getPixelFormat() == wanted.getPixelFormat())
      return mode;
  }
  return no_mode(sensor, "depth " + to_text(wanted));
}

Expected<openni::VideoMode> choose_color_mode(const openni::SensorInfo& sensor, int width, int height,
                                              const OpenNi2Options& options) {
  const auto cost = [&](const openni::VideoMode& mode) {
    const int grey = mode.getPixelFormat() == openni::PIXEL_FORMAT_GRAY8 ? 1 : 0;
    return 2 * (std::abs(mode.getResolutionX() - width) + std::abs(mode.getResolutionY() - height)) + grey;
  };
  const openni::VideoMode* best = nullptr;
  const openni::Array<openni::VideoMode>& modes = sensor.getSupportedVideoModes();
  for (int k = 0; k < modes.getSize(); ++k) {
    const openni::VideoMode& mode = modes[k];
    if (mode.getFps() != options.rate_hz || !is_color(mode.getPixelFormat())) continue;
    if (best == nullptr || cost(mode) < cost(*best)) best = &mode;
  }
  if (best != nullptr) return *best;
  return no_mode(sensor, "colour, RGB or grey, at " + std::to_string(options.rate_hz) + " Hz");
}

}  // namespace loopsift::openni2
