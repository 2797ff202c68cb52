// SPDX-License-Identifier: MIT
#include "drivers/openni2/modes.hpp"
#include "drivers/openni2/openni2_source.hpp"
#include "drivers/openni2/session.hpp"

namespace loopsift {
namespace {

void add_formats(openni::Device& device, openni::SensorType type, const std::string& what,
                 std::vector<std::string>* formats) {
  const openni::SensorInfo* sensor = device.getSensorInfo(type);
  if (sensor == nullptr) return;
  for (const std::string& mode : openni2::mode_texts(*sensor)) formats->push_back(what + " " + mode);
}

}  // namespace

std::vector<DeviceInfo> list_openni2_devices() {
  std::vector<DeviceInfo> devices;
  const openni2::Session session;
  if (!session.status()) return devices;
  openni::Array<openni::DeviceInfo> found;
  openni::OpenNI::enumerateDevices(&found);
  for (int k = 0; k < found.getSize(); ++k) {
    DeviceInfo one{std::string("openni2:") + found[k].getUri(),
                   std::string(found[k].getVendor()) + " " + found[k].getName(),
                   {}};
    openni::Device device;
    if (device.open(found[k].getUri()) == openni::STATUS_OK) {
      add_formats(device, openni::SENSOR_DEPTH, "depth", &one.formats);
      add_formats(device, openni::SENSOR_COLOR, "colour", &one.formats);
    } else {
      one.formats.push_back("cannot be opened: " + openni2::last_error());
    }
    devices.push_back(std::move(one));
  }
  return devices;
}

}  // namespace loopsift
