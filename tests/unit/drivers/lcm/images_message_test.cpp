// SPDX-License-Identifier: MIT
#include "drivers/lcm/images_message.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "drivers/lcm/images_decoder.hpp"
#include "tests/support/lcm_images.hpp"

namespace loopsift {
namespace {

using bot_core::image_t;
using ::testing::HasSubstr;

constexpr int kWidth = 12, kHeight = 5;

class Images : public ::testing::Test {
 protected:
  // Parses and decodes; null or what is wrong.
  const char* decode(const std::vector<std::uint8_t>& bytes) {
    ImagesMessage message;
    if (const char* problem = parse_images(bytes, &message)) return problem;
    if (const char* problem = decoder_.decode_depth(message, depth_view())) return problem;
    return message.color.data.empty() ? nullptr : decoder_.decode_color(message.color, color_view());
  }
  ImageView<std::uint16_t> depth_view() { return {depth_.data(), kWidth, kHeight}; }
  ImageView<Rgb8> color_view() { return {color_.data(), kWidth, kHeight}; }
  std::vector<std::uint16_t> depth_ = std::vector<std::uint16_t>(kWidth * kHeight);
  std::vector<Rgb8> color_ = std::vector<Rgb8>(kWidth * kHeight);
  ImagesDecoder decoder_{kWidth, kHeight};
};

TEST_F(Images, DepthRawAndZippedComeOutAsSent) {
  for (const bool zipped : {false, true}) {
    ASSERT_EQ(decode(test::encode(test::images(7, kWidth, kHeight, 1000, zipped))), nullptr);
    EXPECT_EQ(depth_view()(3, 4), 1003);
    EXPECT_EQ(depth_view()(kWidth - 1, 0), 1000 + kWidth - 1);
    EXPECT_EQ(color_view()(2, 2).g, 1000 % 256);
    EXPECT_EQ(color_view()(2, 2).b, 30);
  }
}

TEST_F(Images, RowsMayBePaddedAndColourGrey) {
  bot_core::images_t message = test::images(7, kWidth, kHeight, 500, false);
  image_t& depth = message.images[1];
  std::vector<std::uint8_t> padded;
  for (int y = 0; y < kHeight; ++y) {
    padded.insert(padded.end(), depth.data.begin() + y * depth.row_stride,
                  depth.data.begin() + (y + 1) * depth.row_stride);
    padded.insert(padded.end(), 6, 0xEE);
  }
  depth.data = padded;
  depth.row_stride += 6;
  depth.size = static_cast<std::int32_t>(padded.size());
  image_t& grey = message.images[0];
  grey.pixelformat = image_t::PIXEL_FORMAT_GRAY;
  grey.row_stride = kWidth;
  grey.data.assign(kWidth * kHeight, 99);
  grey.size = kWidth * kHeight;
  ASSERT_EQ(decode(test::encode(message)), nullptr);
  EXPECT_EQ(depth_view()(1, kHeight - 1), 501);
  EXPECT_EQ(color_view()(5, 3).r, 99);
}

TEST_F(Images, WhatIsWrongIsSaid) {
  const auto problem_of = [&](const auto& change) {
    bot_core::images_t message = test::images(7, kWidth, kHeight, 500, false);
    change(&message);
    for (image_t& image : message.images) image.size = static_cast<std::int32_t>(image.data.size());
    const char* problem = decode(test::encode(message));
    return std::string(problem == nullptr ? "nothing" : problem);
  };
  EXPECT_THAT(problem_of([](auto* m) { m->image_types[1] = bot_core::images_t::RIGHT; }),
              HasSubstr("no depth image"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[1].data.resize(9); }), HasSubstr("fewer bytes"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[0].data.resize(9); }), HasSubstr("fewer bytes"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[1].row_stride = 3; }), HasSubstr("fewer bytes"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[1].width = 0; }), HasSubstr("no size"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[0].height = 1 << 30; }), HasSubstr("beyond 8192"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[1].height = kHeight + 1; }), HasSubstr("another size"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[0].pixelformat = 1; }), HasSubstr("colour in a format"));
  EXPECT_THAT(problem_of([](auto* m) { m->images[0].pixelformat = image_t::PIXEL_FORMAT_MJPEG; }),
              ::testing::Not("nothing"));
  EXPECT_THAT(problem_of([](auto* m) { m->image_types[1] = bot_core::images_t::DEPTH_MM_ZIPPED; }),
              HasSubstr("corrupt"));
}

TEST_F(Images, ACutMessageIsRefusedAtEveryLength) {
  const std::vector<std::uint8_t> whole = test::encode(test::images(7, kWidth, kHeight, 500));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<std::uint8_t> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(decode(cut), nullptr) << size;
  }
  std::vector<std::uint8_t> longer = whole;
  longer.push_back(0);
  EXPECT_NE(decode(longer), nullptr);
}

TEST_F(Images, RandomDamageNeverReachesPastTheBuffers) {
  const std::vector<std::uint8_t> whole = test::encode(test::images(7, kWidth, kHeight, 500));
  std::mt19937 random(1);
  int refused = 0;
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::uint8_t> damaged = whole;
    for (int k = 0; k < 3; ++k)
      damaged[8 + random() % (damaged.size() - 8)] = static_cast<std::uint8_t>(random());
    if (decode(damaged) != nullptr) ++refused;
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace loopsift
