// SPDX-License-Identifier: MIT
// `loopsift-tool dmp`: the truth scores better than a drifting trajectory, reduced and in full.
#include <gmock/gmock.h>

#include <filesystem>

#include "drivers/replay/image_file.hpp"
#include "tests/unit/tools/desk_sequence.hpp"
#include "tools/loopsift_tool/residual_image.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;

class DmpCommand : public DeskSequence {
 protected:
  nlohmann::json dmp_of(const std::string& trajectory, const std::vector<std::string>& more) const {
    std::vector<std::string> line = {"dmp",
                                     "--source",
                                     kSource,
                                     "--trajectory",
                                     trajectory,
                                     "--json",
                                     path("out.json"),
                                     "--fragment-frames",
                                     std::to_string(kFragmentFrames)};
    line.insert(line.end(), more.begin(), more.end());
    const DeskOutcome outcome = run_desk(line);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return json();
  }
};

TEST_F(DmpCommand, TheTruthIsBetterThanDrift) {
  const auto truth = dmp_of(path("gt.txt"), {}), drift = dmp_of(path("drift.txt"), {});
  EXPECT_GT(truth["dmp"], 0.0);
  EXPECT_LT(truth["dmp"], drift["dmp"]);
  EXPECT_EQ(truth["views"], 16 * 3);
  EXPECT_GT(truth["valid_pixels"], 16 * 3 * 40 * 30 / 2);
  EXPECT_LE(truth["valid_pixels"], 16 * 3 * 40 * 30);
  EXPECT_EQ(dmp_of(path("gt.txt"), {"--views", "1"})["views"], 16);
}

TEST_F(DmpCommand, InFullEveryFrameCounts) {
  const auto truth = dmp_of(path("gt.txt"), {"--full"}), drift = dmp_of(path("drift.txt"), {"--full"});
  EXPECT_GT(truth["dmp"], 0.0);
  EXPECT_LT(truth["dmp"], drift["dmp"]);
  EXPECT_EQ(truth["views"], 157);
  EXPECT_GT(truth["valid_pixels"], 157 * 160 * 120 / 2);
  EXPECT_LE(truth["valid_pixels"], 157 * 160 * 120);
}

TEST_F(DmpCommand, ViewsAddUpToTheWhole) {
  for (const auto& form : {std::vector<std::string>{"--per-view"}, {"--per-view", "--full"}}) {
    const auto figures = dmp_of(path("drift.txt"), form);
    ASSERT_EQ(figures["per_view"].size(), figures["views"]);
    double sum = 0;
    int last = -1;
    for (const auto& view : figures["per_view"]) {
      sum += view["dmp"].get<double>();
      EXPECT_GT(view["frame"], last);
      last = view["frame"];
      EXPECT_EQ(view["fragment"], last / kFragmentFrames);
      EXPECT_NEAR(view["time_s"], last * 0.25, 1e-6);
    }
    EXPECT_NEAR(sum, figures["dmp"], 1e-5 * sum);
  }
}

TEST_F(DmpCommand, HeatmapsAreAsLargeAsWhatIsScored) {
  const auto size_of = [&](const std::string& name) {
    const auto size = read_image_size(path(name));
    EXPECT_TRUE(size.ok()) << size.error().message;
    return size.ok() ? std::make_pair(size->width, size->height) : std::make_pair(0, 0);
  };
  dmp_of(path("drift.txt"), {"--full", "--heatmap", path("heat"), "--heatmap-every", "50"});
  for (const char* name : {"heat/frame-000000.png", "heat/frame-000150.png"})
    EXPECT_EQ(size_of(name), std::make_pair(160, 120));
  EXPECT_FALSE(std::filesystem::exists(path("heat/frame-000001.png")));

  const auto views = dmp_of(path("drift.txt"), {"--per-view", "--heatmap", path("views"), "--heatmap-every",
                                                "1", "--view-width", "80"});
  for (const auto& view : views["per_view"]) {
    char name[40];
    std::snprintf(name, sizeof name, "views/frame-%06d.png", view["frame"].get<int>());
    EXPECT_EQ(size_of(name), std::make_pair(80, 60));
  }
  folder_.write("file", "in the way");
  const DeskOutcome outcome = run_desk(
      {"dmp", "--source", kSource, "--trajectory", path("gt.txt"), "--heatmap", path("file") + "/heat"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("file/heat"));
}

TEST(ResidualColor, TellsInFrontFromBehindAndUnknown) {
  const Rgb8 agree = residual_color(2, 2), front = residual_color(1.8, 2), behind = residual_color(2.2, 2);
  EXPECT_EQ(agree.r + agree.g + agree.b, 3 * 255);
  EXPECT_GT(front.r, front.b + 100);
  EXPECT_GT(behind.b, behind.r + 100);
  EXPECT_EQ(residual_color(0, 2).r, residual_color(0, 2).b);
  EXPECT_EQ(residual_color(2, 0).r + residual_color(2, 0).g, 0);
}

TEST_F(DmpCommand, FramesWithoutAPoseAreLeftOut) {
  Trajectory half = gt_;
  half.poses.resize(80);
  ASSERT_TRUE(write_trajectory_tum(path("half.txt"), half).ok());
  EXPECT_EQ(dmp_of(path("half.txt"), {})["views"], 8 * 3);
  EXPECT_EQ(dmp_of(path("half.txt"), {"--full"})["views"], 80);
}

TEST_F(DmpCommand, WrongInputIsNamed) {
  folder_.write("late.txt", "900 0 0 0 0 0 0 1\n901 0 0 0 0 0 0 1\n");
  for (const char* form : {"--views=3", "--full"}) {
    const DeskOutcome outcome = run_desk({"dmp", "--source", "synth:room?width=32&height=24&frames=4&color=0",
                                          "--trajectory", path("late.txt"), form});
    EXPECT_EQ(outcome.exit_code, 2) << form;
    EXPECT_THAT(outcome.err, HasSubstr("late.txt has poses from 900.000 s")) << form;
  }
  EXPECT_EQ(run_desk({"dmp", "--source", "replay:tum:/no/such", "--trajectory", path("gt.txt")}).exit_code,
            3);
}

}  // namespace
}  // namespace loopsift::tool
