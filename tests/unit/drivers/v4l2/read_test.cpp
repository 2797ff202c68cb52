// SPDX-License-Identifier: MIT
// Frames: their pixels, numbers and times, and those that cannot be used.
#include <gmock/gmock.h>

#include "drivers/replay/image_file.hpp"
#include "tests/unit/drivers/v4l2/fake_camera.hpp"

namespace loopsift {
namespace {

using test::kHeight;
using test::kMs;
using test::kWidth;
using ::testing::HasSubstr;

constexpr std::int64_t kStart = 1000 * kMs;  // the fake's clock

class V4l2Read : public test::FakeCamera {
 protected:
  static std::vector<std::uint8_t> depth_bytes(std::size_t stride) {
    std::vector<std::uint8_t> bytes(stride * kHeight, 0xEE);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * stride + 2 * static_cast<std::size_t>(x);
        bytes[at] = static_cast<std::uint8_t>(value(x, y) & 0xFF);
        bytes[at + 1] = static_cast<std::uint8_t>(value(x, y) >> 8);
      }
    return bytes;
  }
  static int value(int x, int y) { return 500 + 300 * y + x; }
  void expect_depth() const {
    ASSERT_EQ(frame_.depth.width, kWidth);
    ASSERT_EQ(frame_.depth.height, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) ASSERT_EQ(frame_.depth(x, y), value(x, y)) << x << ' ' << y;
    EXPECT_TRUE(frame_.color.empty());
  }
};

TEST_F(V4l2Read, DepthArrivesAsTheDeviceHasIt) {
  video_.events = {frame(depth_bytes(2 * kWidth), 0, kStart - 10 * kMs)};
  open();
  ASSERT_EQ(read(), ReadStatus::kFrame);
  expect_depth();
  EXPECT_EQ(frame_.timestamp_ns, kStart - 10 * kMs);
  EXPECT_EQ(frame_.captured_ns, kStart);
  EXPECT_EQ(frame_.sequence, 0);
  EXPECT_EQ(source_->message(), "");
  EXPECT_EQ(video_.buffers_with_device(), 4);  // given back
}

TEST_F(V4l2Read, RowsMayBeLongerThanTheImage) {
  video_.adjust = [](v4l2_pix_format* format) {
    format->bytesperline = 24;
    format->sizeimage = 24 * kHeight;
  };
  video_.events = {frame(depth_bytes(24), 0, kStart)};
  open();
  ASSERT_EQ(read(), ReadStatus::kFrame);
  expect_depth();
}

TEST_F(V4l2Read, SilenceIsATimeout) {
  open();
  EXPECT_EQ(read(), ReadStatus::kTimeout);
  EXPECT_EQ(video_.now, kStart + 100 * kMs);
}

TEST_F(V4l2Read, AWakeUpWithoutAFrameIsNoFault) {
  video_.events = {take_error(EAGAIN), depth_frame(0, kStart)};
  open();
  EXPECT_EQ(read(), ReadStatus::kTimeout);
  EXPECT_EQ(read(), ReadStatus::kFrame);
}

TEST_F(V4l2Read, GapsInTheDevicesCountAreGapsInTheSequence) {
  std::int64_t time = kStart - 500 * kMs;
  for (const std::uint32_t count : {3U, 4U, 7U, 8U, 0U, 1U})  // 0: the device began anew
    video_.events.push_back(depth_frame(count, time += 33 * kMs));
  open();
  for (const std::int64_t expected : {0, 1, 4, 5, 6, 7}) {
    ASSERT_EQ(read(), ReadStatus::kFrame);
    EXPECT_EQ(frame_.sequence, expected);
  }
}

TEST_F(V4l2Read, MissingAndFutureTimesAreThoseOfArrival) {
  video_.events = {depth_frame(0, 0), depth_frame(1, kStart + 31 * kMs), depth_frame(2, kStart + 3)};
  video_.events.push_back(depth_frame(3, kStart + 3 * kMs));
  video_.events.back().flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  open();
  for (int k = 0; k < 4; ++k) {
    video_.now = kStart + k * kMs;
    ASSERT_EQ(read(), k == 2 ? ReadStatus::kBad : ReadStatus::kFrame) << k;  // 2: its own, and too early
    EXPECT_EQ(frame_.timestamp_ns, k == 2 ? -1 : kStart + k * kMs);
  }
}

TEST_F(V4l2Read, ATimeThatGoesBackIsABadFrameUntilTheClockIsGivenUp) {
  video_.events = {depth_frame(0, kStart)};
  for (std::uint32_t k = 1; k <= 12; ++k)
    video_.events.push_back(depth_frame(k, kStart - 1000 * kMs + k * kMs));
  open();
  EXPECT_EQ(read(), ReadStatus::kFrame);
  for (int k = 1; k <= 12; ++k) {
    video_.now = kStart + k * kMs;
    const ReadStatus status = read();
    EXPECT_EQ(status, k <= 10 ? ReadStatus::kBad : ReadStatus::kFrame) << k;
    EXPECT_EQ(frame_.timestamp_ns, k <= 10 ? -1 : video_.now);
    EXPECT_THAT(source_->message(), k <= 10 ? HasSubstr("does not go forward") : HasSubstr(""));
  }
}

TEST_F(V4l2Read, ShortAndDamagedFramesAreBadAndTheStreamGoesOn) {
  test::VideoEvent short_frame = depth_frame(0, kStart - 40 * kMs),
                   damaged = depth_frame(1, kStart - 30 * kMs);
  short_frame.bytes_used = 2 * kWidth * kHeight - 1;
  damaged.flags |= V4L2_BUF_FLAG_ERROR;
  test::VideoEvent empty = depth_frame(2, kStart - 20 * kMs);
  empty.bytes_used = 0;
  video_.events = {short_frame, damaged, empty, depth_frame(3, kStart - 10 * kMs)};
  open();
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("shorter than its format"));
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("/dev/video0: the device says that the frame is damaged"));
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(frame_.sequence, 3);
  EXPECT_EQ(video_.buffers_with_device(), 4);
}

TEST_F(V4l2Read, YuyvBecomesColour) {
  std::vector<std::uint8_t> bytes;
  for (int pair = 0; pair < kWidth * kHeight / 2; ++pair) bytes.insert(bytes.end(), {235, 128, 81, 128});
  bytes[0] = 81;  // the first pixel: red, as its neighbour nearly is
  bytes[1] = 90;
  bytes[3] = 240;
  video_.events = {frame(bytes, 0, kStart)};
  open("/dev/video0?format=YUYV");
  ASSERT_EQ(read(), ReadStatus::kFrame);
  EXPECT_TRUE(frame_.depth.empty());
  ASSERT_EQ(frame_.color.width, kWidth);
  EXPECT_NEAR(frame_.color(0, 0).r, 255, 1);
  EXPECT_NEAR(frame_.color(0, 0).g, 0, 1);
  EXPECT_NEAR(frame_.color(0, 0).b, 0, 1);
  EXPECT_EQ(frame_.color(2, 0).r, 255);  // white
  EXPECT_EQ(frame_.color(2, 0).b, 255);
  EXPECT_NEAR(frame_.color(3, 3).g, 76, 1);  // 298·65/256
}

class V4l2Mjpeg : public V4l2Read {
 protected:
  V4l2Mjpeg() {
    video_.formats = {V4L2_PIX_FMT_MJPEG};
    video_.adjust = [](v4l2_pix_format* format) {
      format->bytesperline = 0;
      format->sizeimage = 4096;
    };
  }
  static std::vector<std::uint8_t> jpeg() {
    const std::vector<Rgb8> grey(kWidth * kHeight, {200, 200, 200});
    return *encode_jpeg(ImageView<const Rgb8>(grey.data(), kWidth, kHeight), 95);
  }
  // Without its Huffman tables, as many cameras send it.
  static std::vector<std::uint8_t> without_tables(const std::vector<std::uint8_t>& file) {
    std::vector<std::uint8_t> stripped(file.begin(), file.begin() + 2);
    std::size_t at = 2;
    while (file[at + 1] != 0xDA) {  // segments up to the scan
      const std::size_t bytes = 2 + static_cast<std::size_t>(file[at + 2] << 8 | file[at + 3]);
      if (file[at + 1] != 0xC4) stripped.insert(stripped.end(), &file[at], &file[at] + bytes);
      at += bytes;
    }
    stripped.insert(stripped.end(), file.begin() + static_cast<std::ptrdiff_t>(at), file.end());
    return stripped;
  }
};

TEST_F(V4l2Mjpeg, IsDecodedWithAndWithoutHuffmanTables) {
  const std::vector<std::uint8_t> file = jpeg(), stripped = without_tables(file);
  ASSERT_LT(stripped.size(), file.size());
  video_.events = {frame(file, 0, kStart - 1 * kMs), frame(stripped, 1, kStart)};
  open();
  for (int k = 0; k < 2; ++k) {
    ASSERT_EQ(read(), ReadStatus::kFrame) << source_->message();
    EXPECT_NEAR(frame_.color(3, 2).g, 200, 2);
    color_.assign(color_.size(), {});
  }
}

TEST_F(V4l2Mjpeg, ACorruptOneIsABadFrameAndTheNextIsGood) {
  const std::vector<std::uint8_t> file = jpeg();
  std::vector<std::uint8_t> cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(file.size() / 2));
  const std::vector<std::uint8_t> noise(300, 0x5A);
  video_.events = {frame(cut, 0, kStart - 3 * kMs), frame(noise, 1, kStart - 2 * kMs),
                   frame({}, 2, kStart - 1 * kMs), frame(file, 3, kStart)};
  open();
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(read(), ReadStatus::kBad) << k;
    EXPECT_NE(source_->message(), "");
    EXPECT_TRUE(frame_.color.empty());
  }
  EXPECT_EQ(read(), ReadStatus::kFrame);
}

}  // namespace
}  // namespace loopsift
