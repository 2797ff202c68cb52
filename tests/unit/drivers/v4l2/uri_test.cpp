// SPDX-License-Identifier: MIT
#include "drivers/v4l2/v4l2_uri.hpp"

#include <gmock/gmock.h>

namespace loopsift {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(V4l2Uri, APathAloneKeepsTheDefaults) {
  V4l2Options defaults;
  defaults.format = "Z16";
  defaults.controls = {"a=1"};
  const auto address = parse_v4l2_uri("/dev/v4l/by-id/usb-x:y-video-index0", defaults);
  ASSERT_TRUE(address.ok());
  EXPECT_EQ(address->path, "/dev/v4l/by-id/usb-x:y-video-index0");
  EXPECT_EQ(address->options.format, "Z16");
  EXPECT_THAT(address->options.controls, ElementsAre("a=1"));
}

TEST(V4l2Uri, EveryOptionMayBeNamed) {
  const auto address = parse_v4l2_uri(
      "/dev/video2?format=YUYV&width=1280&height=720&rate_hz=29.97&buffers=8&controls=gain=3,focus=0", {});
  ASSERT_TRUE(address.ok()) << address.error().message;
  EXPECT_EQ(address->path, "/dev/video2");
  EXPECT_EQ(address->options.format, "YUYV");
  EXPECT_EQ(address->options.width, 1280);
  EXPECT_EQ(address->options.height, 720);
  EXPECT_EQ(address->options.rate_hz, 29.97);
  EXPECT_EQ(address->options.buffers, 8);
  EXPECT_THAT(address->options.controls, ElementsAre("gain=3", "focus=0"));
}

TEST(V4l2Uri, AnEmptyListOfControlsReplacesTheDefaults) {
  V4l2Options defaults;
  defaults.controls = {"a=1"};
  EXPECT_TRUE(parse_v4l2_uri("/dev/video0?controls=", defaults)->options.controls.empty());
}

TEST(V4l2Uri, WhatIsWrongIsNamed) {
  EXPECT_THAT(parse_v4l2_uri("", {}).error().message, HasSubstr("v4l2:/dev/video0"));
  EXPECT_THAT(parse_v4l2_uri("?width=3", {}).error().message, HasSubstr("device node"));
  EXPECT_THAT(parse_v4l2_uri("/dev/video0?size=3", {}).error().message,
              AllOf(HasSubstr("'size=3'"), HasSubstr("rate_hz")));
  for (const std::string wrong : {"width=0", "width=-1", "width=1e9", "width", "width=99999", "buffers=33",
                                  "rate_hz=0", "rate_hz=nan", "rate_hz=fast", "height=480x"}) {
    const auto address = parse_v4l2_uri("/dev/video0?" + wrong, {});
    ASSERT_FALSE(address.ok()) << wrong;
    EXPECT_THAT(address.error().message, HasSubstr("'" + wrong + "'"));
  }
}

}  // namespace
}  // namespace loopsift
