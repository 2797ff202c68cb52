// SPDX-License-Identifier: MIT
// A camera is unplugged ten times in one run of the onboard program.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "core/base/steady_time.hpp"
#include "core/geometry/trajectory.hpp"
#include "tests/system/openni2_runs.hpp"

namespace loopsift::test {
namespace {

constexpr std::size_t kUnplugs = 10;
constexpr double kLimit_s = 60;
constexpr auto kSomeFrames = std::chrono::milliseconds(400);  // how many does not matter

class OpenNi2Unplugged : public OpenNi2Runs {
 protected:
  /// A few frames there and back: however many the program misses, the next one is near the last.
  void make_short_way() {
    constexpr int kFrames = 6, kBack = 2 * kFrames - 1;
    make_sequence(kFrames);
    std::ofstream list(sequence() + "/associations.txt");
    for (int k = 0; k < kBack; ++k) {
      const int frame = std::min(k, kBack - 1 - k);
      char line[128];
      std::snprintf(line, sizeof line, "%.2f depth/%06d.png %.2f rgb/%06d.jpg\n", 0.04 * k, frame, 0.04 * k,
                    frame);
      list << line;
    }
    list.close();
    load_film(kBack);
  }
  void plug(bool in) {
    camera_.control.plugged = in;
    camera_.apply();
  }
  /// Until the program has said it so many times.
  [[nodiscard]] static bool heard(const Program& program, const char* text, std::size_t times) {
    const std::int64_t limit_ns = steady_now_ns() + static_cast<std::int64_t>(kLimit_s * 1e9);
    while (steady_now_ns() < limit_ns) {
      if (count(program.output(), text) >= times) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  /// From the plug to the first frame with a pose, whose time is when it came.
  void tell_returns(const std::vector<double>& plugged_s) const {
    const auto trajectory = read_trajectory(camera_.folder() / "out/trajectory_odometry.txt");
    ASSERT_TRUE(trajectory.ok());
    std::vector<double> after_s;
    for (const double plugged : plugged_s) {
      const auto first = std::find_if(trajectory->poses.begin(), trajectory->poses.end(),
                                      [&](const StampedPose& pose) { return pose.time_s > plugged; });
      ASSERT_NE(first, trajectory->poses.end()) << "nothing was mapped after a return";
      after_s.push_back(first->time_s - plugged);
    }
    std::sort(after_s.begin(), after_s.end());
    std::printf("first frame after the plug is in again: %.3f s at best, %.3f s median, %.3f s at most\n",
                after_s.front(), after_s[after_s.size() / 2], after_s.back());
  }
};

TEST_F(OpenNi2Unplugged, TenTimesItGoesOnInANewPiece) {
  make_short_way();
  camera_.control.repeat = true;
  camera_.apply();
  Program program(
      command("openni2:", "out", {"source.retry_limit=-1", "source.retry_max_ms=200", "run.log_level=info"}));
  ASSERT_TRUE(program.wait_for(" frames, ", kLimit_s)) << program.output();
  std::vector<double> plugged_s;
  for (std::size_t k = 1; k <= kUnplugs; ++k) {
    std::this_thread::sleep_for(kSomeFrames);
    plug(false);
    ASSERT_TRUE(heard(program, "the source was lost: the device was unplugged", k)) << program.output();
    plugged_s.push_back(1e-9 * static_cast<double>(steady_now_ns()));
    plug(true);
    ASSERT_TRUE(heard(program, "starts a new piece of the map", k)) << program.output();
  }
  std::this_thread::sleep_for(kSomeFrames);
  program.signal(SIGINT);
  EXPECT_EQ(program.wait(), 0) << program.output();

  EXPECT_EQ(count(program.output(), "the source is open again"), kUnplugs);
  EXPECT_EQ(count(program.output(), "starts a new piece of the map"), kUnplugs);
  const nlohmann::json figures = report("out");
  EXPECT_EQ(figures["frames"]["lost"], 0);
  EXPECT_EQ(count(result("out", "trajectory.txt"), "\n"), figures["frames"]["tracked"]);
  // Each piece ends with a fragment of its own, and none was given up.
  EXPECT_GT(figures["pools"]["store/fragments"]["high_water"], kUnplugs);
  EXPECT_EQ(figures["pools"]["store/fragments"]["refused"], 0);
  tell_returns(plugged_s);
}

}  // namespace
}  // namespace loopsift::test
