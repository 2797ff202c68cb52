// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/posegraph/pose_graph.hpp"
#include "tests/support/random_graph.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;

constexpr const char* kInformation = " 100 0 0 0 0 0 100 0 0 0 0 100 0 0 0 400 0 0 400 0 400";

class G2o : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() /
        ("loopsift_g2o_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& text) {
    const std::string path = (folder_ / "graph.g2o").string();
    std::ofstream(path) << text;
    return path;
  }
  std::string error_of(const std::string& text) {
    const Expected<PoseGraph> graph = read_g2o(write(text));
    EXPECT_FALSE(graph.ok());
    return graph.ok() ? "" : graph.error().message;
  }
  std::filesystem::path folder_;
};

TEST_F(G2o, ComesBackAsItWasWritten) {
  test::RandomGraph world(test::RandomGraphOptions{});
  PoseGraph& graph = world.graph;
  append_frame_loops(graph, world.true_loop(1, 9), &graph.loops);
  for (Node& node : graph.nodes) node.timestamp_ns += 1'305'031'102'175'304'001;  // to the nanosecond
  const std::string path = (folder_ / "out.g2o").string();
  const Status written = write_g2o(path, graph);
  ASSERT_TRUE(written.ok());
  const Expected<PoseGraph> read = read_g2o(path);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->nodes.size(), graph.nodes.size());
  ASSERT_EQ(read->odometry.size(), graph.odometry.size());
  ASSERT_EQ(read->loops.size(), graph.loops.size());
  EXPECT_EQ(read->fragment_count(), static_cast<int>(graph.nodes.size()));
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    EXPECT_LT((read->T_map_node[n].matrix() - graph.T_map_node[n].matrix()).norm(), 1e-9);
    EXPECT_EQ(read->nodes[n].timestamp_ns, graph.nodes[n].timestamp_ns);
  }
  for (std::size_t k = 0; k < graph.loops.size(); ++k) {
    EXPECT_EQ(read->loops[k].a, graph.loops[k].a);
    EXPECT_EQ(read->loops[k].b, graph.loops[k].b);
    EXPECT_LT((read->loops[k].T_a_b.matrix() - graph.loops[k].T_a_b.matrix()).norm(), 1e-9);
    EXPECT_LT((read->loops[k].information - graph.loops[k].information).norm(),
              1e-9 * graph.loops[k].information.norm());
  }
}

// g2o weighs q_xyz, about half the angle: 400 there is 100 per square radian.
TEST_F(G2o, ConvertsTheRotationsWeight) {
  const Expected<PoseGraph> graph = read_g2o(
      write(std::string(
                "# two vertices\nVERTEX_SE3:QUAT 5 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 7 1 0 0 0 0 0 1\nFIX 5\n\n"
                "EDGE_SE3:QUAT 5 7 1 0 0 0 0 0 1") +
            kInformation + "\n"));
  ASSERT_TRUE(graph.ok()) << graph.error().message;
  ASSERT_EQ(graph->odometry.size(), 1u);  // neighbours in order of id, though the ids have a gap
  EXPECT_EQ(graph->odometry[0].a, 0);
  EXPECT_EQ(graph->odometry[0].b, 1);
  EXPECT_LT((graph->odometry[0].information - 100.0 * Matrix6d::Identity()).norm(), 1e-9);
}

TEST_F(G2o, NamesTheLineThatIsMalformed) {
  const std::string vertices = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n";
  const std::string edge = "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1";
  EXPECT_THAT(error_of("VERTEX_SE3:QUAT 0 0 0 0 0 0 0\n"), HasSubstr("graph.g2o, line 1: expected"));
  EXPECT_THAT(error_of("VERTEX_SE3:QUAT 0 nan 0 0 0 0 0 1\n"), HasSubstr("line 1"));
  EXPECT_THAT(error_of("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n"), HasSubstr("unit quaternion"));
  EXPECT_THAT(error_of(vertices + "VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"), HasSubstr("line 3: vertex 1"));
  EXPECT_THAT(error_of("VERTEX_SE2 0 0 0 0\n"), HasSubstr("VERTEX_SE2"));
  EXPECT_THAT(error_of(vertices + edge + " 1 0 0\n"), HasSubstr("line 3: expected the 21"));
  EXPECT_THAT(error_of(vertices + edge + kInformation + " 7\n"), HasSubstr("line 3"));
  EXPECT_THAT(error_of(vertices + edge + " -1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"),
              HasSubstr("positive semi-definite"));
  EXPECT_THAT(error_of(vertices + "EDGE_SE3:QUAT 0 2 1 0 0 0 0 0 1" + kInformation + "\n"),
              HasSubstr("line 3: the edge names vertex 2"));
  EXPECT_THAT(error_of("\n"), HasSubstr("no VERTEX_SE3:QUAT"));
}

TEST_F(G2o, NamesTheLineOfTheTimesThatIsMalformed) {
  const std::string path = write("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n");
  std::ofstream(path + ".times") << "0 1.5\n3 2.5\n";
  const Expected<PoseGraph> graph = read_g2o(path);
  ASSERT_FALSE(graph.ok());
  EXPECT_THAT(graph.error().message, HasSubstr("graph.g2o.times:2"));
}

TEST_F(G2o, NamesTheFileThatIsNotThere) {
  const Expected<PoseGraph> graph = read_g2o((folder_ / "missing.g2o").string());
  ASSERT_FALSE(graph.ok());
  EXPECT_EQ(graph.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(graph.error().message, HasSubstr("missing.g2o"));
  const Status written = write_g2o((folder_ / "no" / "such" / "folder.g2o").string(), PoseGraph{});
  EXPECT_FALSE(written.ok());
}

}  // namespace
}  // namespace loopsift
