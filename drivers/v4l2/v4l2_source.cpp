// SPDX-License-Identifier: MIT
#include "drivers/v4l2/v4l2_source.hpp"

#include <cassert>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "drivers/codec/jpeg_decoder.hpp"
#include "drivers/live_stamps.hpp"
#include "drivers/v4l2/controls.hpp"
#include "drivers/v4l2/v4l2_uri.hpp"
#include "drivers/v4l2/video_stream.hpp"

namespace loopsift {
namespace {

constexpr int kUsualWidth = 640, kUsualHeight = 480;
constexpr double kUsualDepthUnitM = 0.001;

class V4l2Source final : public FrameSource {
 public:
  V4l2Source(std::unique_ptr<VideoStream> stream, SourceInfo info);
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override { return message_; }

 private:
  [[nodiscard]] ReadStatus report(ReadStatus status, const char* problem);
  [[nodiscard]] const char* fill(const FilledBuffer& filled, RawFrame* frame);
  [[nodiscard]] const char* unpack(const FilledBuffer& filled, RawFrame* frame);
  void unpack_depth(const std::uint8_t* bytes, const ImageView<std::uint16_t>& depth) const;
  [[nodiscard]] const char* unpack_color(Span<const std::uint8_t> bytes, const ImageView<Rgb8>& color);

  std::unique_ptr<VideoStream> stream_;
  SourceInfo info_;
  std::unique_ptr<JpegDecoder> jpeg_;  // of MJPEG streams
  FrameCounter counter_;
  LiveClock clock_;
  std::string message_;
};

V4l2Source::V4l2Source(std::unique_ptr<VideoStream> stream, SourceInfo info)
    : stream_(std::move(stream)), info_(std::move(info)) {
  const StreamFormat& format = stream_->format();
  if (format.pixels->compressed()) jpeg_ = std::make_unique<JpegDecoder>(format.width, format.height);
  message_.reserve(1024);
}

ReadStatus V4l2Source::report(ReadStatus status, const char* problem) {
  message_.append("v4l2:").append(stream_->device().path()).append(": ").append(problem);
  return status;
}

ReadStatus V4l2Source::read(RawFrame& frame, int timeout_ms) {
  message_.clear();
  FilledBuffer filled;
  switch (stream_->take(timeout_ms, &filled)) {
    case Take::kFilled:
      break;
    case Take::kTimeout:
      return ReadStatus::kTimeout;
    case Take::kRestarted:
      (void)report(ReadStatus::kBad, "the stream had to be started again: ");
      message_.append(std::strerror(stream_->error_number()));
      return ReadStatus::kBad;
    case Take::kLost:
      (void)report(ReadStatus::kLost, "the device is gone or does not go on: ");
      message_.append(std::strerror(stream_->error_number()));
      return ReadStatus::kLost;
  }
  const char* problem = fill(filled, &frame);
  stream_->give_back(filled);
  return problem == nullptr ? ReadStatus::kFrame : report(ReadStatus::kBad, problem);
}

// Null, or why the frame cannot be used.
const char* V4l2Source::fill(const FilledBuffer& filled, RawFrame* frame) {
  frame->captured_ns = stream_->device().system().now_ns();
  frame->sequence = counter_.next(filled.count);
  frame->timestamp_ns = clock_.stamp(filled.timestamp_ns, frame->captured_ns);
  frame->depth = {};
  frame->color = {};
  if (filled.damaged) return "the device says that the frame is damaged";
  if (frame->timestamp_ns < 0) return "the frame's time stamp does not go forward";
  if (filled.bytes.size() < stream_->format().image_bytes())
    return "the frame is shorter than its format says";
  return unpack(filled, frame);
}

const char* V4l2Source::unpack(const FilledBuffer& filled, RawFrame* frame) {
  const StreamFormat& format = stream_->format();
  if (format.pixels->is_depth) {
    const ImageView<std::uint16_t> depth(frame->depth_buffer.data(), format.width, format.height);
    assert(frame->depth_buffer.size() >= depth.size());
    unpack_depth(filled.bytes.data(), depth);
    frame->depth = depth;
    return nullptr;
  }
  const ImageView<Rgb8> color(frame->color_buffer.data(), format.width, format.height);
  assert(frame->color_buffer.size() >= color.size());
  if (const char* problem = unpack_color(filled.bytes, color)) return problem;
  frame->color = color;
  return nullptr;
}

void V4l2Source::unpack_depth(const std::uint8_t* bytes, const ImageView<std::uint16_t>& depth) const {
  const StreamFormat& format = stream_->format();
  for (int y = 0; y < format.height; ++y) {
    const std::uint8_t* row = bytes + static_cast<std::size_t>(y) * format.stride_bytes;
    format.pixels->depth_row(row, format.width, depth.row(y));
  }
}

const char* V4l2Source::unpack_color(Span<const std::uint8_t> bytes, const ImageView<Rgb8>& color) {
  const StreamFormat& format = stream_->format();
  if (jpeg_) return jpeg_->decode(bytes, color);
  for (int y = 0; y < format.height; ++y) {
    const std::uint8_t* row = bytes.data() + static_cast<std::size_t>(y) * format.stride_bytes;
    format.pixels->color_row(row, format.width, format.range, color.row(y));
  }
  return nullptr;
}

int first_positive(int a, int b, int c) { return a > 0 ? a : (b > 0 ? b : c); }

Expected<StreamFormat> negotiate(const VideoDevice& device, const V4l2Options& wanted,
                                 const PinholeCamera& camera) {
  if (Status usable = check_capture(device); !usable) return usable.error();
  const Expected<const PixelFormat*> pixels = choose_format(device, wanted.format);
  if (!pixels) return pixels.error();
  const bool depth = (*pixels)->is_depth;
  const int width = first_positive(wanted.width, depth ? camera.width : 0, kUsualWidth);
  const int height = first_positive(wanted.height, depth ? camera.height : 0, kUsualHeight);
  Expected<StreamFormat> format = set_format(device, **pixels, width, height);
  if (!format) return format;
  format->rate_hz = set_rate(device, wanted.rate_hz);
  if (Status set = set_controls(device, wanted.controls); !set) return set.error();
  return format;
}

Expected<SourceInfo> describe(const VideoDevice& device, const StreamFormat& format, double wanted_rate_hz,
                              const SourceOptions& options) {
  SourceInfo info;
  info.live = true;
  info.nominal_rate_hz = format.rate_hz > 0 ? format.rate_hz : wanted_rate_hz;
  char mode[96];
  std::snprintf(mode, sizeof mode, ", %s %d x %d at %.4g Hz", fourcc_name(format.pixels->code).c_str(),
                format.width, format.height, info.nominal_rate_hz);
  info.description = "v4l2 " + device.path() + ", " + device_name(device) + mode;
  if (!format.pixels->is_depth) {
    info.color_width = format.width;
    info.color_height = format.height;
    return info;
  }
  info.camera = options.camera;
  info.camera.width = format.width;
  info.camera.height = format.height;
  info.depth_unit_m = options.depth_scale > 0 ? 1.0 / options.depth_scale : kUsualDepthUnitM;
  if (info.camera.is_valid()) return info;
  return device.error(ErrorCode::kUsage,
                      "a V4L2 device does not tell its intrinsics; set camera.fx, camera.fy, camera.cx and "
                      "camera.cy");
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> open_v4l2(VideoSystem& system, const std::string& device,
                                                 const SourceOptions& options) {
  const Expected<V4l2Address> address = parse_v4l2_uri(device, options.v4l2);
  if (!address) return address.error();
  Expected<VideoDevice> opened = VideoDevice::open(system, address->path);
  if (!opened) return opened.error();
  const Expected<StreamFormat> format = negotiate(*opened, address->options, options.camera);
  if (!format) return format.error();
  Expected<SourceInfo> info = describe(*opened, *format, address->options.rate_hz, options);
  if (!info) return info.error();
  Expected<std::unique_ptr<VideoStream>> stream =
      VideoStream::start(std::move(*opened), *format, address->options.buffers);
  if (!stream) return stream.error();
  return std::unique_ptr<FrameSource>(std::make_unique<V4l2Source>(std::move(*stream), std::move(*info)));
}

Expected<std::unique_ptr<FrameSource>> open_v4l2(const std::string& device, const SourceOptions& options) {
  return open_v4l2(kernel_video_system(), device, options);
}

}  // namespace loopsift
