// SPDX-License-Identifier: MIT
// `loopsift-tool sift` as a user calls it: a true and a wrong loop on a drifting trajectory, and bad input.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "core/posegraph/pose_graph.hpp"
#include "tests/unit/tools/desk_sequence.hpp"
#include "tools/evaluation/trajectory_error.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;

class SiftCommand : public DeskSequence {
 protected:
  [[nodiscard]] std::vector<std::string> line() const {
    return with(sift_line("sift"), "--out", path("out"));
  }
  [[nodiscard]] double ate(const std::string& name) const {
    const auto estimate = read_trajectory(path("out/" + name));
    EXPECT_TRUE(estimate.ok()) << estimate.error().message;
    const auto pairs = associate(gt_, *estimate, {});
    EXPECT_TRUE(pairs.ok()) << pairs.error().message;
    return trajectory_error(*pairs).ate_rmse_m;
  }
};

class SiftScores : public SiftCommand, public ::testing::WithParamInterface<const char*> {};

TEST_P(SiftScores, KeepsTheTrueLoopAndRejectsTheWrongOne) {
  const DeskOutcome outcome = run_desk(with(line(), "--score", GetParam()));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto accepted = read_loops(path("out/accepted.log"), path("out/accepted.info"), 16);
  ASSERT_TRUE(accepted.ok()) << accepted.error().message;
  ASSERT_EQ(accepted->size(), 1U);
  EXPECT_LT(((*accepted)[0].T_i_j.inverse() * true_motion(kTrueI, kTrueJ)).log().norm(), 1e-6);
  EXPECT_LT(ate("trajectory.txt"), 0.9 * ate("trajectory_odometry.txt"));
  EXPECT_EQ(json()["loops"]["proposed"], 2);
  EXPECT_EQ(json()["loops"]["accepted"], 1);
  EXPECT_EQ(json()["loops"]["scored"], 2);
  EXPECT_EQ(json()["loops"]["pending"], 0);
  EXPECT_LT(json()["dmp"]["final"], json()["dmp"]["odometry"]);
}
INSTANTIATE_TEST_SUITE_P(BothScores, SiftScores, ::testing::Values("posterior", "plain"));

TEST_F(SiftCommand, WritesWhatARunWrites) {
  ASSERT_EQ(run_desk(line()).exit_code, 0);
  for (const char* name :
       {"trajectory_odometry.txt", "trajectory.txt", "proposals.log", "proposals.info", "accepted.log",
        "accepted.info", "loops.csv", "posegraph.g2o", "map.ply", "run.json"})
    EXPECT_GT(std::filesystem::file_size(path(std::string("out/") + name)), 0U) << name;
  const auto graph = read_g2o(path("out/posegraph.g2o"));
  ASSERT_TRUE(graph.ok()) << graph.error().message;
  EXPECT_EQ(graph->nodes.size(), 2U * 16);
  const auto proposals = read_loops(path("out/proposals.log"), path("out/proposals.info"), 16);
  ASSERT_TRUE(proposals.ok()) << proposals.error().message;
  EXPECT_EQ(proposals->size(), 2U);
  EXPECT_EQ(json(), nlohmann::json::parse(std::ifstream(path("out/run.json"))));
  EXPECT_EQ(json()["frames"],
            nlohmann::json({{"received", 157}, {"dropped", 0}, {"tracked", 157}, {"lost", 0}}));
  EXPECT_EQ(json()["latency_ms"]["fusion"]["count"], 157);
  EXPECT_EQ(json()["dmp"]["views"], 16 * 3);
}

TEST_F(SiftCommand, WithoutLoopsTheOdometryStays) {
  folder_.write("none.log", "");
  folder_.write("none.info", "");
  const DeskOutcome outcome =
      run_desk(with(with(line(), "--loops", path("none.log")), "--info", path("none.info")));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json()["loops"]["accepted"], 0);
  EXPECT_EQ(json()["dmp"]["final"], json()["dmp"]["odometry"]);
  EXPECT_DOUBLE_EQ(ate("trajectory.txt"), ate("trajectory_odometry.txt"));
}

TEST_F(SiftCommand, SourcesThatCannotBeOpened) {
  const DeskOutcome missing = run_desk(with(line(), "--source", "replay:tum:/no/such/folder"));
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_THAT(missing.err, HasSubstr("/no/such/folder"));
  const DeskOutcome unknown = run_desk(with(line(), "--source", "kitchen:x"));
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("kitchen"));
}

TEST_F(SiftCommand, TrajectoriesThatAreNone) {
  const auto complaint = [&](const std::string& content) {
    folder_.write("bad.txt", content);
    const DeskOutcome outcome = run_desk(with(line(), "--trajectory", path("bad.txt")));
    EXPECT_EQ(outcome.exit_code, 2);
    return outcome.err;
  };
  EXPECT_THAT(complaint("0 0 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n"), HasSubstr("bad.txt:2: 'nan'"));
  EXPECT_THAT(complaint("1 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n"), HasSubstr("bad.txt:2: time goes back"));
  EXPECT_THAT(complaint("900 0 0 0 0 0 0 1\n901 0 0 0 0 0 0 1\n"), HasSubstr("from 900.000 s to 901.000 s"));
  EXPECT_THAT(run_desk(with(line(), "--trajectory", path("no.txt"))).err, HasSubstr("no.txt"));
}

TEST_F(SiftCommand, LoopsThatDoNotFit) {
  const std::string rigid = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const auto complaint = [&](const std::string& content) {
    folder_.write("bad.log", content);
    const DeskOutcome outcome = run_desk(with(with(line(), "--loops", path("bad.log")), "--info", ""));
    EXPECT_EQ(outcome.exit_code, 2);
    return outcome.err;
  };
  EXPECT_THAT(complaint("0 99 100\n" + rigid), HasSubstr("there is no fragment 99"));
  EXPECT_THAT(complaint("3 3 16\n" + rigid), HasSubstr("bad.log: record 1 (3 3)"));
  EXPECT_THAT(complaint("0 5 16\n1 0 0 0\n"), HasSubstr("bad.log:2"));
  EXPECT_THAT(run_desk(with(line(), "--info", path("no.info"))).err, HasSubstr("no.info"));
  EXPECT_EQ(run_desk(with(line(), "--info", path("no.info"))).exit_code, 2);
}

TEST_F(SiftCommand, ALoopBeyondTheEndOfTheTrajectory) {
  Trajectory half = drift_;
  half.poses.resize(80);  // eight fragments; the loops join 1 and 10
  ASSERT_TRUE(write_trajectory_tum(path("half.txt"), half).ok());
  const DeskOutcome outcome = run_desk(with(line(), "--trajectory", path("half.txt")));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("there is no fragment 10; the sequence has 8"));
}

TEST_F(SiftCommand, LoopsOfAnotherFragmentCount) {
  folder_.write("other.log", "1 10 20\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  const DeskOutcome outcome = run_desk(with(with(line(), "--loops", path("other.log")), "--info", ""));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err,
              HasSubstr("other.log: its loops are between 20 fragments, and the recording has 16 of 10"));
}

TEST_F(SiftCommand, WritesTheGraphOfAllFrames) {
  ASSERT_EQ(run_desk(line()).exit_code, 0);
  const auto graph = read_g2o(path("out/posegraph_frames.g2o"));
  ASSERT_TRUE(graph.ok()) << graph.error().message;
  const auto corrected = read_trajectory(path("out/trajectory.txt"));
  ASSERT_TRUE(corrected.ok());
  ASSERT_EQ(graph->nodes.size(), corrected->poses.size());
  EXPECT_EQ(graph->odometry.size(), corrected->poses.size() - 1);
  EXPECT_EQ(graph->loops.size(), 2U * kFragmentFrames - 1);  // of the one that was kept
  for (std::size_t k = 0; k < graph->nodes.size(); k += 13) {
    const Se3 difference = corrected->poses[k].T_world_camera.inverse() * graph->T_map_node[k];
    EXPECT_LT(difference.log().norm(), 1e-6);
    EXPECT_NEAR(1e-9 * static_cast<double>(graph->nodes[k].timestamp_ns), corrected->poses[k].time_s, 1e-6);
  }
  const auto moved = [&](const Edge& edge) {
    return edge.T_a_b.inverse() *
           corrected->poses[static_cast<std::size_t>(edge.a)].T_world_camera.inverse() *
           corrected->poses[static_cast<std::size_t>(edge.b)].T_world_camera;
  };
  for (const Edge& edge : graph->loops) EXPECT_LT(moved(edge).translation().norm(), 0.1);
}

// Somebody else's graph of all frames: its vertices are the odometry, two of its edges the loops.
class SiftGraphs : public SiftCommand, public ::testing::WithParamInterface<bool> {};

TEST_P(SiftGraphs, TakesPosesAndLoopsOfAG2oFile) {
  PoseGraph graph;
  for (const StampedPose& pose : drift_.poses) {
    const auto time_ns = static_cast<std::int64_t>(std::llround(1e9 * pose.time_s));
    graph.nodes.push_back({FragmentId{}, Se3(), GetParam() ? time_ns : 0});
    graph.T_map_node.push_back(pose.T_world_camera);
  }
  const int a = kTrueI * kFragmentFrames + 3, b = kTrueJ * kFragmentFrames + 4;
  const auto true_pose = [&](int frame) { return gt_.poses[static_cast<std::size_t>(frame)].T_world_camera; };
  const Se3 T_b_a = true_pose(b).inverse() * true_pose(a), wrong(so3_exp({0, 0.35, 0}), {0.4, 0.1, -0.4});
  graph.loops.push_back({b, a, T_b_a, 2500.0 * Matrix6d::Identity(), LoopId{0}});
  graph.loops.push_back({b, a, T_b_a * wrong, 2500.0 * Matrix6d::Identity(), LoopId{1}});
  graph.loops.push_back({a, a + 2, Se3(), Matrix6d::Identity(), LoopId{2}});  // inside a fragment: nothing
  ASSERT_TRUE(write_g2o(path("graph.g2o"), graph).ok());

  auto arguments = with(with(line(), "--trajectory", path("graph.g2o")), "--loops", path("graph.g2o"));
  arguments = with(arguments, "--info", "");
  const DeskOutcome outcome = run_desk(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json()["loops"]["proposed"], 2);
  const auto accepted = read_loops(path("out/accepted.log"), path("out/accepted.info"), 16);
  ASSERT_TRUE(accepted.ok()) << accepted.error().message;
  ASSERT_EQ(accepted->size(), 1U);
  const Loop& loop = (*accepted)[0];
  EXPECT_EQ(loop.i.value, kTrueI);
  EXPECT_EQ(loop.j.value, kTrueJ);
  // The frames' places in their fragments are those of the drifting odometry.
  EXPECT_LT((loop.T_i_j.inverse() * true_motion(kTrueI, kTrueJ)).log().norm(), 0.05);
  const DeskOutcome with_info = run_desk(with(arguments, "--info", path("loops.info")));
  EXPECT_THAT(with_info.err, HasSubstr("--info"));
}
INSTANTIATE_TEST_SUITE_P(ByNumberAndByTime, SiftGraphs, ::testing::Bool());

TEST_F(SiftCommand, AGraphOfAnotherRecording) {
  PoseGraph graph;
  graph.nodes.resize(500);
  graph.T_map_node.resize(500);
  graph.loops.push_back({1, 400, Se3(), Matrix6d::Identity(), LoopId{0}});
  ASSERT_TRUE(write_g2o(path("graph.g2o"), graph).ok());
  const DeskOutcome outcome = run_desk(with(with(line(), "--loops", path("graph.g2o")), "--info", ""));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("graph.g2o: vertex 157"));
}

TEST_F(SiftCommand, WhatATimeLimitLeavesIsReported) {
  std::vector<Se3> motions;
  for (int k = 0; k < 20; ++k)
    motions.push_back(true_motion(kTrueI, kTrueJ) * Se3::exp(Vector6d::Constant(1e-4 * k)));
  write_loops_of(motions);
  const DeskOutcome outcome = run_desk(with(line(), "--time-limit", "0.000001"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json()["loops"]["proposed"], 20);
  EXPECT_GT(json()["loops"]["pending"], 0);
  EXPECT_THAT(outcome.err, HasSubstr("of 20 loops were left undecided by the time limit"));
  ASSERT_EQ(run_desk(with(line(), "--time-limit", "1000")).exit_code, 0);
  EXPECT_EQ(json()["loops"]["pending"], 0);
  EXPECT_GE(json()["loops"]["accepted"], 1);
  EXPECT_EQ(run_desk(with(line(), "--time-limit", "-1")).exit_code, 2);
}

TEST_F(SiftCommand, ResolutionOfViewsAndMap) {
  ASSERT_EQ(run_desk(with(line(), "--views", "1")).exit_code, 0);
  const double coarse = json()["memory"]["budget_bytes"];
  ASSERT_EQ(run_desk(with(with(line(), "--views", "1"), "--view-width", "160")).exit_code, 0);
  EXPECT_GT(json()["memory"]["budget_bytes"], coarse);
  EXPECT_EQ(run_desk(with(line(), "--view-width", "2")).exit_code, 2);
  EXPECT_THAT(run_desk(with(line(), "--map-width", "1")).err, HasSubstr("--map-width"));
}

TEST_F(SiftCommand, SettingsThatAreWrong) {
  EXPECT_EQ(run_desk(with(line(), "--fragment-frames", "1")).exit_code, 2);
  const DeskOutcome views = run_desk(with(line(), "--views", "11"));
  EXPECT_EQ(views.exit_code, 2);
  EXPECT_THAT(views.err, HasSubstr("--views"));
  EXPECT_EQ(run_desk(with(line(), "--score", "best")).exit_code, 2);
  EXPECT_EQ(run_desk({"sift", "--help"}).exit_code, 0);
  folder_.write("file", "in the way");
  const DeskOutcome out = run_desk(with(line(), "--out", path("file") + "/out"));
  EXPECT_EQ(out.exit_code, 1);
  EXPECT_THAT(out.err, HasSubstr("file/out"));
}

}  // namespace
}  // namespace loopsift::tool
