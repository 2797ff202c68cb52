// SPDX-License-Identifier: MIT
// What one frame costs from the device's buffer to the consumer's, without the kernel.
#include <benchmark/benchmark.h>

#include <vector>

#include "drivers/replay/image_file.hpp"
#include "drivers/v4l2/v4l2_source.hpp"
#include "tests/support/fake_video.hpp"

namespace loopsift {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;

// A picture with edges and shades.
std::vector<std::uint8_t> picture(std::uint32_t format) {
  std::vector<std::uint8_t> bytes(2 * kPixels);
  std::vector<Rgb8> color(kPixels);
  for (std::size_t k = 0; k < kPixels; ++k) {
    const std::size_t x = k % kWidth, y = k / kWidth;
    const auto shade = static_cast<unsigned char>((x / 40 + y / 40) % 2 * 100 + (x * y) / 2500);
    bytes[2 * k] = shade;
    bytes[2 * k + 1] = static_cast<std::uint8_t>(120 + k % 16);
    color[k] = {shade, static_cast<unsigned char>(x / 3), static_cast<unsigned char>(y / 2)};
  }
  if (format != V4L2_PIX_FMT_MJPEG) return bytes;
  return *encode_jpeg(ImageView<const Rgb8>(color.data(), kWidth, kHeight), 90);
}

void v4l2_frame(benchmark::State& state, std::uint32_t format) {
  test::FakeVideo video;
  video.formats = {format};
  test::VideoEvent event;
  event.bytes = picture(format);
  video.events = {event};
  video.repeats = true;
  SourceOptions options;
  options.camera = {kWidth, kHeight, 570, 570, 320, 240};
  const auto source = open_v4l2(video, "/dev/video0", options);
  std::vector<std::uint16_t> depth(kPixels);
  std::vector<Rgb8> color(kPixels);
  RawFrame frame;
  frame.depth_buffer = depth;
  frame.color_buffer = color;
  for (auto _ : state) {
    video.now += 33'000'000;
    if ((*source)->read(frame, 10) != ReadStatus::kFrame) state.SkipWithError("no frame");
  }
}

BENCHMARK_CAPTURE(v4l2_frame, z16, V4L2_PIX_FMT_Z16)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(v4l2_frame, yuyv, V4L2_PIX_FMT_YUYV)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(v4l2_frame, mjpeg, V4L2_PIX_FMT_MJPEG)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace loopsift
