// SPDX-License-Identifier: MIT
// `loopsift-tool convert`: what is written comes back the same through our own readers.
#include <gmock/gmock.h>

#include <filesystem>

#include "core/posegraph/pose_graph.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/unit/tools/desk_sequence.hpp"
#include "tools/evaluation/point_ply.hpp"
#include "tools/evaluation/trajectory_formats.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;

constexpr const char* kScene = "synth:notexture?width=64&height=48&frames=5&rate=10";

struct Frames {
  std::vector<std::int64_t> times_ns;
  std::vector<std::vector<double>> depth_m;  // of every frame
  std::size_t colored = 0;
};

Frames read_all(const std::string& uri) {
  Frames frames;
  const SourceOptions as_it_is;
  const auto source = open_source(uri, as_it_is);
  EXPECT_TRUE(source.ok()) << (source.ok() ? "" : source.error().message);
  if (!source.ok()) return frames;
  test::FrameBuffers buffers((*source)->info());
  while ((*source)->read(buffers.frame, 1000) == ReadStatus::kFrame) {
    frames.times_ns.push_back(buffers.frame.timestamp_ns);
    frames.depth_m.emplace_back();
    for (int y = 0; y < buffers.frame.depth.height; ++y)
      for (int x = 0; x < buffers.frame.depth.width; ++x)
        frames.depth_m.back().push_back(buffers.frame.depth(x, y) * (*source)->info().depth_unit_m);
    frames.colored += buffers.frame.color.empty() ? 0 : 1;
  }
  return frames;
}

class ConvertCommand : public ::testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }
  test::TemporaryFolder folder_;
};

TEST_F(ConvertCommand, EverySequenceFormatComesBackWithItsDepthColourAndCamera) {
  const Frames original = read_all(kScene);
  ASSERT_EQ(original.depth_m.size(), 5U);
  for (const std::string format : {"klg", "tum", "7scenes", "redwood", "sun3d"}) {
    const std::string to = format == "klg" ? path("klg/walk.klg") : path(format);
    const DeskOutcome outcome = run_desk({"convert", "sequence", kScene, to, "--to", format});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Frames copy = read_all("replay:" + format + ":" + to);
    ASSERT_EQ(copy.depth_m.size(), original.depth_m.size()) << format;
    EXPECT_EQ(copy.colored, 5U) << format;
    const double unit_m = format == "tum" ? 0.0002 : 0.001;
    for (std::size_t k = 0; k < copy.depth_m.size(); ++k)
      for (std::size_t p = 0; p < copy.depth_m[k].size(); ++p)
        ASSERT_NEAR(copy.depth_m[k][p], original.depth_m[k][p], 0.501 * unit_m)
            << format << " " << k << " " << p;
    const bool timed = format == "klg" || format == "tum" || format == "sun3d";
    for (std::size_t k = 0; timed && k < copy.times_ns.size(); ++k)
      EXPECT_NEAR(static_cast<double>(copy.times_ns[k]), static_cast<double>(original.times_ns[k]), 1000)
          << format;
    const SourceOptions as_it_is;
    const auto a = open_source(kScene, as_it_is), b = open_source("replay:" + format + ":" + to, as_it_is);
    EXPECT_FLOAT_EQ((*a)->info().camera.fx, (*b)->info().camera.fx) << format;
  }
}

TEST_F(ConvertCommand, SequencesThatCannotBeConvertedAreNamed) {
  const DeskOutcome oni = run_desk({"convert", "sequence", kScene, path("a.oni"), "--to", "oni"});
  EXPECT_EQ(oni.exit_code, 2);
  EXPECT_THAT(oni.err, HasSubstr("OpenNI2's recorder"));
  const DeskOutcome bag = run_desk({"convert", "sequence", kScene, path("a.bag"), "--to", "bag"});
  EXPECT_EQ(bag.exit_code, 2);
  EXPECT_THAT(bag.err, HasSubstr("known are klg, tum"));
  EXPECT_EQ(run_desk({"convert", "sequence", "replay:tum:/no/such", path("x"), "--to", "klg"}).exit_code, 3);
  EXPECT_EQ(run_desk({"convert", "sequence", kScene, "/proc/no/x.klg", "--to", "klg"}).exit_code, 1);
  EXPECT_EQ(run_desk({"convert"}).exit_code, 2);
}

TEST_F(ConvertCommand, ATrajectoryGoesRoundAllFormats) {
  Trajectory walk;
  for (int k = 0; k < 5; ++k) walk.poses.push_back({0.1 * k, Se3(so3_exp({0, 0.1 * k, 0}), {0.3 * k, 0, 1})});
  std::string from = path("0");
  ASSERT_TRUE(write_trajectory_tum(from, walk).ok());
  for (const std::string format : {"euroc", "kitti", "redwood", "tum"}) {
    const std::string to = path(format);
    const DeskOutcome outcome =
        run_desk({"convert", "trajectory", from, to, "--to", format, "--rate-hz", "10", "--json", path("j")});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    from = to;
  }
  const auto back = read_any_trajectory(from);
  ASSERT_TRUE(back.ok());
  ASSERT_EQ(back->poses.size(), 5U);
  EXPECT_NEAR(back->poses[4].time_s, 0.4, 1e-6);
  EXPECT_LT((back->poses[4].T_world_camera.inverse() * walk.poses[4].T_world_camera).log().norm(), 1e-6);
  EXPECT_EQ(run_desk({"convert", "trajectory", from, path("x"), "--to", "bag"}).exit_code, 2);
}

TEST_F(ConvertCommand, AGraphGoesToRedwoodAndBack) {
  folder_.write(
      "a.g2o",
      "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\nVERTEX_SE3:QUAT 2 2 0 0 0 0 0 1\n"
      "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 4 0 0 0 0 0 4 0 0 0 0 4 0 0 0 9 0 0 9 0 9\n"
      "EDGE_SE3:QUAT 0 2 2 0.1 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n");
  ASSERT_EQ(run_desk({"convert", "graph", path("a.g2o"), path("b")}).exit_code, 0);
  const DeskOutcome outcome = run_desk({"convert", "graph", path("b.poses.log"), path("c.g2o"), "--edges",
                                        path("b.log"), "--info", path("b.info")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto a = read_g2o(path("a.g2o")), c = read_g2o(path("c.g2o"));
  ASSERT_TRUE(a.ok() && c.ok());
  ASSERT_EQ(c->nodes.size(), 3U);
  ASSERT_EQ(c->odometry.size(), 1U);
  ASSERT_EQ(c->loops.size(), 1U);
  EXPECT_LT((c->odometry[0].information - a->odometry[0].information).norm(), 1e-6);
  EXPECT_LT((c->loops[0].T_a_b.inverse() * a->loops[0].T_a_b).log().norm(), 1e-6);

  EXPECT_THAT(run_desk({"convert", "graph", path("b.poses.log"), path("d.g2o")}).err, HasSubstr("--edges"));
  folder_.write("far.log", "0 7 9\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  EXPECT_THAT(
      run_desk({"convert", "graph", path("b.poses.log"), path("d.g2o"), "--edges", path("far.log")}).err,
      HasSubstr("there are 3 poses"));
}

TEST_F(ConvertCommand, AMapLosesItsNormalsAndKeepsTheRest) {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\ncomment fragment 0 surfels 2 first_frame_s 1.5\nelement vertex "
      "2\n"
      "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
      "property float nz\nproperty uchar red\nend_header\n";
  for (const float base : {1.0F, 2.0F}) {
    const float values[6] = {base, base + 0.5F, -3, 0, 0, 1};
    ply.append(reinterpret_cast<const char*>(values), sizeof values);
    ply += static_cast<char>(200);
  }
  const std::string from = folder_.write("map.ply", ply);
  ASSERT_EQ(run_desk({"convert", "map", from, path("thin.ply"), "--no-normals"}).exit_code, 0);
  EXPECT_EQ(std::filesystem::file_size(path("thin.ply")), ply.size() - 2 * 12 - 3 * 18);
  ASSERT_EQ(run_desk({"convert", "map", from, path("text.ply"), "--ascii"}).exit_code, 0);
  for (const char* name : {"thin.ply", "text.ply"}) {
    const auto points = read_ply_points(path(name));
    ASSERT_TRUE(points.ok()) << points.error().message;
    ASSERT_EQ(points->size(), 2U);
    EXPECT_EQ((*points)[1], Eigen::Vector3f(2, 2.5F, -3));
    const auto fragments = read_ply_fragments(path(name));
    ASSERT_TRUE(fragments.ok()) << fragments.error().message;
    ASSERT_EQ(fragments->size(), 1U);
    EXPECT_EQ(fragments->front().first_frame_s, 1.5);
  }
  std::ifstream text(path("text.ply"));
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(text), {}), HasSubstr("\n1 1.5 -3 0 0 1 200\n"));

  folder_.write("short.ply", ply.substr(0, ply.size() - 5));
  const DeskOutcome cut = run_desk({"convert", "map", path("short.ply"), path("x.ply")});
  EXPECT_EQ(cut.exit_code, 2);
  EXPECT_THAT(cut.err, HasSubstr("1 of the 2 vertices"));
  EXPECT_THAT(run_desk({"convert", "map", path("text.ply"), path("x.ply")}).err, HasSubstr("'ascii'"));
}

}  // namespace
}  // namespace loopsift::tool
