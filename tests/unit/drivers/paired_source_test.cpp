// SPDX-License-Identifier: MIT
#include "drivers/paired_source.hpp"

#include <gmock/gmock.h>

#include "tests/support/listed_source.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::FrameBuffers;
using test::ListedFrame;
using test::ListedSource;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::Le;

constexpr std::int64_t kMs = 1000000;

SourceInfo depth_info(bool live) {
  SourceInfo info;
  info.description = "depth camera";
  info.camera = {4, 3, 5.0F, 5.0F, 1.5F, 1.0F};
  info.live = live;
  return info;
}

SourceInfo color_info(bool live, double rate_hz = 30) {
  SourceInfo info;
  info.description = "colour camera";
  info.color_width = 8;
  info.color_height = 6;
  info.nominal_rate_hz = rate_hz;
  info.live = live;
  return info;
}

ListedFrame at(std::int64_t ms, unsigned char color = 0) {
  ListedFrame frame;
  frame.timestamp_ns = ms * kMs;
  frame.color_value = color;
  return frame;
}

ListedFrame nothing() {
  ListedFrame frame;
  frame.status = ReadStatus::kTimeout;
  return frame;
}

// What comes out of a pair: the colour of each depth frame, −1 without.
struct Pair {
  ListedSource* color = nullptr;
  std::unique_ptr<PairedSource> source;
  std::unique_ptr<FrameBuffers> buffers;

  Pair(std::vector<ListedFrame> depth, std::vector<ListedFrame> colors, bool live = true,
       double rate_hz = 30) {
    auto color_source = std::make_unique<ListedSource>(color_info(live, rate_hz), std::move(colors));
    color = color_source.get();
    source = std::make_unique<PairedSource>(
        std::make_unique<ListedSource>(depth_info(live), std::move(depth)), std::move(color_source));
    buffers = std::make_unique<FrameBuffers>(source->info());
  }
  std::vector<int> colors() {
    std::vector<int> result;
    while (source->read(buffers->frame, 0) == ReadStatus::kFrame) {
      const RawFrame& frame = buffers->frame;
      EXPECT_TRUE(frame.color.empty() || frame.color.data == frame.color_buffer.data());
      result.push_back(frame.color.empty() ? -1 : frame.color(7, 5).r);
    }
    return result;
  }
};

TEST(PairedSource, ColorWithinHalfAPeriodBelongsToADepthFrame) {
  Pair pair({at(100), at(133), at(166), at(200)}, {at(84, 1), at(149, 2), at(167, 3), at(217, 4)});
  EXPECT_EQ(pair.colors(), (std::vector<int>{1, 2, 3, -1}));
  EXPECT_EQ(pair.source->counts().paired, 3);
  EXPECT_EQ(pair.source->counts().missing, 1);
}

TEST(PairedSource, ItLooksLikeTheDepthSourceWithColor) {
  Pair pair({at(0)}, {at(0)});
  EXPECT_EQ(pair.source->info().camera.width, 4);
  EXPECT_EQ(pair.source->info().color_width, 8);
  EXPECT_THAT(pair.source->info().description, AllOf(HasSubstr("depth camera"), HasSubstr("colour camera")));
}

TEST(PairedSource, ColorFromBeforeTheFirstDepthFrameIsPassedOver) {
  Pair pair({at(1000), at(1033)}, {at(900, 1), at(933, 2), at(967, 3), at(1001, 4), at(1034, 5)});
  EXPECT_EQ(pair.colors(), (std::vector<int>{4, 5}));
  EXPECT_EQ(pair.source->counts().unused, 3);
}

TEST(PairedSource, ColorThatComesBeforeItsDepthFrameIsKeptForIt) {
  Pair pair({at(0), at(33), at(67), at(100)}, {at(1, 1), at(68, 3), at(101, 4)});
  EXPECT_EQ(pair.colors(), (std::vector<int>{1, -1, 3, 4}));
}

TEST(PairedSource, LateColorDoesNotSlipOntoTheNextFrame) {
  // The second image was not there in time; it comes with the third.
  Pair pair({at(0), at(33), at(67)}, {at(1, 1), nothing(), at(34, 2), at(68, 3)});
  EXPECT_EQ(pair.colors(), (std::vector<int>{1, -1, 3}));
  EXPECT_EQ(pair.source->counts().unused, 1);
}

TEST(PairedSource, ADuplicateIsDropped) {
  Pair pair({at(0), at(33), at(67)}, {at(1, 1), at(1, 9), at(34, 2), at(34, 9), at(68, 3)});
  EXPECT_EQ(pair.colors(), (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(pair.source->counts().repeated, 2);
}

TEST(PairedSource, ATimeStampThatJumpsFarAheadDoesNotBlockTheRest) {
  Pair pair({at(0), at(33), at(67)}, {at(1, 1), at(9000000, 9), at(68, 3)});
  EXPECT_EQ(pair.colors(), (std::vector<int>{1, -1, 3}));
}

TEST(PairedSource, AFasterColorCameraGivesTheNearestImage) {
  // 60 Hz: half of its period is 8 ms.
  Pair pair({at(0), at(33)}, {at(-13, 9), at(3, 1), at(20, 9), at(36, 2)}, true, 60);
  EXPECT_EQ(pair.colors(), (std::vector<int>{1, 2}));
}

TEST(PairedSource, CorruptColorLeavesItsFrameWithoutAndSaysWhy) {
  ListedFrame bad = at(33);
  bad.status = ReadStatus::kBad;
  bad.message = "corrupt JPEG";
  Pair pair({at(0), at(33), at(67)}, {at(0, 1), bad, nothing(), at(67, 3)});
  RawFrame& frame = pair.buffers->frame;
  ASSERT_EQ(pair.source->read(frame, 0), ReadStatus::kFrame);
  EXPECT_EQ(pair.source->message(), "");
  ASSERT_EQ(pair.source->read(frame, 0), ReadStatus::kFrame);
  EXPECT_TRUE(frame.color.empty());
  EXPECT_EQ(pair.source->message(), "corrupt JPEG");
  EXPECT_EQ(pair.colors(), (std::vector<int>{3}));
  EXPECT_EQ(pair.source->counts().bad, 1);
}

TEST(PairedSource, DepthGoesOnWhenTheColorCameraIsLost) {
  ListedFrame lost;
  lost.status = ReadStatus::kLost;
  Pair pair({at(0), at(33), at(67)}, {at(0, 1), lost, at(67, 3)});
  EXPECT_EQ(pair.colors(), (std::vector<int>{1, -1, -1}));
}

TEST(PairedSource, ASilentColorCameraIsNotWaitedForForEver) {
  std::vector<ListedFrame> depth, silence(40, nothing());
  for (int i = 0; i < 30; ++i) depth.push_back(at(33 * i));
  silence.push_back(at(33 * 29, 7));
  Pair pair(depth, silence);
  EXPECT_THAT(pair.colors(), Each(-1));
  ASSERT_EQ(pair.color->timeouts.size(), 30U);
  EXPECT_GT(pair.color->timeouts[0], 0);
  EXPECT_THAT(pair.color->timeouts, Each(AllOf(Ge(0), Le(27)))) << "less than a depth frame's period";
  EXPECT_THAT(std::vector<int>(pair.color->timeouts.begin() + 10, pair.color->timeouts.end()), Each(0));
}

TEST(PairedSource, BadDepthAndItsEndComeThrough) {
  ListedFrame bad = at(33);
  bad.status = ReadStatus::kBad;
  bad.message = "torn";
  Pair pair({bad}, {at(0)});
  EXPECT_EQ(pair.source->read(pair.buffers->frame, 0), ReadStatus::kBad);
  EXPECT_EQ(pair.source->message(), "torn");
  EXPECT_EQ(pair.source->read(pair.buffers->frame, 0), ReadStatus::kEnd);
}

TEST(PairedSource, WhatCannotBePairedIsRefused) {
  const auto message = [](const SourceInfo& depth, const SourceInfo& color) {
    const auto pair = PairedSource::create(std::make_unique<ListedSource>(depth, std::vector<ListedFrame>()),
                                           std::make_unique<ListedSource>(color, std::vector<ListedFrame>()));
    return pair.ok() ? "" : pair.error().message;
  };
  EXPECT_EQ(message(depth_info(true), color_info(true)), "");
  EXPECT_THAT(message(depth_info(true), depth_info(true)), HasSubstr("gives no colour"));
  EXPECT_THAT(message(color_info(true), color_info(true)), HasSubstr("gives no depth"));
  EXPECT_THAT(message(depth_info(false), color_info(true)), HasSubstr("cannot be paired"));
}

// Two recordings of one sequence, the one with depth alone and the other with both.
class PairedRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string depths, colors;
    for (int i = 0; i < 3; ++i) {
      const std::string number = std::to_string(i);
      test::write_depth(folder_ / ("seq/depth/" + number + ".png"), test::make_depth(32, 24, i));
      test::write_color_png(folder_ / ("seq/rgb/" + number + ".png"), test::make_color(32, 24, i));
      depths += "1.0" + number + "0000 depth/" + number + ".png\n";
      colors += "1.0" + number + "2000 rgb/" + number + ".png\n";
    }
    folder_.write("seq/depth.txt", depths);
    folder_.write("seq/rgb.txt", colors);
    folder_.write("seq/camera.txt", "width 32\nheight 24\nfx 30\nfy 30\ncx 15.5\ncy 11.5\n");
  }
  test::TemporaryFolder folder_;
};

TEST_F(PairedRecordings, OpenSourcePairsWhatColorSourceNames) {
  const std::string uri = "replay:tum:" + (folder_ / "seq");
  SourceOptions options;
  const auto plain = open_source(uri, options);
  options.color_source = uri;
  const auto paired = open_source(uri, options);
  ASSERT_TRUE(plain.ok()) << plain.error().message;
  ASSERT_TRUE(paired.ok()) << paired.error().message;
  FrameBuffers a((*plain)->info()), b((*paired)->info());
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ((*plain)->read(a.frame, 0), ReadStatus::kFrame);
    ASSERT_EQ((*paired)->read(b.frame, 0), ReadStatus::kFrame);
    EXPECT_TRUE(test::equal(a.frame.depth, b.frame.depth));
    EXPECT_EQ(test::largest_difference(a.frame.color, b.frame.color), 0);
  }
  options.color_source = "replay:tum:/no/such";
  const auto missing = open_source(uri, options);
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, HasSubstr("camera.color_source: "));
}

TEST_F(PairedRecordings, OpenSourceAppliesACameraFileAndItsFactors) {
  const std::string uri = "replay:tum:" + (folder_ / "seq");
  test::DepthImage factors(32, 24);
  for (auto& factor : factors.pixels) factor = 16384;
  test::write_depth(folder_ / "factors.png", factors);
  SourceOptions options;
  options.calibration.file = "camera.toml";
  options.calibration.depth.camera = {32, 24, 31.0F, 32.0F, 15.0F, 11.0F};
  options.calibration.depth_scale = 500;
  options.calibration.correction.factor_file = folder_ / "factors.png";
  options.camera.fx = 33;  // a setting comes before the file
  auto source = open_source(uri, options);
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().camera.fx, 33.0F);
  EXPECT_EQ((*source)->info().camera.fy, 32.0F);
  EXPECT_EQ((*source)->info().depth_unit_m, 0.002);
  FrameBuffers frame((*source)->info());
  ASSERT_EQ((*source)->read(frame.frame, 0), ReadStatus::kFrame);
  const test::DepthImage recorded = test::make_depth(32, 24, 0);
  for (std::size_t i = 0; i < recorded.pixels.size(); ++i) {
    const int raw = recorded.pixels[i] == 65535 ? 0 : recorded.pixels[i];
    ASSERT_EQ(frame.frame.depth.data[i], (raw + 1) / 2) << i;
  }
  options.calibration.correction.factor_file = folder_ / "none.png";
  EXPECT_FALSE(open_source(uri, options).ok());
}

}  // namespace
}  // namespace loopsift
