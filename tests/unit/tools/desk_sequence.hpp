// SPDX-License-Identifier: MIT
// A small rendered walk, twice round a room, with its true and a drifting trajectory and loops to sift, and
// the desk program as a user calls it.
#pragma once
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/proposal/loop.hpp"
#include "drivers/synth/odometry_drift.hpp"
#include "drivers/synth/synth_sequence.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {

struct DeskOutcome {
  int exit_code;
  std::string out, err;
};

inline DeskOutcome run_desk(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv = {"loopsift-tool"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit_code = run_tool(static_cast<int>(argv.size()), argv.data());
  std::string out = testing::internal::GetCapturedStdout();
  return {exit_code, std::move(out), testing::internal::GetCapturedStderr()};
}

/// Files in a temporary folder: gt.txt, drift.txt (TUM), loops.log and loops.info with loop 0 true and loop 1
/// wrong.
class DeskSequence : public ::testing::Test {
 protected:
  static constexpr const char* kScene = "room?width=160&height=120&rate=4&color=0";
  static constexpr const char* kSource = "synth:room?width=160&height=120&rate=4&color=0";
  static constexpr int kFragmentFrames = 10;
  static constexpr int kTrueI = 1, kTrueJ = 10;  // the same part of the room, a lap later

  void SetUp() override {
    const SourceOptions as_it_is;
    const auto sequence = make_synth_sequence(kScene, as_it_is);
    ASSERT_TRUE(sequence.ok()) << sequence.error().message;
    gt_ = sequence->trajectory;
    drift_ = drifting_odometry(gt_, 0.4, 3);
    ASSERT_TRUE(write_trajectory_tum(path("gt.txt"), gt_).ok());
    ASSERT_TRUE(write_trajectory_tum(path("drift.txt"), drift_).ok());
    const Se3 wrong(Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                    Eigen::Vector3d(0.4, 0.1, -0.4));
    write_loops_of({true_motion(kTrueI, kTrueJ), true_motion(kTrueI, kTrueJ) * wrong});
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }
  /// Between the first cameras of two fragments.
  [[nodiscard]] Se3 true_motion(int i, int j) const {
    const auto pose = [this](int fragment) {
      return gt_.poses[static_cast<std::size_t>(fragment * kFragmentFrames)].T_world_camera;
    };
    return pose(i).inverse() * pose(j);
  }
  void write_loops_of(const std::vector<Se3>& motions) const {
    std::vector<Loop> loops;
    for (const Se3& T : motions) {
      Loop loop;
      loop.id.value = static_cast<std::int32_t>(loops.size());
      loop.i.value = kTrueI;
      loop.j.value = kTrueJ;
      loop.T_i_j = T;
      loop.information = 2500.0 * Matrix6d::Identity();
      loops.push_back(loop);
    }
    ASSERT_TRUE(write_loops(path("loops"), loops, 16).ok());
  }
  /// The command line of sift and compare, without --out or --gt.
  [[nodiscard]] std::vector<std::string> sift_line(const std::string& command) const {
    return {command,
            "--source",
            kSource,
            "--trajectory",
            path("drift.txt"),
            "--loops",
            path("loops.log"),
            "--info",
            path("loops.info"),
            "--json",
            path("out.json"),
            "--fragment-frames",
            std::to_string(kFragmentFrames)};
  }
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(std::ifstream(path("out.json"))); }

  test::TemporaryFolder folder_;
  Trajectory gt_, drift_;
};

/// `line` with the value behind `option` replaced, or both added.
inline std::vector<std::string> with(std::vector<std::string> line, const std::string& option,
                                     const std::string& value) {
  const auto at = std::find(line.begin(), line.end(), option);
  if (at == line.end()) {
    line.insert(line.end(), {option, value});
  } else {
    *(at + 1) = value;
  }
  return line;
}

}  // namespace loopsift::tool
