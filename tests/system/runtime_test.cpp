// SPDX-License-Identifier: MIT
// The whole program as a member of a running robot: no heap calls, each pool at its end, a service manager, a
// stop in the middle of its work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/support/program.hpp"

namespace loopsift {
namespace {

using test::Outcome;
using ::testing::HasSubstr;

constexpr const char* kScene = "synth:room?width=160&height=120&frames=150";
constexpr int kFrames = 150;

class Runtime : public ::testing::Test {
 protected:
  /// With poses from a file, so that no exhausted pool can be told from lost tracking; six pieces of the map.
  [[nodiscard]] std::vector<std::string> command(const std::vector<std::string>& settings) const {
    std::vector<std::string> all = {LOOPSIFT_PROGRAM, "--source",     kScene, "--rate", "max",
                                    "--out",          folder_ / "out"};
    std::vector<std::string> assignments = {"lcm.enabled=false", "memory.cap_mib=1000",
                                            "fragment.frames_per_fragment=25", "frame.reduction=2",
                                            "run.odometry=file:" + (folder_ / "truth/groundtruth.txt")};
    assignments.insert(assignments.end(), settings.begin(), settings.end());
    for (const std::string& assignment : assignments) {
      all.emplace_back("--set");
      all.push_back(assignment);
    }
    return all;
  }
  void make_truth() const {
    const Outcome made = test::run_program(
        {LOOPSIFT_TOOL, "synth", std::string(kScene).substr(6), "--no-images", "--out", folder_ / "truth"});
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }
  [[nodiscard]] nlohmann::json figures_of(const std::vector<std::string>& settings) const {
    make_truth();
    const Outcome ran = test::run_program(command(settings));
    EXPECT_EQ(ran.exit_code, 0) << ran.output;
    const nlohmann::json figures = nlohmann::json::parse(test::read_file(folder_ / "out/run.json"));
    EXPECT_EQ(figures["frames"]["tracked"], kFrames) << "poses must go on whatever is full";
    return figures;
  }
  /// At its end, with something refused, and never past it.
  static void expect_full(const nlohmann::json& figures, const std::string& pool) {
    EXPECT_LE(figures["pools"][pool]["high_water"], figures["pools"][pool]["capacity"]) << pool;
    EXPECT_GT(figures["pools"][pool]["refused"], 0) << pool;
  }
  test::TemporaryFolder folder_;
};

TEST_F(Runtime, RealTimeThreadsMakeNoHeapCall) {
  const nlohmann::json figures = figures_of({});
  const nlohmann::json& calls = figures["memory"]["heap_calls_after_seal"];
  if (calls["front"].is_null()) GTEST_SKIP() << "this build does not count heap calls";
  EXPECT_EQ(calls["capture"], 0);
  EXPECT_EQ(calls["front"], 0);
  EXPECT_EQ(figures["memory"]["fence_refusals"], 0);
  EXPECT_GT(figures["memory"]["fence_peak_bytes"], 0);
  EXPECT_LE(figures["memory"]["peak_rss_bytes"], figures["memory"]["budget_bytes"]);
}

TEST_F(Runtime, FullOfFragmentsNoFurtherOneIsKept) {
  const nlohmann::json figures = figures_of({"store.max_fragments=2"});
  expect_full(figures, "store/fragments");
  EXPECT_EQ(figures["pools"]["store/fragments"]["high_water"], 2);
}

TEST_F(Runtime, FullOfSurfelsNoFurtherFragmentIsKept) {
  const nlohmann::json figures = figures_of({"store.max_surfels=3000"});
  expect_full(figures, "store/fragments");
  EXPECT_LE(figures["pools"]["store/surfels"]["high_water"], 3000);
}

TEST_F(Runtime, FullOfPosesTheWrittenTrajectoryEndsThere) {
  const nlohmann::json figures = figures_of({"store.max_frames=60"});
  expect_full(figures, "pipeline/poses");
  expect_full(figures, "store/fragments");
  const std::string written = test::read_file(folder_ / "out/trajectory.txt");
  EXPECT_EQ(std::count(written.begin(), written.end(), '\n'), 60);
}

TEST_F(Runtime, FullOfActiveSurfelsNewOnesAreLeftOut) {
  expect_full(figures_of({"fragment.active_capacity=1000"}), "fragment/active surfels");
}

TEST_F(Runtime, WithTooLittleHeapRegistrationsAreRefused) {
  const nlohmann::json figures = figures_of({"memory.back_heap_mib=4"});
  if (figures["memory"]["fence_refusals"].is_null()) GTEST_SKIP() << "this build does not count heap calls";
  EXPECT_GT(figures["memory"]["fence_refusals"], 0);
  EXPECT_LE(figures["memory"]["fence_peak_bytes"], 4 << 20);
  EXPECT_EQ(figures["pools"]["store/fragments"]["high_water"], 6);
}

TEST_F(Runtime, AStopInTheMiddleLeavesItsResults) {
  make_truth();
  std::vector<std::string> endless = command({"run.log_level=info", "watchdog.stop_s=60"});
  endless[2] = "synth:room?width=160&height=120&laps=100";
  test::Program program(endless);
  ASSERT_TRUE(program.wait_for(" frames, ", 120)) << program.output();
  program.signal(SIGTERM);
  EXPECT_EQ(program.wait(), 0) << program.output();
  EXPECT_FALSE(test::read_file(folder_ / "out/trajectory.txt").empty());
  EXPECT_FALSE(test::read_file(folder_ / "out/map.ply").empty());
  EXPECT_TRUE(nlohmann::json::parse(test::read_file(folder_ / "out/run.json")).contains("wall_s"));
}

TEST_F(Runtime, AServiceManagerIsToldOfReadyAndStopping) {
  make_truth();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = folder_ / "notify";
  std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
  const int listener = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  const Outcome ran = test::run_program(command({}));
  unsetenv("NOTIFY_SOCKET");
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
  std::string told;
  char text[256];
  for (ssize_t size = 0; (size = recv(listener, text, sizeof(text), 0)) > 0;)
    told.append(text, static_cast<std::size_t>(size)).append("\n");
  close(listener);
  EXPECT_THAT(told, HasSubstr("READY=1\n"));
  EXPECT_THAT(told, HasSubstr("STOPPING=1\nEXTEND_TIMEOUT_USEC="));
}

}  // namespace
}  // namespace loopsift
