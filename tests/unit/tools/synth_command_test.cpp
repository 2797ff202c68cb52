// SPDX-License-Identifier: MIT
// `loopsift-tool synth` as a user calls it: what it writes can be replayed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/geometry/trajectory.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/synth/mesh_io.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;

/// The exit code; what went to stderr is in *complaint.
int run(const std::vector<std::string>& arguments, std::string* complaint) {
  std::vector<const char*> argv = {"loopsift-tool", "synth"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int exit_code = run_tool(static_cast<int>(argv.size()), argv.data());
  (void)testing::internal::GetCapturedStdout();
  *complaint = testing::internal::GetCapturedStderr();
  return exit_code;
}

class SynthCommand : public ::testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() + "/" + name; }
  test::TemporaryFolder folder_;
  std::string complaint_;
};

std::vector<std::uint16_t> all_depth(const std::string& uri) {
  std::vector<std::uint16_t> all;
  const SourceOptions as_it_is;
  const auto source = open_source(uri, as_it_is);
  EXPECT_TRUE(source.ok()) << source.error().message;
  if (!source.ok()) return all;
  const SourceInfo& info = (*source)->info();
  std::vector<std::uint16_t> depth(static_cast<std::size_t>(info.camera.width * info.camera.height));
  std::vector<Rgb8> color(static_cast<std::size_t>(info.color_width * info.color_height));
  RawFrame frame;
  frame.depth_buffer = depth;
  frame.color_buffer = color;
  while ((*source)->read(frame, 0) == ReadStatus::kFrame) all.insert(all.end(), depth.begin(), depth.end());
  return all;
}

TEST_F(SynthCommand, WrittenSequenceReplaysAsItWasRendered) {
  ASSERT_EQ(run({"room?width=160&height=120", "--frames", "5", "--depth-scale", "1000", "--drift", "0.2",
                 "--out", path("room"), "--json", path("room.json")},
                &complaint_),
            0)
      << complaint_;
  const auto written = all_depth("replay:tum:" + path("room"));
  EXPECT_EQ(written.size(), 5U * 160 * 120);
  EXPECT_EQ(written, all_depth("synth:room?width=160&height=120&frames=5"));

  const auto gt = read_trajectory(path("room/groundtruth.txt")),
             odometry = read_trajectory(path("room/odometry.txt"));
  ASSERT_TRUE(gt.ok() && odometry.ok());
  ASSERT_EQ(gt->poses.size(), 5U);
  EXPECT_NEAR(
      (gt->poses[4].T_world_camera.translation() - odometry->poses[4].T_world_camera.translation()).norm(),
      0.2, 1e-3);
  const auto mesh = read_mesh(path("room/mesh.ply"));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  const auto json = nlohmann::json::parse(std::ifstream(path("room.json")));
  EXPECT_EQ(json["frames"], 5);
  EXPECT_EQ(json["triangles"], mesh->triangles.size());
  EXPECT_GT(json["valid_fraction"], 0.6);
}

TEST_F(SynthCommand, DepthAloneWithoutColor) {
  ASSERT_EQ(
      run({"corridor?width=80&height=60", "--frames", "2", "--no-color", "--out", path("c")}, &complaint_), 0)
      << complaint_;
  EXPECT_FALSE(std::filesystem::exists(path("c/rgb.txt")));
  EXPECT_FALSE(std::filesystem::exists(path("c/odometry.txt")));
  EXPECT_EQ(all_depth("replay:tum:" + path("c")).size(), 2U * 80 * 60);
}

TEST_F(SynthCommand, TruthWithoutImages) {
  ASSERT_EQ(run({"room?width=80&height=60", "--frames", "7", "--drift", "0.1", "--no-images", "--out",
                 path("truth")},
                &complaint_),
            0)
      << complaint_;
  const auto gt = read_trajectory(path("truth/groundtruth.txt"));
  ASSERT_TRUE(gt.ok()) << gt.error().message;
  EXPECT_EQ(gt->poses.size(), 7U);
  EXPECT_TRUE(std::filesystem::exists(path("truth/mesh.ply")));
  EXPECT_TRUE(std::filesystem::exists(path("truth/odometry.txt")));
  EXPECT_FALSE(std::filesystem::exists(path("truth/depth")));
  EXPECT_FALSE(std::filesystem::exists(path("truth/associations.txt")));
}

TEST_F(SynthCommand, OtherPeoplesSceneWithOffset) {
  std::ofstream(path("wall.obj")) << "v -9 -9 3\nv 9 -9 3\nv 9 9 3\nv -9 9 3\nf 1 2 3 4\n";
  std::ofstream(path("still.txt")) << "7.0 0 0 0 0 0 0 1\n7.1 0 0 0 0 0 0 1\n";
  ASSERT_EQ(run({"--mesh", path("wall.obj"), "--trajectory", path("still.txt"), "--offset", "0", "0", "1",
                 "--no-noise", "--no-distortion", "--camera", "60", "60", "40", "30", "80", "60", "--out",
                 path("wall")},
                &complaint_),
            0)
      << complaint_;
  const auto depth = all_depth("replay:tum:" + path("wall"));
  ASSERT_EQ(depth.size(), 2U * 80 * 60);
  EXPECT_THAT(depth, ::testing::Each(10000));  // 2 m in TUM's fifths of a millimetre
}

TEST_F(SynthCommand, WrongInputIsNamed) {
  EXPECT_EQ(run({"kitchen", "--out", path("x")}, &complaint_), 2);
  EXPECT_THAT(complaint_, HasSubstr("lookalike"));
  EXPECT_EQ(run({"--out", path("x")}, &complaint_), 2);
  EXPECT_THAT(complaint_, HasSubstr("SCENE"));
  EXPECT_EQ(run({"room", "--camera", "0", "60", "40", "30", "80", "60", "--out", path("x")}, &complaint_), 2);
  EXPECT_THAT(complaint_, HasSubstr("--camera"));
  EXPECT_EQ(run({"--mesh", path("no.obj"), "--trajectory", path("no.txt"), "--out", path("x")}, &complaint_),
            2);
  EXPECT_THAT(complaint_, HasSubstr("no.obj"));
  std::ofstream(path("file")) << "in the way";
  EXPECT_EQ(run({"room", "--frames", "1", "--out", path("file")}, &complaint_), 1);
  EXPECT_THAT(complaint_, HasSubstr("file/depth"));
}

}  // namespace
}  // namespace loopsift::tool
