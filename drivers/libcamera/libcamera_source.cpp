// SPDX-License-Identifier: MIT
#include "drivers/libcamera/libcamera_source.hpp"

#include <cassert>

#include "core/base/steady_time.hpp"
#include "drivers/libcamera/camera_session.hpp"
#include "drivers/live_stamps.hpp"

namespace loopsift {
namespace {

class LibcameraSource final : public FrameSource {
 public:
  LibcameraSource(std::string camera, std::unique_ptr<CameraImages> images, const StreamPixelFormat& pixels,
                  SourceInfo info)
      : images_(std::move(images)),
        pixels_(pixels),
        name_("libcamera:" + std::move(camera) + ": "),
        info_(std::move(info)) {
    message_.reserve(name_.size() + 128);
  }
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override { return message_; }

 private:
  [[nodiscard]] ReadStatus report(ReadStatus status, const char* problem);
  [[nodiscard]] const char* fill(const TakenImage& taken, RawFrame* frame);

  std::unique_ptr<CameraImages> images_;
  const StreamPixelFormat& pixels_;
  std::string name_;  // for messages
  SourceInfo info_;
  FrameCounter counter_;
  LiveClock clock_;
  std::string message_;
};

ReadStatus LibcameraSource::report(ReadStatus status, const char* problem) {
  message_.append(name_).append(problem);
  return status;
}

ReadStatus LibcameraSource::read(RawFrame& frame, int timeout_ms) {
  message_.clear();
  TakenImage taken;
  const CameraImages::Take result = images_->take(timeout_ms, &taken);
  if (result == CameraImages::Take::kTimeout) return ReadStatus::kTimeout;
  if (result == CameraImages::Take::kLost) return report(ReadStatus::kLost, "the camera is gone");
  const char* problem = fill(taken, &frame);
  images_->give_back(taken);
  return problem == nullptr ? ReadStatus::kFrame : report(ReadStatus::kBad, problem);
}

// Null, or why the frame cannot be used.
const char* LibcameraSource::fill(const TakenImage& taken, RawFrame* frame) {
  frame->captured_ns = steady_now_ns();
  frame->sequence = counter_.next(taken.count);
  frame->timestamp_ns = clock_.stamp(taken.timestamp_ns, frame->captured_ns);
  frame->depth = {};
  frame->color = {};
  if (taken.damaged) return "the camera says that the frame is damaged";
  if (frame->timestamp_ns < 0) return "the frame's time stamp does not go forward";
  const ImageView<Rgb8> color(frame->color_buffer.data(), taken.image.width, taken.image.height);
  assert(frame->color_buffer.size() >= color.size());
  for (int y = 0; y < color.height; ++y) pixels_.row(taken.image, y, color.row(y));
  frame->color = color;
  return nullptr;
}

}  // namespace

std::unique_ptr<FrameSource> make_libcamera_source(std::string camera, std::unique_ptr<CameraImages> images,
                                                   const StreamPixelFormat& pixels, SourceInfo info) {
  return std::make_unique<LibcameraSource>(std::move(camera), std::move(images), pixels, std::move(info));
}

Expected<std::unique_ptr<FrameSource>> open_libcamera(const std::string& camera,
                                                      const SourceOptions& options) {
  Expected<std::unique_ptr<CameraSession>> session = CameraSession::open(camera, options.libcamera);
  if (!session) return session.error();
  const libcamera::StreamConfiguration& stream = (*session)->stream();
  SourceInfo info;
  info.description =
      "libcamera " + camera + ", " + camera_name((*session)->camera()) + ", " + stream.toString();
  info.color_width = static_cast<int>(stream.size.width);
  info.color_height = static_cast<int>(stream.size.height);
  info.nominal_rate_hz = options.libcamera.rate_hz;
  info.live = true;
  const StreamPixelFormat& pixels = *find_stream_format(stream.pixelFormat);  // a session has no other
  return make_libcamera_source(camera, std::move(*session), pixels, std::move(info));
}

std::vector<DeviceInfo> list_libcamera_devices() {
  std::vector<DeviceInfo> devices;
  const std::shared_ptr<libcamera::CameraManager> manager = shared_camera_manager();
  if (!manager) return devices;
  const std::vector<std::shared_ptr<libcamera::Camera>> cameras = manager->cameras();
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    DeviceInfo device{"libcamera:" + std::to_string(k), camera_name(*cameras[k]), {}};
    const auto configuration = cameras[k]->generateConfiguration({libcamera::StreamRole::Viewfinder});
    if (!configuration || configuration->empty()) continue;
    const libcamera::StreamFormats& formats = configuration->at(0).formats();
    for (const libcamera::PixelFormat& format : formats.pixelformats()) {
      if (find_stream_format(format) == nullptr) continue;
      const libcamera::SizeRange range = formats.range(format);
      device.formats.push_back(format.toString() + " (color) " + range.min.toString() + " to " +
                               range.max.toString());
    }
    devices.push_back(std::move(device));
  }
  return devices;
}

}  // namespace loopsift
