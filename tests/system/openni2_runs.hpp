// SPDX-License-Identifier: MIT
// Whole runs of the onboard program on a recorded sequence, and on the test camera that plays it.
//
// ctest runs each test in a process of its own. The whole program at once may crash or hang inside
// OpenNI2 2.2, which does not stand being opened many times in one process (drivers/openni2/session.hpp): run
// one test of it with --gtest_filter.
#pragma once
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "drivers/replay/replay_source.hpp"
#include "tests/support/openni2_plugin/test_camera.hpp"
#include "tests/support/program.hpp"

namespace loopsift::test {

class OpenNi2Runs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!TestCamera::install()) GTEST_SKIP() << TestCamera::kNotAllowed;
  }

  /// A walk through a room, its beginning, as OpenNI2 can hold it: millimetres, whole microseconds.
  void make_sequence(int frames) {
    const Outcome made = run_program({LOOPSIFT_TOOL, "synth", "room?width=160&height=120&rate=25", "--frames",
                                      std::to_string(frames), "--depth-scale", "1000", "--out", sequence()});
    ASSERT_EQ(made.exit_code, 0) << made.output;
  }
  /// Makes a film of the sequence and puts it into the camera.
  void load_film(int frames) {
    const auto recorded = open_replay("tum", sequence(), SourceOptions());
    ASSERT_TRUE(recorded.ok()) << recorded.error().message;
    recorded_ = (*recorded)->info();
    camera_.control.film = camera_.folder() / "film";
    ASSERT_EQ(write_film(**recorded, frames, camera_.control.film), frames);
    camera_.apply();
  }
  [[nodiscard]] std::string sequence() const { return camera_.folder() / "sequence"; }

  /// With the intrinsics of the sequence: the field of view would give them only nearly.
  [[nodiscard]] std::vector<std::string> command(const std::string& source, const std::string& out,
                                                 const std::vector<std::string>& settings) const {
    std::vector<std::string> all = {LOOPSIFT_PROGRAM, "--source", source, "--out", camera_.folder() / out};
    std::vector<std::string> assignments = {
        "lcm.enabled=false",
        "memory.cap_mib=100000",
        "fragment.frames_per_fragment=20",
        recorded_.camera.width < 320 ? "frame.reduction=1" : "frame.reduction=2",
        "camera.width=" + std::to_string(recorded_.camera.width),
        "camera.height=" + std::to_string(recorded_.camera.height),
        "camera.depth_scale=" + exact(1 / recorded_.depth_unit_m),
        "camera.fx=" + exact(recorded_.camera.fx),
        "camera.fy=" + exact(recorded_.camera.fy),
        "camera.cx=" + exact(recorded_.camera.cx),
        "camera.cy=" + exact(recorded_.camera.cy)};
    assignments.insert(assignments.end(), settings.begin(), settings.end());
    for (std::string& assignment : assignments) {
      all.emplace_back("--set");
      all.push_back(std::move(assignment));
    }
    return all;
  }
  [[nodiscard]] std::string result(const std::string& out, const std::string& file) const {
    return read_file(camera_.folder() / out + "/" + file);
  }
  [[nodiscard]] nlohmann::json report(const std::string& out) const {
    return nlohmann::json::parse(result(out, "run.json"));
  }
  [[nodiscard]] static std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
  }

  TestCamera camera_;
  SourceInfo recorded_;

 private:
  [[nodiscard]] static std::string exact(double value) {
    char text[64];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
  }
};

}  // namespace loopsift::test
