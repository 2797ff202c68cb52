// SPDX-License-Identifier: MIT
// `loopsift-tool compare`: every filter has its row, and the figures are those of the loops that it kept.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "tests/unit/tools/desk_sequence.hpp"
#include "tools/loopsift_tool/comparison/contest.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class CompareCommand : public DeskSequence {
 protected:
  [[nodiscard]] std::vector<std::string> line() const {
    return with(sift_line("compare"), "--gt", path("gt.txt"));
  }
};

TEST_F(CompareCommand, OneRowPerFilter) {
  const DeskOutcome outcome = run_desk(line());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, Json> rows;
  for (const Json& row : json()) {
    rows[row["filter"]] = row;
    EXPECT_THAT(outcome.out, HasSubstr(row["filter"].get<std::string>()));
    EXPECT_GE(row["wall_s"], 0.0);
  }
  ASSERT_EQ(rows.size(), contestants().size());
  for (const Contestant& filter : contestants()) EXPECT_EQ(rows.count(filter.name), 1U) << filter.name;

  EXPECT_EQ(rows["none"]["accepted"], 0);
  EXPECT_TRUE(rows["none"]["precision"].is_null());
  EXPECT_EQ(rows["none"]["recall"], 0.0);
  EXPECT_EQ(rows["all"]["accepted"], 2);
  EXPECT_EQ(rows["all"]["precision"], 0.5);
  EXPECT_EQ(rows["all"]["recall"], 1.0);
  EXPECT_EQ(rows["all true loops"]["accepted"], 1);
  EXPECT_EQ(rows["all true loops"]["precision"], 1.0);
  EXPECT_LT(rows["all true loops"]["ate_rmse_m"], rows["none"]["ate_rmse_m"]);
  for (const char* ours : {"loopsift", "loopsift_plain"}) {
    EXPECT_EQ(rows[ours]["accepted"], 1) << ours;
    EXPECT_EQ(rows[ours]["precision"], 1.0) << ours;
    EXPECT_EQ(rows[ours]["recall"], 1.0) << ours;
    EXPECT_LT(rows[ours]["ate_rmse_m"], rows["none"]["ate_rmse_m"]) << ours;
    EXPECT_LT(rows[ours]["dmp"], rows["none"]["dmp"]) << ours;
  }
}

TEST_F(CompareCommand, GroundTruthThatDoesNotFit) {
  EXPECT_EQ(run_desk(with(line(), "--gt", path("no.txt"))).exit_code, 2);
  Trajectory half = gt_;
  half.poses.resize(80);
  ASSERT_TRUE(write_trajectory_tum(path("half.txt"), half).ok());
  const DeskOutcome outcome = run_desk(with(line(), "--gt", path("half.txt")));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("no true pose for the first frame of fragment 10"));
}

TEST_F(CompareCommand, GroundTruthOfAnotherTime) {
  Trajectory later = gt_;
  for (StampedPose& pose : later.poses) pose.time_s += 1000.0;
  ASSERT_TRUE(write_trajectory_tum(path("later.txt"), later).ok());
  folder_.write("none.log", "");
  folder_.write("none.info", "");
  const DeskOutcome outcome =
      run_desk(with(with(with(line(), "--loops", path("none.log")), "--info", path("none.info")), "--gt",
                    path("later.txt")));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("do the two overlap in time?"));
}

TEST_F(CompareCommand, DistanceToTheTrueSurface) {
  ASSERT_EQ(run_desk({"synth", kScene, "--no-images", "--out", path("truth")}).exit_code, 0);
  ASSERT_EQ(run_desk(with(line(), "--gt-mesh", path("truth/mesh.ply"))).exit_code, 0);
  std::map<std::string, double> distance_m;
  for (const Json& row : json()) distance_m[row["filter"]] = row["surface_mean_m"];
  EXPECT_GT(distance_m["loopsift"], 0.0);
  EXPECT_LT(distance_m["loopsift"], distance_m["none"]);
  EXPECT_LT(distance_m["loopsift"], distance_m["all"]);
}

TEST_F(CompareCommand, LabelledPairsInsteadOfATrajectory) {
  ASSERT_TRUE(write_log(path("labels.log"), {{kTrueI, kTrueJ, 16, true_motion(kTrueI, kTrueJ)}}).ok());
  ASSERT_TRUE(write_info(path("labels.info"), {{kTrueI, kTrueJ, 16, Matrix6d::Identity()}}).ok());
  std::vector<std::string> labels =
      with(with(sift_line("compare"), "--gt-loops", path("labels.log")), "--gt-info", path("labels.info"));
  ASSERT_EQ(run_desk(labels).exit_code, 0);
  for (const Json& row : json()) {
    EXPECT_TRUE(row["ate_rmse_m"].is_null());
    if (row["filter"] != "all") continue;
    EXPECT_EQ(row["precision"], 0.5);
  }
  EXPECT_THAT(run_desk(sift_line("compare")).err, HasSubstr("--gt-loops"));
  EXPECT_THAT(run_desk(with(sift_line("compare"), "--gt-loops", path("labels.log"))).err,
              HasSubstr("--gt-info"));
}

std::vector<std::string> lines_of(const std::string& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

TEST_F(CompareCommand, SweepWritesEveryFilterAtEveryPoint) {
  const auto sweep = [&](const std::string& csv) {
    return with(
        with(with(with(line(), "--sweep", path(csv)), "--sweep-false", "0,3"), "--sweep-factors", "0.1,1"),
        "--seeds", "1");
  };
  ASSERT_EQ(run_desk(sweep("one.csv")).exit_code, 0);
  const std::vector<std::string> lines = lines_of(path("one.csv"));
  ASSERT_EQ(lines.size(), 1U + 6U * contestants().size());
  const auto count = [&](const std::string& begin) {
    return std::count_if(lines.begin(), lines.end(),
                         [&](const std::string& l) { return l.compare(0, begin.size(), begin) == 0; });
  };
  const auto filters = static_cast<std::ptrdiff_t>(contestants().size());
  EXPECT_EQ(count("false_loops,0,1,"), filters);
  EXPECT_EQ(count("false_loops,3,1,"), filters);
  EXPECT_EQ(count("loop_information,0.1,1,"), filters);
  EXPECT_EQ(count("loop_information,1,1,"), filters);
  EXPECT_EQ(count("odometry_information,0.1,1,"), filters);
  EXPECT_EQ(count("false_loops,0,1,all,2,1,2,0.5,1,"), 1);  // 2 loops, 1 true, 2 kept
  EXPECT_EQ(count("false_loops,3,1,all,5,1,5,0.2,1,"), 1);  // and 3 false ones for the true one

  ASSERT_EQ(run_desk(sweep("two.csv")).exit_code, 0);
  const std::vector<std::string> again = lines_of(path("two.csv"));
  ASSERT_EQ(again.size(), lines.size());
  const auto without_time = [](const std::string& l) { return l.substr(0, l.rfind(',', l.rfind(',') - 1)); };
  for (std::size_t k = 0; k < lines.size(); ++k) EXPECT_EQ(without_time(lines[k]), without_time(again[k]));
}

TEST_F(CompareCommand, OptionsThatDoNotFit) {
  const auto complaint = [](const std::vector<std::string>& arguments) {
    const DeskOutcome outcome = run_desk(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    return outcome.err;
  };
  EXPECT_THAT(complaint(with(sift_line("compare"), "--sweep", path("s.csv"))), HasSubstr("--gt"));
  EXPECT_THAT(complaint(with(sift_line("compare"), "--gt-mesh", path("mesh.ply"))), HasSubstr("--gt"));
  EXPECT_THAT(complaint(with(line(), "--gt-mesh", path("no.ply"))), HasSubstr("no.ply"));
  const std::vector<std::string> sweep = with(line(), "--sweep", path("s.csv"));
  EXPECT_THAT(complaint(with(sweep, "--seeds", "0")), HasSubstr("--seeds"));
  EXPECT_THAT(complaint(with(sweep, "--sweep-factors", "0")), HasSubstr("--sweep-factors"));
  EXPECT_THAT(complaint(with(sweep, "--sweep-false", "-1")), HasSubstr("--sweep-false"));
}

}  // namespace
}  // namespace loopsift::tool
