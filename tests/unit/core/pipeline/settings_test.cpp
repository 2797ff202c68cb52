// SPDX-License-Identifier: MIT
#include "core/pipeline/settings.hpp"

#include <gmock/gmock.h>

#include <cstdio>
#include <fstream>
#include <iterator>

namespace loopsift {
namespace {

using ::testing::HasSubstr;

std::string contents(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(Settings, TheDefaultProfileHoldsEveryKeyWithItsDefault) {
  EXPECT_EQ(contents(LOOPSIFT_CONFIG_DIR "/default.toml"), to_toml(Settings{}))
      << "config/default.toml must be what `loopsift --check-config` prints";
}

TEST(Settings, TheDefaultProfileReadsBackAsTheDefaults) {
  const auto settings = load_settings(LOOPSIFT_CONFIG_DIR "/default.toml", {});
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  EXPECT_EQ(to_toml(*settings), to_toml(Settings{}));
}

TEST(Settings, AssignmentsComeAfterTheFile) {
  const std::string path = ::testing::TempDir() + "settings_test.toml";
  std::ofstream(path) << "[camera]\nfx = 500\nfy = 501\n[run]\nrate = \"max\"\n";
  const auto settings = load_settings(path, {"camera.fx=517.3", "lcm.prefix=ROBOT1_"});
  std::remove(path.c_str());
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  EXPECT_EQ(settings->camera.model.fx, 517.3F);
  EXPECT_EQ(settings->camera.model.fy, 501.0F);
  EXPECT_EQ(settings->lcm.prefix, "ROBOT1_");
  EXPECT_EQ(settings->run.rate, Rate::kMax);
}

TEST(Settings, FileAndAssignmentProblemsAreOneMessage) {
  const std::string path = ::testing::TempDir() + "settings_test_bad.toml";
  std::ofstream(path) << "[camera]\nfx = \"wide\"\nmax_depth = 4.0\n";
  const auto settings = load_settings(path, {"memory.cap_mib=0", "memory.cap=5"});
  std::remove(path.c_str());
  ASSERT_FALSE(settings.ok());
  EXPECT_EQ(settings.error().code, ErrorCode::kUsage);
  const std::string& message = settings.error().message;
  EXPECT_THAT(message, HasSubstr(path + ":2: camera.fx: expected a number"));
  EXPECT_THAT(message, HasSubstr(path + ":3: camera.max_depth: there is no such key; the nearest is "
                                        "camera.max_depth_m"));
  EXPECT_THAT(message, HasSubstr("--set memory.cap_mib=0: memory.cap_mib: 0 is out of range: 1 to 1048576"));
  EXPECT_THAT(message, HasSubstr("the nearest is memory.cap_mib"));
}

TEST(Settings, ContradictionsAreProblems) {
  const auto settings =
      load_settings("", {"camera.min_depth_m=5", "camera.max_depth_m=4", "lcm.url=nowhere"});
  ASSERT_FALSE(settings.ok());
  EXPECT_THAT(settings.error().message, HasSubstr("camera.min_depth_m must be less"));
  EXPECT_THAT(settings.error().message, HasSubstr("lcm.enabled = false"));
}

}  // namespace
}  // namespace loopsift
