// SPDX-License-Identifier: MIT
#include "firmware_app/settings.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;

std::string contents(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string default_toml() {
  const Settings defaults;
  return to_toml(defaults);
}

TEST(Settings, TheDefaultProfileHoldsEveryKeyWithItsDefault) {
  EXPECT_EQ(contents(LOOPSIFT_CONFIG_DIR "/default.toml"), default_toml())
      << "config/default.toml must be what `loopsift --check-config` prints";
}

TEST(Settings, TheDefaultProfileReadsBackAsTheDefaults) {
  const auto settings = load_settings(LOOPSIFT_CONFIG_DIR "/default.toml", {});
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  EXPECT_EQ(to_toml(*settings), default_toml());
}

TEST(Settings, AssignmentsComeAfterTheFile) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "settings.toml";
  std::ofstream(path) << "[camera]\nfx = 500\nfy = 501\n[run]\nrate = \"max\"\n";
  const auto settings = load_settings(path, {"camera.fx=517.3", "lcm.prefix=ROBOT1_"});
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  EXPECT_EQ(settings->camera.model.fx, 517.3F);
  EXPECT_EQ(settings->camera.model.fy, 501.0F);
  EXPECT_EQ(settings->lcm.prefix, "ROBOT1_");
  EXPECT_EQ(settings->run.rate, Rate::kMax);
}

TEST(Settings, FileAndAssignmentProblemsAreOneMessage) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "bad.toml";
  std::ofstream(path) << "[camera]\nfx = \"wide\"\nmax_depth = 4.0\n";
  const auto settings = load_settings(path, {"memory.cap_mib=0", "memory.cap=5"});
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

TEST(Settings, OneKeySetsAllThatNeedIt) {
  const auto settings =
      load_settings("", {"camera.min_depth_m=0.5", "camera.max_depth_m=3.5", "camera.noise_floor_m=0.002",
                         "camera.noise_slope_per_m=0.004", "store.max_fragments=17",
                         "fragment.views_per_fragment=2", "posterior.max_view_width=40"});
  ASSERT_TRUE(settings.ok()) << settings.error().message;
  const FrontEndOptions& front = settings->front_end;
  const BackEndOptions& back = settings->back_end;
  EXPECT_EQ(front.frame.min_depth_m, 0.5F);
  EXPECT_EQ(back.posterior.min_depth_m, 0.5F);
  EXPECT_EQ(front.frame.max_depth_m, 3.5F);
  EXPECT_EQ(back.posterior.max_depth_m, 3.5F);
  EXPECT_EQ(front.odometry.noise_floor_m, 0.002F);
  EXPECT_EQ(front.fragment.noise_floor_m, 0.002F);
  EXPECT_EQ(front.odometry.noise_slope, 0.004F);
  EXPECT_EQ(front.fragment.noise_slope, 0.004F);
  EXPECT_EQ(back.proposal.max_fragments, 17);
  EXPECT_EQ(back.posterior.max_fragments, 17);
  EXPECT_EQ(back.posterior.max_views_per_fragment, 2);
  EXPECT_EQ(settings->store.max_views, 34);
  EXPECT_EQ(settings->store.max_view_pixels, 40 * back.posterior.max_view_height);
}

TEST(Settings, TheScoreIsChosenByName) {
  const auto plain = load_settings("", {"sifter.score=plain"});
  ASSERT_TRUE(plain.ok()) << plain.error().message;
  EXPECT_EQ(plain->back_end.sifter.score, ScoreKind::kPlain);
  const auto other = load_settings("", {"sifter.score=best"});
  ASSERT_FALSE(other.ok());
  EXPECT_THAT(other.error().message, HasSubstr("expected one of \"posterior\", \"plain\""));
}

TEST(Settings, ProblemsOfAllStagesAreOneMessage) {
  const auto settings = load_settings(
      "", {"frame.reduction=3", "fragment.views_per_fragment=60", "proposal.feature_radius_m=0.04",
           "store.max_fragments=65535", "odometry.iterations_fine=0"});
  ASSERT_FALSE(settings.ok());
  const std::string& message = settings.error().message;
  EXPECT_THAT(message, HasSubstr("frame.reduction must be 1, 2 or 4"));
  EXPECT_THAT(message, HasSubstr("fragment.views_per_fragment must be from 1 to frames_per_fragment"));
  EXPECT_THAT(message, HasSubstr("proposal.feature_radius_m must be more than voxel_m"));
  EXPECT_THAT(message, HasSubstr("store.max_fragments times fragment.views_per_fragment"));
  EXPECT_THAT(message, HasSubstr("odometry.iterations_fine: 0 is out of range"));
}

TEST(Settings, ViewsMustFitTheScorer) {
  Settings settings;
  finalize(&settings);
  PinholeCamera camera;
  EXPECT_THAT(check_views(settings, camera).error().message, HasSubstr("camera.color_source"));
  camera.width = 640;
  camera.height = 480;
  EXPECT_TRUE(check_views(settings, camera).ok());
  camera.width = 1280;
  camera.height = 720;
  const Status status = check_views(settings, camera);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kUsage);
  EXPECT_THAT(status.error().message, HasSubstr("fragment.view_step = 16"));
  EXPECT_THAT(status.error().message, HasSubstr("set it to 32"));
  settings.front_end.fragment.view_step = 32;
  EXPECT_TRUE(check_views(settings, camera).ok());
}

TEST(Settings, ProfilesAreValid) {
  for (const char* profile : {"small", "large"}) {
    const auto settings = load_settings(std::string(LOOPSIFT_CONFIG_DIR "/") + profile + ".toml", {});
    EXPECT_TRUE(settings.ok()) << profile << ": " << settings.error().message;
  }
}

}  // namespace
}  // namespace loopsift
