// SPDX-License-Identifier: MIT
// Whole runs of the onboard program on small rendered sequences: what it leaves behind.
// The sequence is a room walked round twice; its odometry is given, with drift, so that there are loops to
// find.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/geometry/trajectory.hpp"
#include "tests/support/program.hpp"
#include "tools/evaluation/trajectory_error.hpp"

namespace loopsift {
namespace {

using test::Outcome;
using test::read_file;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kScene = "room?width=160&height=120&color=0&rate=15";
constexpr std::size_t kFrames = 588;
constexpr std::array<const char*, 9> kFiles = {"trajectory.txt", "trajectory_odometry.txt", "map.ply",
                                               "loops.csv",      "proposals.log",           "proposals.info",
                                               "accepted.log",   "accepted.info",           "posegraph.g2o"};

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

Trajectory trajectory_of(const std::string& path) {
  const auto trajectory = read_trajectory(path);
  EXPECT_TRUE(trajectory.ok()) << trajectory.error().message;
  return trajectory.ok() ? *trajectory : Trajectory();
}

class Outputs : public ::testing::Test {
 protected:
  std::vector<std::string> command(const std::string& scene, const std::string& out,
                                   const std::vector<std::string>& more) const {
    std::vector<std::string> all = {
        LOOPSIFT_PROGRAM,    "--source", "synth:" + scene,       "--out", path(out), "--set",
        "lcm.enabled=false", "--set",    "memory.cap_mib=100000"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// Ground truth and drifting odometry of kScene.
  void make_truth() const {
    const Outcome made = test::run_program(
        {LOOPSIFT_TOOL, "synth", kScene, "--no-images", "--drift", "0.3", "--out", path("truth")});
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }
  [[nodiscard]] std::vector<std::string> drifting() const {
    return {"--rate", "max", "--odometry", "file:" + path("truth/odometry.txt")};
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() + "/" + name; }
  [[nodiscard]] std::string content(const std::string& name) const { return read_file(path(name)); }
  [[nodiscard]] nlohmann::json json(const std::string& out) const {
    return nlohmann::json::parse(content(out + "/run.json"));
  }
  [[nodiscard]] double ate_m(const std::string& name) const {
    const auto pairs = associate(trajectory_of(path("truth/groundtruth.txt")), trajectory_of(path(name)), {});
    EXPECT_TRUE(pairs.ok());
    return pairs.ok() ? trajectory_error(*pairs).ate_rmse_m : -1.0;
  }

  void expect_same_twice(const std::vector<std::string>& run_into_out) const {
    std::array<std::vector<std::string>, 2> contents;
    for (std::vector<std::string>& of_this_run : contents) {
      const Outcome ran = test::run_program(run_into_out);
      ASSERT_EQ(ran.exit_code, 0) << ran.output;
      for (const char* name : kFiles) of_this_run.push_back(content(std::string("out/") + name));
    }
    for (std::size_t k = 0; k < kFiles.size(); ++k)
      EXPECT_TRUE(contents[0][k] == contents[1][k]) << kFiles[k] << " differs between two equal runs";
  }

  test::TemporaryFolder folder_;
};

TEST_F(Outputs, ARunLeavesEveryFileAndTheyAgree) {
  make_truth();
  const Outcome ran = test::run_program(command(kScene, "out", drifting()));
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  for (const char* name : kFiles) EXPECT_FALSE(content(std::string("out/") + name).empty()) << name;

  const nlohmann::json figures = json("out");
  const auto accepted = figures["loops"]["accepted"].get<std::size_t>();
  const auto proposed = figures["loops"]["proposed"].get<std::size_t>();
  EXPECT_GT(accepted, 0U);
  EXPECT_EQ(figures["frames"]["tracked"], kFrames);
  EXPECT_EQ(lines(content("out/accepted.log")), accepted * 5);   // a header and a 4×4 matrix
  EXPECT_EQ(lines(content("out/accepted.info")), accepted * 7);  // a header and a 6×6 matrix
  EXPECT_EQ(lines(content("out/proposals.log")), proposed * 5);
  const std::string table = content("out/loops.csv");
  EXPECT_THAT(
      table, StartsWith("id,fragment_i,fragment_j,single_dmp,rank,tested_dmp,best_dmp_before,decision,reason,"
                        "frame_decided\n"));
  EXPECT_EQ(lines(table), proposed + 1);
  EXPECT_THAT(content("out/map.ply"), StartsWith("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(content("out/posegraph.g2o"), HasSubstr("VERTEX_SE3:QUAT 0 "));

  EXPECT_EQ(trajectory_of(path("out/trajectory_odometry.txt")).poses.size(), kFrames);
  EXPECT_EQ(trajectory_of(path("out/trajectory.txt")).poses.size(), kFrames);
  EXPECT_LT(ate_m("out/trajectory.txt"), 0.75 * ate_m("out/trajectory_odometry.txt"));
  EXPECT_LT(figures["dmp"]["final"], figures["dmp"]["odometry"]);
}

TEST_F(Outputs, RunJsonHoldsEveryPublishedKey) {
  const Outcome ran =
      test::run_program(command("room?width=160&height=120&color=0&frames=60", "out", {"--rate", "max"}));
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  const nlohmann::json figures = json("out");
  std::vector<std::string> keys = {"source", "sequence_duration_s", "wall_s", "pools"};
  const auto add = [&keys](const std::string& parent, const std::string& names) {
    std::istringstream words(names);
    for (std::string name; words >> name;) keys.push_back(parent + "/" + name);
  };
  add("frames", "received dropped tracked lost");
  for (const char* stage : {"odometry", "fusion", "frame", "capture_to_pose", "proposal", "loop_solve",
                            "loop_score", "loop_test", "correction"})
    add(std::string("latency_ms/") + stage, "p50 p99 max count quantiles");
  add("loops", "proposed scored tested accepted revoked dropped pending");
  add("dmp", "odometry final views");
  add("memory",
      "budget_bytes cap_bytes peak_rss_bytes camera_library_heap_calls fence_peak_bytes fence_refusals");
  add("memory/heap_calls_after_seal", "capture front publish");
  for (const std::string& key : keys)
    EXPECT_TRUE(figures.contains(nlohmann::json::json_pointer("/" + key))) << key;
  EXPECT_EQ(figures["frames"]["received"], 60);
  EXPECT_EQ(figures["latency_ms"]["frame"]["count"], 60);
  EXPECT_GT(figures["memory"]["peak_rss_bytes"], 0);
}

TEST_F(Outputs, TheSameInputGivesTheSameBytes) {
  make_truth();
  expect_same_twice(command(kScene, "out", drifting()));
  const std::string tracked = "room?width=320&height=240&frames=120";  // colour, built-in odometry
  expect_same_twice(command(tracked, "out", {"--rate", "max"}));
}

TEST_F(Outputs, AnInterruptedRunLeavesWhatItHas) {
  test::Program program(command("room?width=160&height=120&color=0&laps=100", "out",
                                {"--rate", "realtime", "--set", "watchdog.stop_s=60"}));
  ASSERT_TRUE(program.wait_for(" frames, ", 120)) << program.output();  // the first progress line
  program.signal(SIGINT);
  ASSERT_EQ(program.wait(), 0) << program.output();
  EXPECT_TRUE(json("out").contains("wall_s"));
  for (const char* name : kFiles) EXPECT_NO_THROW((void)content(std::string("out/") + name)) << name;
  EXPECT_GT(trajectory_of(path("out/trajectory.txt")).poses.size(), 0U);
}

}  // namespace
}  // namespace loopsift
