// SPDX-License-Identifier: MIT
// Reading frames through V4L2 makes no heap call: depth, converted colour, MJPEG, and frames that are bad.
#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "core/base/heap_watch.hpp"
#include "drivers/replay/image_file.hpp"
#include "drivers/v4l2/v4l2_source.hpp"
#include "tests/support/fake_video.hpp"

namespace loopsift {
namespace {

constexpr int kWidth = 64, kHeight = 48, kFrames = 20;
constexpr std::size_t kPixels = kWidth * kHeight;

// Every second frame is shorter than it should be.
std::int64_t calls_while_reading(std::uint32_t format, const std::vector<std::uint8_t>& image) {
  test::FakeVideo video;
  video.formats = {format};
  for (std::uint32_t k = 0; k < kFrames; ++k) {
    test::VideoEvent event;
    event.bytes = image;
    event.sequence = k;
    event.timestamp_ns = video.now - 1'000'000 * (kFrames - k);
    if (k % 2 == 1) event.bytes_used = 10;
    video.events.push_back(std::move(event));
  }
  SourceOptions options;
  options.camera = {kWidth, kHeight, 50, 50, 32, 24};
  options.v4l2.width = kWidth;
  options.v4l2.height = kHeight;
  const auto source = open_v4l2(video, "/dev/video0", options);
  if (!source.ok()) return -1;
  std::vector<std::uint16_t> depth(kPixels);
  std::vector<Rgb8> color(kPixels);
  RawFrame frame;
  frame.depth_buffer = depth;
  frame.color_buffer = color;
  std::atomic<std::int64_t> calls{0};
  int good = 0, bad = 0;
  {
    const HeapSeal seal(&calls, HeapMode::kCount);
    for (int k = 0; k < kFrames; ++k) {
      const ReadStatus status = (*source)->read(frame, 10);
      good += status == ReadStatus::kFrame ? 1 : 0;
      bad += status == ReadStatus::kBad ? 1 : 0;
    }
  }
  EXPECT_EQ(good, kFrames / 2);
  EXPECT_EQ(bad, kFrames / 2);
  return calls;
}

TEST(V4l2Heap, ReadingMakesNoHeapCall) {
  ASSERT_TRUE(heap_is_watched());
  const std::vector<std::uint8_t> raw(2 * kPixels, 77);
  EXPECT_EQ(calls_while_reading(V4L2_PIX_FMT_Z16, raw), 0);
  EXPECT_EQ(calls_while_reading(V4L2_PIX_FMT_YUYV, raw), 0);
  const std::vector<Rgb8> grey(kPixels, {90, 120, 60});
  const auto jpeg = encode_jpeg(ImageView<const Rgb8>(grey.data(), kWidth, kHeight), 90);
  ASSERT_TRUE(jpeg.ok());
  EXPECT_EQ(calls_while_reading(V4L2_PIX_FMT_MJPEG, *jpeg), 0);
}

}  // namespace
}  // namespace loopsift
