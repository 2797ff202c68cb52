// SPDX-License-Identifier: MIT
// What the driver makes of a camera's images: pixels, numbers, times, and those that cannot be used.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <libcamera/formats.h>

#include <vector>

#include "core/base/steady_time.hpp"
#include "tests/support/scripted_images.hpp"

namespace loopsift {
namespace {

using test::ScriptedImage;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 4, kHeight = 2;
constexpr std::size_t kStride = 16;
constexpr std::int64_t kMs = 1'000'000;

class LibcameraRead : public ::testing::Test {
 protected:
  LibcameraRead() : bytes_(kStride * kHeight), color_(kWidth * kHeight), now_(steady_now_ns()) {
    for (std::size_t k = 0; k < bytes_.size(); ++k) bytes_[k] = static_cast<std::uint8_t>(k);
    frame_.color_buffer = color_;
  }
  void open(const std::vector<ScriptedImage>& script) {
    const CameraImage image{bytes_.data(), nullptr, kStride, kWidth, kHeight};
    SourceInfo info;
    info.color_width = kWidth;
    info.color_height = kHeight;
    source_ = make_libcamera_source("0", std::make_unique<test::ScriptedImages>(image, script, &given_back_),
                                    *find_stream_format(libcamera::formats::RGB888), info);
  }
  [[nodiscard]] ReadStatus read() { return source_->read(frame_, 0); }

  std::vector<std::uint8_t> bytes_;
  std::vector<Rgb8> color_;
  RawFrame frame_;
  int given_back_ = 0;
  const std::int64_t now_;
  std::unique_ptr<FrameSource> source_;
};

TEST_F(LibcameraRead, AnImageIsConvertedAndItsBufferGivenBack) {
  open({{CameraImages::Take::kImage, 7, now_ - 5 * kMs}});
  ASSERT_EQ(read(), ReadStatus::kFrame) << source_->message();
  EXPECT_EQ(frame_.timestamp_ns, now_ - 5 * kMs);
  EXPECT_EQ(frame_.sequence, 0);
  EXPECT_TRUE(frame_.depth.empty());
  ASSERT_EQ(frame_.color.width, kWidth);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {  // B, G, R in memory
      const int at = static_cast<int>(kStride) * y + 3 * x;
      EXPECT_EQ(frame_.color(x, y).r, at + 2);
      EXPECT_EQ(frame_.color(x, y).g, at + 1);
      EXPECT_EQ(frame_.color(x, y).b, at);
    }
  EXPECT_EQ(source_->message(), "");
  EXPECT_EQ(given_back_, 1);
}

TEST_F(LibcameraRead, GapsInTheCamerasCountAreGapsInTheSequence) {
  std::vector<ScriptedImage> script;
  for (const std::uint32_t count : {3U, 4U, 7U, 0U})  // 0: the camera began anew
    script.push_back({CameraImages::Take::kImage, count,
                      now_ - 100 * kMs + kMs * static_cast<std::int64_t>(script.size())});
  open(script);
  for (const std::int64_t expected : {0, 1, 4, 5}) {
    ASSERT_EQ(read(), ReadStatus::kFrame);
    EXPECT_EQ(frame_.sequence, expected);
  }
}

TEST_F(LibcameraRead, MissingAndFutureTimesAreThoseOfArrival) {
  open({{CameraImages::Take::kImage, 0, 0}, {CameraImages::Take::kImage, 1, now_ + 3'600'000 * kMs}});
  for (int k = 0; k < 2; ++k) {
    ASSERT_EQ(read(), ReadStatus::kFrame) << k;
    EXPECT_EQ(frame_.timestamp_ns, frame_.captured_ns);
  }
}

TEST_F(LibcameraRead, ATimeThatGoesBackMakesTheFrameBad) {
  open({{CameraImages::Take::kImage, 0, now_ - 5 * kMs},
        {CameraImages::Take::kImage, 1, now_ - 6 * kMs},
        {CameraImages::Take::kImage, 2, now_ - 4 * kMs}});
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), AllOf(HasSubstr("libcamera:0"), HasSubstr("does not go forward")));
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(given_back_, 3);
}

TEST_F(LibcameraRead, ADamagedImageIsBadAndReadingGoesOn) {
  open({{CameraImages::Take::kImage, 0, now_ - 5 * kMs, true},
        {CameraImages::Take::kImage, 1, now_ - 4 * kMs}});
  EXPECT_EQ(read(), ReadStatus::kBad);
  EXPECT_THAT(source_->message(), HasSubstr("damaged"));
  EXPECT_EQ(read(), ReadStatus::kFrame);
  EXPECT_EQ(given_back_, 2);
}

TEST_F(LibcameraRead, SilenceIsATimeoutAndACameraThatIsGoneIsLost) {
  open({{CameraImages::Take::kTimeout}, {CameraImages::Take::kLost}});
  EXPECT_EQ(read(), ReadStatus::kTimeout);
  EXPECT_EQ(read(), ReadStatus::kLost);
  EXPECT_THAT(source_->message(), AllOf(HasSubstr("libcamera:0"), HasSubstr("gone")));
  EXPECT_EQ(given_back_, 0);
}

}  // namespace
}  // namespace loopsift
