// SPDX-License-Identifier: MIT
#include "tests/support/openni2_plugin/camera_device.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

namespace loopsift::test {
namespace {

constexpr int kModeRate = 30;  // what the modes say, however fast the film is played

}  // namespace

MappedFilm::MappedFilm(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  struct stat status {};
  if (fstat(file, &status) == 0 && static_cast<std::size_t>(status.st_size) > sizeof(FilmHeader)) {
    size_ = static_cast<std::size_t>(status.st_size);
    void* mapped = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file, 0);
    if (mapped != MAP_FAILED) bytes_ = static_cast<const std::uint8_t*>(mapped);
  }
  close(file);
  if (bytes_ == nullptr) return;
  std::memcpy(&header_, bytes_, sizeof header_);
  const bool whole =
      header_.magic == FilmHeader::kMagic && size_ == sizeof header_ + header_.frames * header_.frame_bytes();
  if (!whole) header_ = FilmHeader();
}

MappedFilm::~MappedFilm() {
  if (bytes_ != nullptr) munmap(const_cast<std::uint8_t*>(bytes_), size_);
}

const std::uint8_t* MappedFilm::at(std::uint32_t frame) const {
  return bytes_ + sizeof header_ + frame * header_.frame_bytes();
}
std::int64_t MappedFilm::timestamp_us(std::uint32_t frame) const {
  std::int64_t stamp = 0;
  std::memcpy(&stamp, at(frame), sizeof stamp);
  return stamp;
}
const std::uint8_t* MappedFilm::depth(std::uint32_t frame) const { return at(frame) + sizeof(std::int64_t); }
const std::uint8_t* MappedFilm::color(std::uint32_t frame) const {
  return depth(frame) + header_.depth_bytes();
}

CameraDevice::CameraDevice(std::atomic<bool>& over)
    : over_(over), at_start_(CameraControl::read()), film_(at_start_.film) {
  const int width = static_cast<int>(film_.header().width), height = static_cast<int>(film_.header().height);
  depth_modes_ = {{ONI_PIXEL_FORMAT_DEPTH_1_MM, width, height, kModeRate},
                  {ONI_PIXEL_FORMAT_DEPTH_100_UM, width, height, kModeRate}};
  color_modes_ = {{ONI_PIXEL_FORMAT_RGB888, width, height, kModeRate}};
  sensors_[0] = {ONI_SENSOR_DEPTH, static_cast<int>(depth_modes_.size()), depth_modes_.data()};
  sensors_[1] = {ONI_SENSOR_COLOR, static_cast<int>(color_modes_.size()), color_modes_.data()};
  player_ = std::thread([this] { play(); });
}

CameraDevice::~CameraDevice() {
  closing_ = true;
  player_.join();
}

OniStatus CameraDevice::getSensorInfoList(OniSensorInfo** sensors, int* count) {
  *sensors = sensors_.data();
  *count = film_.header().has_color != 0 ? 2 : 1;
  return ONI_STATUS_OK;
}

oni::driver::StreamBase* CameraDevice::createStream(OniSensorType sensor) {
  const std::vector<OniVideoMode>& modes = sensor == ONI_SENSOR_DEPTH ? depth_modes_ : color_modes_;
  const std::lock_guard lock(streams_mutex_);
  streams_.push_back(std::make_unique<CameraStream>(
      sensor, modes, static_cast<float>(at_start_.field_of_view_rad), at_start_.mirrored));
  return streams_.back().get();
}

void CameraDevice::destroyStream(oni::driver::StreamBase* stream) {
  const std::lock_guard lock(streams_mutex_);
  streams_.erase(std::remove_if(streams_.begin(), streams_.end(),
                                [stream](const auto& owned) { return owned.get() == stream; }),
                 streams_.end());
}

OniStatus CameraDevice::getProperty(int id, void* data, int* size) {
  if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || *size != static_cast<int>(sizeof(int))) {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  const int value = registration_;
  std::memcpy(data, &value, sizeof value);
  return ONI_STATUS_OK;
}

OniStatus CameraDevice::setProperty(int id, const void* data, int size) {
  int value = 0;
  if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || size != static_cast<int>(sizeof value)) {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  std::memcpy(&value, data, sizeof value);
  registration_ = value;
  return ONI_STATUS_OK;
}

OniBool CameraDevice::isPropertySupported(int id) {
  return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION ? TRUE : FALSE;
}

OniBool CameraDevice::isImageRegistrationModeSupported(OniImageRegistrationMode mode) {
  return mode == ONI_IMAGE_REGISTRATION_OFF || at_start_.can_register ? TRUE : FALSE;
}

// The film begins when every stream that was made has been started.
bool CameraDevice::everything_runs() {
  const std::lock_guard lock(streams_mutex_);
  return !streams_.empty() &&
         std::all_of(streams_.begin(), streams_.end(), [](const auto& s) { return s->running(); });
}

void CameraDevice::send(std::uint32_t frame, std::int64_t depth_us, int index) {
  const std::int64_t color_us = depth_us + std::llround(at_start_.color_delay_ms * 1e3);
  const bool has_color = static_cast<int>(frame) % std::max(1, at_start_.color_every) == 0;
  const std::lock_guard lock(streams_mutex_);
  for (const auto& stream : streams_) {
    if (stream->sensor() == ONI_SENSOR_DEPTH) {
      stream->send(film_.depth(frame), static_cast<std::uint64_t>(depth_us), index);
    } else if (has_color) {
      stream->send(film_.color(frame), static_cast<std::uint64_t>(color_us), index);
    }
  }
}

void CameraDevice::play() {
  using Clock = std::chrono::steady_clock;
  const std::uint32_t frames = film_.header().frames;
  std::uint32_t frame = 0;
  std::int64_t lap_us = 0;
  int index = 0;
  auto due = Clock::now();
  while (!closing_) {
    const CameraControl now = CameraControl::read();
    due = std::max(due + std::chrono::nanoseconds(std::llround(1e9 / now.rate_hz)), Clock::now());
    std::this_thread::sleep_until(due);
    if (frame == frames && now.repeat && frames > 1) {
      lap_us += film_.timestamp_us(frames - 1) + film_.timestamp_us(1) - 2 * film_.timestamp_us(0);
      frame = 0;
    }
    if (!now.plugged || now.silent || frame == frames || !everything_runs()) continue;
    send(frame, film_.timestamp_us(frame) + lap_us + std::llround(now.time_offset_s * 1e6), ++index);
    ++frame;
    if (frame == frames && now.unplug_at_end) over_ = true;
  }
}

}  // namespace loopsift::test
