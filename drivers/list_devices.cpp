// SPDX-License-Identifier: MIT
#include "drivers/list_devices.hpp"

#include <iterator>

#include "drivers/driver_table.hpp"

namespace loopsift {

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> all;
  for (const Driver& driver : drivers()) {
    if (driver.list == nullptr) continue;
    std::vector<DeviceInfo> devices = driver.list();
    all.insert(all.end(), std::make_move_iterator(devices.begin()), std::make_move_iterator(devices.end()));
  }
  return all;
}

}  // namespace loopsift
