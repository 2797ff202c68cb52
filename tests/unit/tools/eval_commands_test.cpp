// SPDX-License-Identifier: MIT
// The evaluation commands as a user calls them: exit codes, messages, files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/geometry/trajectory.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

using testing::HasSubstr;

struct Outcome {
  int exit_code;
  std::string out, err;
};

Outcome run(std::vector<std::string> arguments) {
  std::vector<const char*> argv = {"loopsift-tool"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit_code = run_tool(static_cast<int>(argv.size()), argv.data());
  std::string out = testing::internal::GetCapturedStdout();
  return {exit_code, std::move(out), testing::internal::GetCapturedStderr()};
}

class EvalCommandsTest : public testing::Test {
 protected:
  EvalCommandsTest()
      : folder_(testing::TempDir() + "eval_" +
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::create_directories(folder_);
  }
  ~EvalCommandsTest() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }

  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name)) << content;
    return path(name);
  }
  /// A square walk of 41 poses, 10 Hz.
  std::string write_walk(const std::string& name, double start_s, std::size_t count = 41) const {
    Trajectory trajectory;
    for (std::size_t k = 0; k < count; ++k) {
      const double s = 0.1 * static_cast<double>(k);
      const Eigen::Vector3d position(std::min(s, 2.0), std::max(0.0, s - 2.0), 0);
      trajectory.poses.push_back({start_s + s, Se3(Eigen::Matrix3d::Identity(), position)});
    }
    EXPECT_TRUE(write_trajectory_tum(path(name), trajectory).ok());
    return path(name);
  }
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(std::ifstream(path("out.json"))); }

 private:
  std::string folder_;
};

TEST_F(EvalCommandsTest, HelpAndUsage) {
  EXPECT_EQ(run({"--help"}).exit_code, 0);
  EXPECT_EQ(run({"--version"}).exit_code, 0);
  for (const char* command : {"eval-trajectory", "eval-loops", "eval-surface"}) {
    const Outcome help = run({command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.out, HasSubstr("--json"));
    EXPECT_EQ(run({command}).exit_code, 2);
  }
  EXPECT_EQ(run({}).exit_code, 2);
  EXPECT_EQ(run({"fly"}).exit_code, 2);
}

TEST_F(EvalCommandsTest, TrajectoryWritesItsKeys) {
  const std::string gt = write_walk("gt.txt", 100);
  EXPECT_EQ(run({"eval-trajectory", "--gt", gt, "--est", gt, "--json", path("out.json")}).exit_code, 0);
  const auto figures = json();
  EXPECT_EQ(figures.size(), 6U);
  EXPECT_NEAR(figures.at("ate_rmse_m"), 0, 1e-8);
  EXPECT_NEAR(figures.at("ate_mean_m"), 0, 1e-8);
  EXPECT_NEAR(figures.at("ate_max_m"), 0, 1e-8);
  EXPECT_NEAR(figures.at("rpe_trans_rmse_m"), 0, 1e-8);
  EXPECT_NEAR(figures.at("rpe_rot_rmse_deg"), 0, 1e-5);
  EXPECT_EQ(figures.at("pairs"), 41);
}

TEST_F(EvalCommandsTest, TrajectoryUnderASecondHasNoRelativeError) {
  const std::string gt = write_walk("gt.txt", 100, 8);
  const Outcome outcome = run({"eval-trajectory", "--gt", gt, "--est", gt, "--json", path("out.json")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(json().at("rpe_trans_rmse_m").is_null());
}

TEST_F(EvalCommandsTest, TrajectoryBadInput) {
  const std::string gt = write_walk("gt.txt", 100);
  const Outcome missing = run({"eval-trajectory", "--gt", gt, "--est", path("none.txt")});
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("loopsift-tool: "));
  EXPECT_THAT(missing.err, HasSubstr("none.txt"));
  const Outcome apart = run({"eval-trajectory", "--gt", gt, "--est", write_walk("late.txt", 900)});
  EXPECT_EQ(apart.exit_code, 2);
  EXPECT_THAT(apart.err, HasSubstr("no time in common"));
  const Outcome few = run({"eval-trajectory", "--gt", gt, "--est", write_walk("short.txt", 100, 2)});
  EXPECT_EQ(few.exit_code, 2);
  EXPECT_THAT(few.err, HasSubstr("only 2 poses"));
}

TEST_F(EvalCommandsTest, AJsonFileThatCannotBeWrittenIsAnError) {
  const std::string gt = write_walk("gt.txt", 100);
  const Outcome outcome =
      run({"eval-trajectory", "--gt", gt, "--est", gt, "--json", path("no/such/out.json")});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("no/such/out.json"));
}

TEST_F(EvalCommandsTest, LoopsWritesItsKeysAndRefusesAnotherFragmentCount) {
  const std::vector<LogRecord> gt = {{0, 2, 6, Se3()}, {1, 5, 6, Se3()}};
  ASSERT_TRUE(write_log(path("gt.log"), gt).ok());
  ASSERT_TRUE(
      write_info(path("gt.info"), {{0, 2, 6, Matrix6d::Identity()}, {1, 5, 6, Matrix6d::Identity()}}).ok());
  ASSERT_TRUE(write_log(path("loops.log"), {gt[0]}).ok());
  const std::vector<std::string> command = {"eval-loops",    "--gt",   path("gt.log"),   "--gt-info",
                                            path("gt.info"), "--json", path("out.json"), "--loops"};
  const auto with = [&](const std::string& loops) {
    std::vector<std::string> arguments = command;
    arguments.push_back(loops);
    return arguments;
  };
  EXPECT_EQ(run(with(path("loops.log"))).exit_code, 0);
  EXPECT_EQ(
      json(),
      (nlohmann::json{{"recall", 0.5}, {"precision", 1.0}, {"true_loops", 2}, {"loops", 1}, {"correct", 1}}));

  ASSERT_TRUE(write_log(path("other.log"), {{0, 2, 9, Se3()}}).ok());
  const Outcome other = run(with(path("other.log")));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.err, HasSubstr("9 fragments"));
}

TEST_F(EvalCommandsTest, LoopsShowsPrecisionAlongTheRanking) {
  const std::vector<LogRecord> gt = {{0, 2, 6, Se3()}, {1, 5, 6, Se3()}};
  const Se3 off(Eigen::Matrix3d::Identity(), {3, 0, 0});
  ASSERT_TRUE(write_log(path("gt.log"), gt).ok());
  ASSERT_TRUE(
      write_info(path("gt.info"), {{0, 2, 6, Matrix6d::Identity()}, {1, 5, 6, Matrix6d::Identity()}}).ok());
  ASSERT_TRUE(write_log(path("proposals.log"), {gt[0], {1, 5, 6, off}}).ok());
  const std::string header =
      "id,fragment_i,fragment_j,single_dmp,rank,tested_dmp,best_dmp_before,decision,reason,f\n";
  const std::string csv =
      write("loops.csv", header + "0,0,2,1,1,1,1,accepted,x,1\n1,1,5,1,0,1,1,rejected,x,1\n");
  const std::vector<std::string> line = {"eval-loops",
                                         "--gt",
                                         path("gt.log"),
                                         "--gt-info",
                                         path("gt.info"),
                                         "--loops",
                                         path("proposals.log"),
                                         "--ranking",
                                         csv,
                                         "--json",
                                         path("out.json")};
  const Outcome outcome = run(line);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(json().at("curve").size(), 2U);
  EXPECT_EQ(json().at("curve")[0].at("correct"), false);
  EXPECT_EQ(json().at("curve")[1].at("precision"), 0.5);
  EXPECT_EQ(json().at("curve")[1].at("accepted"), true);
  EXPECT_EQ(json().at("average_precision"), 0.25);
  EXPECT_THAT(outcome.out, HasSubstr("accepted"));

  write("loops.csv", header + "5,0,2,1,1,1,1,accepted,x,1\n");
  EXPECT_EQ(run(line).exit_code, 2);
}

TEST_F(EvalCommandsTest, TrajectoryTakesKittiAndEurocAndSaysWhatIsWrong) {
  const std::string gt = write_walk("gt.txt", 0);
  std::string kitti, euroc = "#timestamp [ns],p,p,p,q,q,q,q\n";
  const auto walk = read_trajectory(gt);
  ASSERT_TRUE(walk.ok());
  for (const StampedPose& pose : walk->poses) {
    const Eigen::Vector3d& t = pose.T_world_camera.translation();
    const auto text = [](double v) { return std::to_string(v); };
    kitti += "1 0 0 " + text(t.x()) + " 0 1 0 " + text(t.y()) + " 0 0 1 0\n";
    euroc += std::to_string(std::llround(pose.time_s * 1e9)) + "," + text(t.x()) + "," + text(t.y()) +
             ",0,1,0,0,0\n";
  }
  const std::string as_kitti = write("kitti.txt", kitti), as_euroc = write("data.csv", euroc);
  for (const auto& line : {std::vector<std::string>{"--est", as_euroc}, {"--est", as_kitti, "--by-index"}}) {
    std::vector<std::string> all = {"eval-trajectory", "--gt", gt, "--json", path("out.json")};
    all.insert(all.end(), line.begin(), line.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NEAR(json().at("ate_rmse_m"), 0, 1e-6);
    EXPECT_EQ(json().at("pairs"), 41);
  }
  const Outcome wrong = run({"eval-trajectory", "--gt", gt, "--est", as_euroc, "--format", "kitti"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("12 numbers"));
  EXPECT_THAT(run({"eval-trajectory", "--gt", gt, "--est", gt, "--format", "bag"}).err,
              HasSubstr("known are tum"));
  const Outcome two = run({"eval-trajectory", "--gt", gt, "--est", write_walk("two.txt", 0, 2)});
  EXPECT_EQ(two.exit_code, 2);
  EXPECT_THAT(two.err, HasSubstr("only 2 poses in common"));
  const Outcome late = run({"eval-trajectory", "--gt", gt, "--est", write_walk("late.txt", 500)});
  EXPECT_EQ(late.exit_code, 2);
  EXPECT_THAT(late.err, HasSubstr("no time in common"));
}

TEST_F(EvalCommandsTest, SurfaceAlignsTheTrajectoriesFirst) {
  // A floor at z = 0 in the true world; the estimate's world is the true one moved by (5, 6, 7).
  const std::string mesh = write("floor.obj", "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3\nf 1 3 4\n");
  const std::string gt = write_walk("gt.txt", 100);
  auto est = read_trajectory(gt);
  ASSERT_TRUE(est.ok());
  for (StampedPose& pose : est->poses)
    pose.T_world_camera = Se3(Eigen::Matrix3d::Identity(), {5, 6, 7}) * pose.T_world_camera;
  ASSERT_TRUE(write_trajectory_tum(path("est.txt"), *est).ok());
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n";
  const std::string map = write("map.ply", header + "5 6 7.5\n6 7 6.9\n");
  const Outcome outcome = run({"eval-surface", "--gt-mesh", mesh, "--map", map, "--trajectory",
                               path("est.txt"), "--gt-trajectory", gt, "--json", path("out.json")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(json().at("mean_m"), 0.3, 1e-5);
  EXPECT_NEAR(json().at("median_m"), 0.1, 1e-5);
  EXPECT_NEAR(json().at("p95_m"), 0.5, 1e-5);
  EXPECT_EQ(json().at("points"), 2);

  EXPECT_LT(json().at("completeness"), 0.01) << "two points on 324 square metres";
  EXPECT_EQ(json().at("completeness_within_m"), 0.05);

  const std::string empty =
      write("empty.ply", std::string(header).replace(header.find("vertex 2"), 8, "vertex 0"));
  const Outcome none =
      run({"eval-surface", "--gt-mesh", mesh, "--map", empty, "--trajectory", gt, "--gt-trajectory", gt});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("map is empty"));
}

}  // namespace
}  // namespace loopsift::tool
