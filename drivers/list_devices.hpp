// SPDX-License-Identifier: MIT
// What cameras the drivers of this build see. Set-up only; allocates.
#pragma once
#include <string>
#include <vector>

namespace loopsift {

/// One device, as a person chooses it.
struct DeviceInfo {
  std::string uri;                   ///< what --source takes
  std::string name;                  ///< maker and model, as the device says
  std::vector<std::string> formats;  ///< "depth 640x480 30 Hz, 1 mm", one per mode
};

/// The devices of every driver that this build has, driver by driver; empty where there are none. A driver
/// whose library does not start lists nothing.
[[nodiscard]] std::vector<DeviceInfo> list_devices();

}  // namespace loopsift
