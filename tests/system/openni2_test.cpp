// SPDX-License-Identifier: MIT
// The onboard program on an OpenNI2 camera: the test camera, which OpenNI2 itself drives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/openni2_plugin/test_camera.hpp"
#include "tests/support/program.hpp"

namespace loopsift {
namespace {

using test::Outcome;
using ::testing::AllOf;
using ::testing::HasSubstr;

class OpenNi2Runs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!test::TestCamera::install()) GTEST_SKIP() << test::TestCamera::kNotAllowed;
  }
  static Outcome run(const std::string& source, const std::string& setting = "lcm.enabled=false") {
    return test::run_program(
        {LOOPSIFT_PROGRAM, "--source", source, "--set", "lcm.enabled=false", "--set", setting});
  }
  test::TestCamera camera_;
};

TEST_F(OpenNi2Runs, WhatCannotBeOpenedIsSaidWithExitCode3) {
  const Outcome wrong = run("openni2:" + camera_.folder().write("foreign.oni", "no recording"));
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_THAT(wrong.output, AllOf(HasSubstr("foreign.oni"), HasSubstr("no OpenNI2 recording")));
  const Outcome missing = run("openni2:/no/such.oni");
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_THAT(missing.output, HasSubstr("/no/such.oni"));
  const Outcome cut = run("openni2:" + camera_.folder().write("cut.oni", "NI10 cut off"));
  EXPECT_EQ(cut.exit_code, 3);
  EXPECT_THAT(cut.output, AllOf(HasSubstr("cut.oni"), HasSubstr("cut off")));
  camera_.control.film = camera_.folder() / "film";
  test::write_drawn_film(camera_.control.film, 2, 64, 48);
  camera_.apply();
  const Outcome unsupported = run("openni2:", "camera.width=1000");
  EXPECT_EQ(unsupported.exit_code, 3);
  EXPECT_THAT(unsupported.output, AllOf(HasSubstr("no mode depth 1000x"), HasSubstr("camera.width")));
  camera_.control.busy = true;
  camera_.apply();
  const Outcome busy = run("openni2:");
  EXPECT_EQ(busy.exit_code, 3);
  EXPECT_THAT(busy.output, HasSubstr("in use by another program"));
  camera_.control.plugged = false;
  camera_.apply();
  const Outcome none = run("openni2:");
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_THAT(none.output, HasSubstr("no such device is connected"));
}

}  // namespace
}  // namespace loopsift
