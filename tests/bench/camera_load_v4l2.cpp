// SPDX-License-Identifier: MIT
// V4L2 with a scripted device behind the system calls: its copy into the mapped buffer, which a real device
// makes by itself, is counted with the rest.
#include <cstring>

#include "core/base/steady_time.hpp"
#include "drivers/codec/jpeg_decoder.hpp"
#include "drivers/codec/pixel_rows.hpp"
#include "drivers/paired_source.hpp"
#include "drivers/replay/image_file.hpp"
#include "drivers/v4l2/v4l2_source.hpp"
#include "tests/bench/camera_load.hpp"
#include "tests/support/fake_video.hpp"

namespace loopsift::bench {
namespace {

void script(std::uint32_t format, std::vector<std::uint8_t> image, test::FakeVideo* video) {
  video->formats = {format};
  test::VideoEvent event;
  event.bytes = std::move(image);
  video->events = {event};
  video->repeats = true;
}

std::vector<std::uint8_t> yuyv() {
  std::vector<std::uint8_t> bytes;
  for (const Rgb8& pixel : picture().color.pixels) bytes.insert(bytes.end(), {pixel.g, pixel.b});
  return bytes;
}

void load_pair(const std::string& name, std::uint32_t format, std::vector<std::uint8_t> image,
               double decoding_s) {
  test::FakeVideo depth_video, color_video;
  script(V4L2_PIX_FMT_Z16, test::raw_bytes(picture().depth), &depth_video);
  script(format, std::move(image), &color_video);
  auto depth = open_v4l2(depth_video, "/dev/video0", usual_options());
  auto color = open_v4l2(color_video, "/dev/video0", usual_options());
  if (!depth.ok() || !color.ok()) return print_skipped(name, "the scripted devices do not open");
  const auto pair = PairedSource::create(std::move(*depth), std::move(*color));
  Pace pace;
  measure(name, **pair, decoding_s, [&] {
    pace.wait();
    depth_video.now = color_video.now = steady_now_ns();
  });
}

}  // namespace

void load_v4l2() {
  test::ColorImage out(kWidth, kHeight);
  const std::vector<std::uint8_t> raw = yuyv();
  load_pair("v4l2, Z16 and YUYV", V4L2_PIX_FMT_YUYV, raw, cost_s([&] {
              for (int y = 0; y < kHeight; ++y)
                yuyv_to_rgb(raw.data() + std::size_t{2} * kWidth * static_cast<std::size_t>(y), kWidth,
                            YuvRange::kLimited, out.view().row(y));
            }));
  const std::vector<std::uint8_t> jpeg = test::jpeg_bytes(picture().color);
  JpegDecoder decoder(kWidth, kHeight);
  load_pair("v4l2, Z16 and MJPEG", V4L2_PIX_FMT_MJPEG, jpeg, cost_s([&] {
              (void)decoder.decode({jpeg.data(), jpeg.size()}, out.view());
            }));
}

}  // namespace loopsift::bench
