// SPDX-License-Identifier: MIT
// Settings of V4L2 cameras, section [v4l2]. Every one of them may also stand in a source's URI, for that
// device alone: `v4l2:/dev/video2?format=YUYV&width=1280&height=720`.
#pragma once
#include <string>
#include <vector>

namespace loopsift {

struct V4l2Options {
  static constexpr int kMostBuffers = 32;
  static constexpr double kHighestRateHz = 1000;

  std::string format;  ///< four characters as `v4l2-ctl --list-formats` prints them; empty: the first that
                       ///< both sides know, depth before colour
  int width = 0;       ///< pixels; 0: the depth camera's (camera.width), for colour 640
  int height = 0;      ///< pixels; 0: the depth camera's (camera.height), for colour 480
  double rate_hz = 30;
  int buffers = 4;  ///< of the kernel's, each one image
  std::vector<std::string>
      controls;  ///< `name=value` or `id=value`, set in this order before the first frame
};

}  // namespace loopsift
