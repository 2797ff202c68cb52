// SPDX-License-Identifier: MIT
// The test camera: one device with a depth and a colour stream, played from a film by a thread of its own.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/support/openni2_plugin/camera_stream.hpp"
#include "tests/support/openni2_plugin/control.hpp"
#include "tests/support/openni2_plugin/film.hpp"

namespace loopsift::test {

/// A film in memory. Empty when the file is not there or is no film.
class MappedFilm {
 public:
  explicit MappedFilm(const std::string& path);
  ~MappedFilm();
  MappedFilm(const MappedFilm&) = delete;
  MappedFilm& operator=(const MappedFilm&) = delete;
  [[nodiscard]] const FilmHeader& header() const { return header_; }
  [[nodiscard]] std::int64_t timestamp_us(std::uint32_t frame) const;
  [[nodiscard]] const std::uint8_t* depth(std::uint32_t frame) const;
  [[nodiscard]] const std::uint8_t* color(std::uint32_t frame) const;

 private:
  [[nodiscard]] const std::uint8_t* at(std::uint32_t frame) const;
  FilmHeader header_;
  const std::uint8_t* bytes_ = nullptr;
  std::size_t size_ = 0;
};

class CameraDevice final : public oni::driver::DeviceBase {
 public:
  /// `over` is set when the film has ended and the device shall go with it.
  explicit CameraDevice(std::atomic<bool>& over);
  ~CameraDevice() override;

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override;
  oni::driver::StreamBase* createStream(OniSensorType sensor) override;
  void destroyStream(oni::driver::StreamBase* stream) override;
  OniStatus getProperty(int id, void* data, int* size) override;
  OniStatus setProperty(int id, const void* data, int size) override;
  OniBool isPropertySupported(int id) override;
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override;

 private:
  void play();
  [[nodiscard]] bool everything_runs();
  void send(std::uint32_t frame, std::int64_t depth_us, int index);

  std::atomic<bool>& over_;
  const CameraControl at_start_;
  MappedFilm film_;
  std::vector<OniVideoMode> depth_modes_, color_modes_;
  std::array<OniSensorInfo, 2> sensors_{};
  std::atomic<int> registration_{ONI_IMAGE_REGISTRATION_OFF};
  std::mutex streams_mutex_;
  std::vector<std::unique_ptr<CameraStream>> streams_;
  std::atomic<bool> closing_{false};
  std::thread player_;
};

}  // namespace loopsift::test
