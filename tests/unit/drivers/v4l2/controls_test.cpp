// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <cerrno>

#include "tests/unit/drivers/v4l2/fake_camera.hpp"

namespace loopsift {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

constexpr std::uint32_t kGain = V4L2_CID_GAIN, kAuto = V4L2_CID_EXPOSURE_AUTO, kLaser = 0x0A046001;

class V4l2Controls : public test::FakeCamera {
 protected:
  V4l2Controls() {
    video_.controls = {{V4L2_CID_BASE, "Read Only", 0, 1, V4L2_CTRL_TYPE_INTEGER, V4L2_CTRL_FLAG_READ_ONLY},
                       {kGain, "Gain", -10, 64},
                       {kAuto, "Exposure, Auto", 0, 3, V4L2_CTRL_TYPE_MENU},
                       {kAuto + 1, "Text", 0, 0, V4L2_CTRL_TYPE_STRING},
                       {kLaser, "Laser Power (mW)", 0, 360}};
  }
  Error error_of(const std::string& assignment) {
    options_.v4l2.controls = {assignment};
    return open_error();
  }
};

TEST_F(V4l2Controls, AreSetByNameOrNumberInTheGivenOrder) {
  options_.v4l2.controls = {"exposure_auto=1", "0x0a046001=150", "gain=-3", "laser_power_mw=0x10"};
  open();
  EXPECT_THAT(video_.controls_set,
              ElementsAre(Pair(kAuto, 1), Pair(kLaser, 150), Pair(kGain, -3), Pair(kLaser, 16)));
}

TEST_F(V4l2Controls, AnUnknownOneListsThoseThatCanBeSet) {
  for (const std::string name : {"brightness=1", "read_only=1", "text=1", "=1"}) {
    const Error error = error_of(name);
    EXPECT_EQ(error.code, ErrorCode::kUsage);
    EXPECT_THAT(error.message,
                AllOf(HasSubstr("'" + name + "'"), HasSubstr("gain, exposure_auto, laser_power_mw")));
  }
  video_.controls.clear();
  EXPECT_THAT(error_of("gain=1").message, HasSubstr("it has none"));
}

TEST_F(V4l2Controls, MalformedAssignmentsAreRefused) {
  for (const std::string wrong : {"gain", "gain=", "gain=high", "gain=1.5", "gain=1 ", ""})
    EXPECT_THAT(error_of(wrong).message, HasSubstr("whole number")) << wrong;
}

TEST_F(V4l2Controls, ValuesOutOfRangeNameIt) {
  EXPECT_THAT(error_of("gain=65").message, HasSubstr("takes -10 to 64"));
  EXPECT_THAT(error_of("gain=-11").message, HasSubstr("takes -10 to 64"));
  EXPECT_TRUE(video_.controls_set.empty());
}

TEST_F(V4l2Controls, WhatTheDeviceRefusesIsTold) {
  video_.fail(VIDIOC_S_CTRL, EBUSY);
  EXPECT_THAT(error_of("gain=1").message,
              AllOf(HasSubstr("control 'gain=1' cannot be set"), HasSubstr("busy")));
}

}  // namespace
}  // namespace loopsift
