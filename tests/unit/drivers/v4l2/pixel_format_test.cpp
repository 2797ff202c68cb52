// SPDX-License-Identifier: MIT
// Packed depth, against an independent packer bit by bit.
#include "drivers/v4l2/pixel_format.hpp"

#include <gmock/gmock.h>

#include <set>

#include "tests/support/fake_video.hpp"

namespace loopsift {
namespace {

using ::testing::ElementsAre;

constexpr int kWidth = 9;  // no whole number of groups

std::vector<std::uint16_t> unpack(std::uint32_t code, const std::vector<std::uint8_t>& row, int width) {
  const PixelFormat* format = find_pixel_format(code);
  EXPECT_NE(format, nullptr);
  EXPECT_EQ(format->row_bytes(width), row.size());
  std::vector<std::uint16_t> out(static_cast<std::size_t>(width));
  format->depth_row(row.data(), width, out.data());
  return out;
}

std::vector<std::uint16_t> ramp(int bits) {
  std::vector<std::uint16_t> values;
  values.reserve(kWidth);
  for (int x = 0; x < kWidth; ++x)
    values.push_back(static_cast<std::uint16_t>((0x2A5 * (x + 1) * (x + 3)) & ((1 << bits) - 1)));
  return values;
}

TEST(PixelFormat, SixteenBitsInEitherByteOrder) {
  EXPECT_THAT(unpack(V4L2_PIX_FMT_Z16, {0x34, 0x12, 0xFF, 0xFF}, 2), ElementsAre(0x1234, 0xFFFF));
  EXPECT_THAT(unpack(V4L2_PIX_FMT_Y12, {0x34, 0x02}, 1), ElementsAre(0x234));
  EXPECT_THAT(unpack(V4L2_PIX_FMT_Y16_BE, {0x12, 0x34, 0x00, 0x01}, 2), ElementsAre(0x1234, 1));
}

TEST(PixelFormat, MipiTenBits) {
  const std::vector<std::uint16_t> values = ramp(10);
  std::vector<std::uint8_t> row(15, 0);
  for (std::size_t x = 0; x < kWidth; ++x) {
    row[x / 4 * 5 + x % 4] = static_cast<std::uint8_t>(values[x] >> 2);
    row[x / 4 * 5 + 4] = static_cast<std::uint8_t>(row[x / 4 * 5 + 4] | (values[x] & 3) << (2 * (x % 4)));
  }
  EXPECT_EQ(unpack(V4L2_PIX_FMT_Y10P, row, kWidth), values);
}

TEST(PixelFormat, MipiTwelveBits) {
  const std::vector<std::uint16_t> values = ramp(12);
  std::vector<std::uint8_t> row(15, 0);
  for (std::size_t x = 0; x < kWidth; ++x) {
    row[x / 2 * 3 + x % 2] = static_cast<std::uint8_t>(values[x] >> 4);
    row[x / 2 * 3 + 2] = static_cast<std::uint8_t>(row[x / 2 * 3 + 2] | (values[x] & 15) << (4 * (x % 2)));
  }
  EXPECT_EQ(unpack(v4l2_fourcc('Y', '1', '2', 'P'), row, kWidth), values);
}

TEST(PixelFormat, TenBitsAsOneStream) {
  const std::vector<std::uint16_t> values = ramp(10);
  std::vector<std::uint8_t> row(15, 0);
  for (std::size_t bit = 0; bit < 10 * kWidth; ++bit) {
    const int value = values[bit / 10] >> (9 - bit % 10) & 1;
    row[bit / 8] = static_cast<std::uint8_t>(row[bit / 8] | value << (7 - bit % 8));
  }
  EXPECT_EQ(unpack(V4L2_PIX_FMT_Y10BPACK, row, kWidth), values);
}

TEST(PixelFormat, EachHasANameOfItsOwnAndOneWayToBeRead) {
  std::set<std::string> names;
  for (const PixelFormat& format : known_pixel_formats()) {
    names.insert(fourcc_name(format.code));
    EXPECT_EQ(find_pixel_format(format.code), &format);
    const int ways = (format.depth_row != nullptr) + (format.color_row != nullptr) + format.compressed();
    EXPECT_EQ(ways, 1) << fourcc_name(format.code);
    EXPECT_EQ(format.is_depth, format.depth_row != nullptr);
  }
  EXPECT_EQ(names.size(), known_pixel_formats().size());
  EXPECT_EQ(names.count("Z16"), 1U);
  EXPECT_EQ(names.count("Y16-BE"), 1U);
  EXPECT_EQ(find_pixel_format(V4L2_PIX_FMT_H264), nullptr);
}

}  // namespace
}  // namespace loopsift
