// SPDX-License-Identifier: MIT
// One image stream of the test camera, as an OpenNI2 driver has it.
#pragma once
#include <openni2/OniCTypes.h>
// What the header below takes for granted.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <openni2/Driver/OniDriverAPI.h>

#include <atomic>
#include <cstdint>
#include <vector>

namespace loopsift::test {

class CameraStream final : public oni::driver::StreamBase {
 public:
  /// Begins in the first of `modes`, which must outlive it and differ in their pixel format alone.
  CameraStream(OniSensorType sensor, const std::vector<OniVideoMode>& modes, float horizontal_fov_rad,
               bool mirrored);

  OniStatus start() override;
  void stop() override { running_ = false; }
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;
  OniBool isPropertySupported(int id) override;

  [[nodiscard]] bool running() const { return running_; }
  [[nodiscard]] OniSensorType sensor() const { return sensor_; }
  /// Sends one frame, copied from `pixels`. Does nothing when the stream is stopped.
  void send(const void* pixels, std::uint64_t timestamp_us, int index);

 private:
  const OniSensorType sensor_;
  const std::vector<OniVideoMode>& modes_;
  OniVideoMode mode_;
  const float horizontal_fov_rad_;
  const OniBool mirrored_;
  std::atomic<bool> running_{false};
};

}  // namespace loopsift::test
