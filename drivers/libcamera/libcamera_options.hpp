// SPDX-License-Identifier: MIT
// Settings of libcamera's cameras, section [libcamera].
#pragma once
#include <string>

namespace loopsift {

struct LibcameraOptions {
  static constexpr int kMostBuffers = 32;

  std::string format;   ///< as libcamera names it ("BGR888", "YUYV", "NV12"); empty: the first that is read
  int width = 640;      ///< pixels; a camera that has no such size gives the nearest that it has
  int height = 480;     ///< pixels
  double rate_hz = 30;  ///< for cameras that let it be chosen
  int buffers = 4;      ///< images on their way; the camera may want more
};

}  // namespace loopsift
