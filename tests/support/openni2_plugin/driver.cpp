// SPDX-License-Identifier: MIT
// An OpenNI2 driver with one camera that the control file plugs and unplugs: what stands in for hardware in
// tests. OpenNI2 loads it as it loads its own drivers.
#include <chrono>
#include <cstdio>

#include "tests/support/openni2_plugin/camera_device.hpp"

namespace loopsift::test {
namespace {

OniDeviceInfo device_info() {
  OniDeviceInfo info{};
  std::snprintf(info.uri, sizeof info.uri, "%s", "testcam@1");
  std::snprintf(info.vendor, sizeof info.vendor, "%s", "loopsift");
  std::snprintf(info.name, sizeof info.name, "%s", "Test Camera");
  return info;
}

class CameraDriver final : public oni::driver::DriverBase {
 public:
  explicit CameraDriver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    look();
    watcher_ = std::thread([this] { watch(); });
    return ONI_STATUS_OK;
  }

  void shutdown() override {
    closing_ = true;
    if (watcher_.joinable()) watcher_.join();
  }

  oni::driver::DeviceBase* deviceOpen(const char* /*uri*/, const char* /*mode*/) override {
    if (!CameraControl::read().busy) return new CameraDevice(film_over_);
    getServices().errorLoggerAppend("the device is in use by another program");
    return nullptr;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }

  void* enableFrameSync(oni::driver::StreamBase** /*streams*/, int /*count*/) override {
    return CameraControl::read().can_sync ? this : nullptr;
  }

 private:
  // Tells OpenNI2 when the plug was pulled or put in. A test that is over has taken its file away: what is
  // told at the end of the process finds OpenNI2 half gone.
  void look() {
    const std::optional<CameraControl> control = CameraControl::find();
    if (!control) return;
    if (!control->unplug_at_end) film_over_ = false;
    const bool plugged = control->plugged && !film_over_;
    if (plugged == plugged_) return;
    plugged_ = plugged;
    const OniDeviceInfo info = device_info();
    plugged ? deviceConnected(&info) : deviceDisconnected(&info);
  }
  void watch() {
    while (!closing_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      look();
    }
  }

  bool plugged_ = false;
  std::atomic<bool> film_over_{false};
  std::atomic<bool> closing_{false};
  std::thread watcher_;
};

}  // namespace
}  // namespace loopsift::test

ONI_EXPORT_DRIVER(loopsift::test::CameraDriver)
