// SPDX-License-Identifier: MIT
// The back thread of the running program is stopped by force (ptrace), as if it hung: the others must not
// care.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tests/support/program.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;

constexpr double kLimit_s = 120;

/// Until done() holds; false when it does not within the limit.
template <class Condition>
bool wait_until(Condition done) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(kLimit_s);
  while (!done()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

/// A thread of a child process that runs no further.
class StoppedThread {
 public:
  ~StoppedThread() {
    if (stopped_) ptrace(PTRACE_DETACH, id_, nullptr, nullptr);
  }
  /// Waits for a thread of that name.
  bool find(pid_t program, const std::string& name) {
    return wait_until([&] {
      std::error_code gone;
      const std::string tasks = "/proc/" + std::to_string(program) + "/task";
      for (const auto& task : std::filesystem::directory_iterator(tasks, gone)) {
        std::string its_name;
        std::ifstream(task.path() / "comm") >> its_name;
        if (its_name == name) id_ = std::stoi(task.path().filename());
      }
      return id_ > 0;
    });
  }
  /// False where this is not allowed.
  bool stop() {
    if (ptrace(PTRACE_SEIZE, id_, nullptr, nullptr) != 0) return false;
    stopped_ = ptrace(PTRACE_INTERRUPT, id_, nullptr, nullptr) == 0 && waitpid(id_, nullptr, __WALL) == id_;
    return stopped_;
  }
  /// Waits until it ends with its process, which would wait for this.
  void wait_for_end() {
    int status = 0;
    while (waitpid(id_, &status, __WALL) == id_ && !WIFEXITED(status) && !WIFSIGNALED(status)) {
    }
    stopped_ = false;
  }

 private:
  pid_t id_ = 0;
  bool stopped_ = false;
};

/// The number before the last "/… frames" that the program told.
int frames_told(const std::string& output) {
  const std::size_t slash = output.rfind('/', output.rfind(" frames, "));
  if (slash == std::string::npos) return 0;
  const std::size_t space = output.rfind(' ', slash);
  return std::stoi(output.substr(space + 1, slash - space - 1));
}

TEST(HungThread, TheBackThreadIsGivenUpAndPosesGoOn) {
  const test::TemporaryFolder folder;
  test::Program program({LOOPSIFT_PROGRAM, "--source", "synth:room?width=160&height=120&color=0&laps=100",
                         "--rate", "max", "--out", folder / "out", "--set", "lcm.enabled=false", "--set",
                         "memory.cap_mib=1000", "--set", "fragment.frames_per_fragment=25", "--set",
                         "frame.reduction=1", "--set", "watchdog.back_hung_s=1", "--set",
                         "run.log_level=info"});
  StoppedThread back;
  ASSERT_TRUE(back.find(program.pid(), "back")) << program.output();
  if (!back.stop()) GTEST_SKIP() << "this user may not stop a thread of a child process (ptrace)";
  ASSERT_TRUE(program.wait_for("the back thread hangs", kLimit_s)) << program.output();
  const int frames = frames_told(program.output());
  EXPECT_TRUE(wait_until([&] { return frames_told(program.output()) > frames + 100; })) << program.output();
  program.signal(SIGTERM);
  back.wait_for_end();
  EXPECT_EQ(program.wait(), 0) << program.output();
  EXPECT_THAT(program.output(), HasSubstr("the results are the odometry's"));
  const nlohmann::json figures = nlohmann::json::parse(test::read_file(folder / "out/run.json"));
  EXPECT_GT(figures["frames"]["tracked"], frames + 100);
  EXPECT_LT(10 * figures["frames"]["lost"].get<int>(), figures["frames"]["tracked"].get<int>());
  const std::string poses = test::read_file(folder / "out/trajectory.txt");
  EXPECT_GT(std::count(poses.begin(), poses.end(), '\n'), frames + 100);
  EXPECT_FALSE(test::read_file(folder / "out/map.ply").empty());
}

}  // namespace
}  // namespace loopsift
