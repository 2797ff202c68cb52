// SPDX-License-Identifier: MIT
// `loopsift-tool report`: what it evaluates, the page of a whole run, of half a run, and of none.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "tests/unit/tools/desk_sequence.hpp"
#include "tools/evaluation/point_ply.hpp"
#include "tools/loopsift_tool/run_evaluation.hpp"

namespace loopsift::tool {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

bool can_draw() {
  return std::system("/usr/bin/python3 -c 'import numpy, matplotlib, PIL' 2>/dev/null") == 0;
}

class ReportCommand : public DeskSequence {
 protected:
  /// A run's folder, with one true and one false loop.
  std::string sifted() const {
    const DeskOutcome outcome = run_desk(with(sift_line("sift"), "--out", path("run")));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return path("run");
  }
  [[nodiscard]] std::string page(const std::string& folder) const {
    std::ifstream file(folder + "/report.html");
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(ReportCommand, KnowsErrorsAndWhichLoopsAreTrue) {
  RunEvaluationOptions options;
  options.folder = sifted();
  options.gt = path("gt.txt");
  const auto evaluation = evaluate_run(options);
  ASSERT_TRUE(evaluation.ok()) << evaluation.error().message;
  const auto* json = &evaluation->json;
  const auto& truth = json->at("truth");
  EXPECT_EQ(truth.at("odometry").at("pairs"), 157);
  EXPECT_LE(truth.at("corrected").at("ate_rmse_m"), truth.at("odometry").at("ate_rmse_m"));
  ASSERT_EQ(json->at("loops").size(), 2U);
  EXPECT_EQ(json->at("loops")[0].at("correct"), true);
  EXPECT_LT(json->at("loops")[0].at("error_m"), 1e-6);
  EXPECT_EQ(json->at("loops")[1].at("correct"), false);
  EXPECT_NEAR(json->at("loops")[1].at("error_m"), std::sqrt(0.33), 1e-6);
  EXPECT_EQ(json->at("ranking").at("curve").size(), 2U);
  EXPECT_FALSE(json->contains("dmp_views"));
  EXPECT_TRUE(evaluation->residual.after_m.empty());
}

TEST_F(ReportCommand, TheResidualIsThatAgainstTheMeasuredDepth) {
  RunEvaluationOptions options;
  options.folder = sifted();
  options.source = kSource;
  const auto evaluation = evaluate_run(options);
  ASSERT_TRUE(evaluation.ok()) << evaluation.error().message;
  const auto& views = evaluation->json.at("dmp_views");
  EXPECT_EQ(views.at("frame").size(), 157U) << "each frame of a short recording";
  const auto sum = [](const auto& values) {
    double total = 0;
    for (const double v : values) total += v;
    return total;
  };
  EXPECT_LT(sum(views.at("after")), 0.9 * sum(views.at("before")));

  const MapResidual& residual = evaluation->residual;
  const auto surfels = read_ply_points(options.folder + "/map.ply");
  ASSERT_TRUE(surfels.ok());
  ASSERT_EQ(residual.after_m.size(), surfels->size());
  ASSERT_EQ(residual.before_m.size(), surfels->size());
  double before = 0, after = 0;
  int both = 0;
  for (std::size_t k = 0; k < surfels->size(); ++k) {
    if (!std::isfinite(residual.before_m[k]) || !std::isfinite(residual.after_m[k])) continue;
    EXPECT_GE(residual.after_m[k], 0.0F);
    before += static_cast<double>(residual.before_m[k]);
    after += static_cast<double>(residual.after_m[k]);
    ++both;
  }
  EXPECT_GT(both, static_cast<int>(surfels->size() / 2));
  EXPECT_LT(after, 0.95 * before);
  EXPECT_LT(after / both, 0.2);
}

TEST_F(ReportCommand, ASourceThatIsNotTheRunsIsRefused) {
  RunEvaluationOptions options;
  options.folder = sifted();
  options.source = "replay:tum:/no/such";
  EXPECT_THAT(evaluate_run(options).error().message, HasSubstr("/no/such"));
  folder_.write("run/trajectory_odometry.txt", "900 0 0 0 0 0 0 1\n901 0 0 0 0 0 0 1\n902 0 0 0 0 0 0 1\n");
  options.source = kSource;
  EXPECT_THAT(evaluate_run(options).error().message, HasSubstr("are they of one run?"));
}

TEST_F(ReportCommand, OnePageWithoutNetworkShowsTheWholeRun) {
  if (!can_draw()) GTEST_SKIP() << "python3 has no numpy, matplotlib or PIL";
  const std::string run = sifted();
  const DeskOutcome outcome =
      run_desk({"report", run, "--gt", path("gt.txt"), "--source", kSource, "--title", "A < walk"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string html = page(run);
  EXPECT_THAT(html, AllOf(HasSubstr("A &lt; walk"), HasSubstr("From above"), HasSubstr("before correction"),
                          HasSubstr("Trajectory against ground truth"), HasSubstr("arc accepted"),
                          HasSubstr("Precision and recall"), HasSubstr("residual (median"),
                          HasSubstr("prefers-color-scheme: dark")));
  EXPECT_THAT(html, AllOf(Not(HasSubstr("<script")), Not(HasSubstr("src=\"http")), Not(HasSubstr("<link")),
                          Not(HasSubstr("@import")), Not(HasSubstr("is not there"))));
}

TEST_F(ReportCommand, HalfARunShowsWhatThereIs) {
  if (!can_draw()) GTEST_SKIP() << "python3 has no numpy, matplotlib or PIL";
  const std::string run = path("half");
  std::filesystem::create_directories(run);
  std::filesystem::copy(path("drift.txt"), run + "/trajectory_odometry.txt");
  folder_.write("half/map.ply",
                "ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\nend_header\n");
  const DeskOutcome outcome = run_desk({"report", run, "--gt", path("gt.txt"), "--source", kSource});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(page(run), HasSubstr("the map cannot be held against the recording"));
  EXPECT_THAT(page(run),
              AllOf(HasSubstr("loops.csv is not there"), HasSubstr("run.json is not there"),
                    HasSubstr("map.ply is cut short: 0 of 9"), HasSubstr("Position error over time")));
}

TEST_F(ReportCommand, AnEmptyMapIsSaid) {
  if (!can_draw()) GTEST_SKIP() << "python3 has no numpy, matplotlib or PIL";
  const std::string run = path("bare");
  std::filesystem::create_directories(run);
  std::filesystem::copy(path("drift.txt"), run + "/trajectory_odometry.txt");
  folder_.write("bare/map.ply",
                "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nend_header\n");
  ASSERT_EQ(run_desk({"report", run}).exit_code, 0);
  EXPECT_THAT(page(run), HasSubstr("map.ply is an empty map"));
}

TEST_F(ReportCommand, WhatCannotBeReportedIsSaid) {
  const DeskOutcome none = run_desk({"report", path("no/such/run")});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("--out of a run named"));
  const std::string run = path("late");
  std::filesystem::create_directories(run);
  std::filesystem::copy(path("drift.txt"), run + "/trajectory_odometry.txt");
  folder_.write("other.txt", "900 0 0 0 0 0 0 1\n901 0 0 0 0 0 0 1\n902 0 0 0 0 0 0 1\n");
  const DeskOutcome late = run_desk({"report", run, "--gt", path("other.txt")});
  EXPECT_EQ(late.exit_code, 2);
  EXPECT_THAT(late.err, HasSubstr("no time in common"));
  EXPECT_THAT(run_desk({"report", run, "--gt-loops", path("x.log")}).err, HasSubstr("belong together"));
  folder_.write("short.log", "0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  EXPECT_THAT(run_desk({"report", run, "--gt", path("short.log")}).err,
              HasSubstr("has 1 poses, the run has 157"));
  if (!can_draw()) GTEST_SKIP() << "python3 has no numpy, matplotlib or PIL";
  std::filesystem::create_directories(path("empty"));
  EXPECT_EQ(run_desk({"report", path("empty")}).exit_code, 2);
}

}  // namespace
}  // namespace loopsift::tool
