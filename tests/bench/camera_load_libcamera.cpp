// SPDX-License-Identifier: MIT
// libcamera's colour from scripted buffers; the hand-over between threads is not in it.
#include <libcamera/formats.h>

#include "drivers/libcamera/camera_images.hpp"
#include "tests/bench/camera_load.hpp"

namespace loopsift::bench {
namespace {

class SameImage final : public CameraImages {
 public:
  explicit SameImage(const CameraImage& image) : image_(image) {}
  [[nodiscard]] Take take(int /*timeout_ms*/, TakenImage* taken) override {
    pace_.wait();
    *taken = {0, image_, count_++, 0, false};
    return Take::kImage;
  }
  void give_back(const TakenImage& /*taken*/) override {}

 private:
  CameraImage image_;
  Pace pace_;
  std::uint32_t count_ = 0;
};

void load_format(const std::string& name, const StreamPixelFormat& pixels, bool decodes) {
  const std::vector<std::uint8_t> bytes(std::size_t{4} * kWidth * kHeight, 90);
  CameraImage image{bytes.data(), bytes.data(), static_cast<std::size_t>(pixels.bytes_per_pixel * kWidth),
                    kWidth, kHeight};
  test::ColorImage out(kWidth, kHeight);
  const double conversion_s = cost_s([&] {
    for (int y = 0; y < kHeight; ++y) pixels.row(image, y, out.view().row(y));
  });
  SourceInfo info;
  info.color_width = kWidth;
  info.color_height = kHeight;
  const auto source = make_libcamera_source("0", std::make_unique<SameImage>(image), pixels, info);
  measure(name, *source, decodes ? conversion_s : 0, [] {});
}

}  // namespace

void load_libcamera() {
  load_format("libcamera, BGR888", *find_stream_format(libcamera::formats::BGR888), false);
  load_format("libcamera, NV12", *find_stream_format(libcamera::formats::NV12), true);
}

}  // namespace loopsift::bench
