// SPDX-License-Identifier: MIT
// How images and poses of others are taken from LCM.
#pragma once
#include <string>

namespace loopsift {

struct LcmInOptions {
  std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";  ///< LCM provider
  double open_timeout_s = 5;  ///< for the first message with a depth image
  double rate_hz = 30;        ///< of the images, as far as anything must be known about it
  bool host_clock = false;    ///< utime is this computer's wall clock: turn it into the clock of its cameras
};

}  // namespace loopsift
