// SPDX-License-Identifier: MIT
// What can be set about a camera that is reached through OpenNI2. A recording (.oni) keeps what it was made
// with.
#pragma once
#include <string>

namespace loopsift {

/// The image size is SourceOptions::camera's, 640×480 where that is 0.
struct OpenNi2Options {
  int rate_hz = 30;           ///< of both images; the device must have such a mode
  bool fine_depth = false;    ///< depth in steps of 0.1 mm instead of 1 mm: reaches 6.5 m
  bool color = true;          ///< false: depth alone
  bool registration = true;   ///< depth pixels moved to where the colour camera sees them, if it can
  bool frame_sync = true;     ///< depth and colour taken at the same time, if the device can
  bool auto_exposure = true;  ///< of the colour image
  bool auto_white_balance = true;
  int exposure = 0;         ///< without auto_exposure, the device's own unit; 0: as it is
  int gain = 0;             ///< without auto_exposure, the device's own unit; 0: as it is
  bool host_time = true;    ///< time stamps on this host's clock; false: as the device gives them
  std::string record_path;  ///< also record what is read from a device to this .oni file; empty: not
};

}  // namespace loopsift
