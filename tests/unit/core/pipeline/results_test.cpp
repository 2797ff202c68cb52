// SPDX-License-Identifier: MIT
#include "core/pipeline/results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/core/pipeline/sifted_world.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;
using test::small_back_end;
using test::TemporaryFolder;
using test::view_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A run with an accepted loop, a rejected one, one that names no fragment, and one not walked yet.
class Results : public ::testing::Test {
 protected:
  Results() : back_end_(small_back_end(false)), frames_(test::frames_of(world_)) {
    for (const Fragment& fragment : world_.fragments()) (void)test::grow(&*back_end_, fragment);
    std::vector<Loop> loops = {world_.loop(0, 0, 6), world_.loop(1, 1, 5, Vector6d::Constant(0.4)),
                               world_.loop(2, 1, 6)};
    loops[2].j = FragmentId{9};
    back_end_->add_loops(view_of(loops));
    back_end_->finish();
    const Loop pending = world_.loop(3, 0, 5);
    back_end_->add_loops(Span<const Loop>(&pending, 1));
  }
  [[nodiscard]] Status write(const std::string& out) const {
    return write_results(out, *back_end_, view_of(frames_), view_of(world_.fragments()));
  }
  FragmentWorld world_;
  InArena<BackEnd> back_end_;
  std::vector<OdometryPose> frames_;
  TemporaryFolder folder_;
};

std::vector<std::vector<std::string>> read_csv(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

TEST_F(Results, TrajectoriesReadBack) {
  ASSERT_TRUE(write(folder_.path()).ok());
  const auto odometry = read_trajectory(folder_ / "trajectory_odometry.txt");
  const auto corrected = read_trajectory(folder_ / "trajectory.txt");
  ASSERT_TRUE(odometry.ok() && corrected.ok());
  ASSERT_EQ(odometry->poses.size(), frames_.size());
  ASSERT_EQ(corrected->poses.size(), frames_.size());
  double moved = 0;
  for (std::size_t k = 0; k < frames_.size(); ++k) {
    EXPECT_NEAR(odometry->poses[k].time_s, static_cast<double>(frames_[k].timestamp_ns) * 1e-9, 1e-8);
    EXPECT_LT((odometry->poses[k].T_world_camera.inverse() * frames_[k].T_odom_camera).log().norm(), 1e-6);
    moved = std::max(moved, (corrected->poses[k].T_world_camera.translation() -
                             odometry->poses[k].T_world_camera.translation())
                                .norm());
  }
  EXPECT_GT(moved, 0.03) << "the accepted loop corrects the trajectory";
}

TEST_F(Results, LoopsReadBack) {
  ASSERT_TRUE(write(folder_.path()).ok());
  const auto proposals = read_loops(folder_ / "proposals.log", folder_ / "proposals.info", 10);
  const auto accepted = read_loops(folder_ / "accepted.log", folder_ / "accepted.info", 7);
  ASSERT_TRUE(proposals.ok() && accepted.ok());
  EXPECT_EQ(proposals->size(), 4U);
  ASSERT_EQ(accepted->size(), 1U);
  const Loop expected = world_.loop(0, 0, 6);
  EXPECT_EQ((*accepted)[0].i, expected.i);
  EXPECT_EQ((*accepted)[0].j, expected.j);
  EXPECT_LT(((*accepted)[0].T_i_j.inverse() * expected.T_i_j).log().norm(), 1e-6);
  EXPECT_LT(((*accepted)[0].information - expected.information).norm(), 1e-5 * expected.information.norm());
}

TEST_F(Results, LoopsCsvHasARowPerLoop) {
  ASSERT_TRUE(write(folder_.path()).ok());
  const auto rows = read_csv(folder_ / "loops.csv");
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_THAT(rows[0], ElementsAre("id", "fragment_i", "fragment_j", "single_dmp", "rank", "tested_dmp",
                                   "best_dmp_before", "decision", "reason", "frame_decided"));
  for (const auto& row : rows) ASSERT_EQ(row.size(), 10U);
  const auto& accepted = rows[1];
  const SiftedLoop& record = back_end_->sifter().records()[0];
  EXPECT_THAT(std::vector<std::string>(accepted.begin(), accepted.begin() + 3), ElementsAre("0", "0", "6"));
  EXPECT_NEAR(std::stod(accepted[3]) / record.single_score, 1.0, 1e-8);
  EXPECT_EQ(accepted[4], "0");
  EXPECT_LT(std::stod(accepted[5]), std::stod(accepted[6]));
  EXPECT_THAT(std::vector<std::string>(accepted.begin() + 7, accepted.end()),
              ElementsAre("accepted", "improves the map", "27"));
  EXPECT_EQ(rows[2][7], "rejected");
  EXPECT_THAT(rows[3], ElementsAre("2", "1", "9", "", "-1", "", "", "rejected",
                                   "names a fragment that is not in the map", "27"));
  EXPECT_EQ(rows[4][5], "") << "a loop not tested has no score";
  EXPECT_EQ(rows[4][7], "pending");
  EXPECT_EQ(rows[4][8], "not tested");
}

TEST_F(Results, GraphReadsBack) {
  ASSERT_TRUE(write(folder_.path()).ok());
  const auto graph = read_g2o(folder_ / "posegraph.g2o");
  ASSERT_TRUE(graph.ok()) << graph.error().message;
  const PoseGraph expected = back_end_->sifter().graph();
  ASSERT_EQ(graph->T_map_node.size(), expected.T_map_node.size());
  EXPECT_EQ(graph->odometry.size() + graph->loops.size(), expected.odometry.size() + expected.loops.size());
  for (std::size_t n = 0; n < expected.T_map_node.size(); ++n)
    EXPECT_LT((graph->T_map_node[n].inverse() * expected.T_map_node[n]).log().norm(), 1e-6);
}

TEST_F(Results, MapHoldsEverySurfelWhereTheBestMapHasIt) {
  ASSERT_TRUE(write(folder_.path()).ok());
  std::ifstream file(folder_ / "map.ply", std::ios::binary);
  std::string line;
  std::size_t vertices = 0;
  while (std::getline(file, line) && line != "end_header")
    if (line.rfind("element vertex ", 0) == 0) vertices = std::stoul(line.substr(15));
  std::size_t expected = 0;
  for (const Fragment& fragment : world_.fragments()) expected += fragment.surfels.size();
  EXPECT_EQ(vertices, expected);
  float first[3] = {};
  file.read(reinterpret_cast<char*>(first), sizeof first);
  const SurfelSpan& s = world_.fragments()[0].surfels;
  const Eigen::Vector3d p =
      back_end_->T_map_fragment()[0] * Eigen::Vector3f(s.x[0], s.y[0], s.z[0]).cast<double>();
  EXPECT_LT((Eigen::Vector3f(first[0], first[1], first[2]).cast<double>() - p).norm(), 1e-5);
}

TEST_F(Results, AFolderThatIsNotThereIsNamed) {
  const Status status = write(folder_.path() + "/missing");
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
  EXPECT_THAT(status.error().message, HasSubstr("missing/trajectory_odometry.txt"));
}

TEST_F(Results, AFullDiskIsSaidAndTheRestIsWritten) {
  for (const char* name : {"trajectory_odometry.txt", "trajectory.txt", "proposals.log", "accepted.info",
                           "loops.csv", "posegraph.g2o", "map.ply"}) {
    const TemporaryFolder folder;
    std::filesystem::create_symlink("/dev/full", folder / name);
    const Status status = write(folder.path());
    ASSERT_FALSE(status.ok()) << name;
    EXPECT_EQ(status.error().code, ErrorCode::kIo);
    EXPECT_THAT(status.error().message, HasSubstr(name));
    const std::string other = std::string(name) == "loops.csv" ? "trajectory.txt" : "loops.csv";
    EXPECT_GT(std::filesystem::file_size(folder / other), 100U);
  }
}

TEST(ResultsOfNothing, AreWrittenAllTheSame) {
  const TemporaryFolder folder;
  const InArena<BackEnd> back_end(small_back_end(true));
  const Status status = write_results(folder.path(), *back_end, {}, {});
  EXPECT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(read_csv(folder / "loops.csv").size(), 1U);
  EXPECT_TRUE(std::filesystem::exists(folder / "map.ply"));
}

// Fragments past the scorer's capacity keep their place in the map, behind the last one that it holds.
TEST(ResultsOfAFullMap, HoldFragmentsThatSiftingLeftOut) {
  const FragmentWorld world;
  BackEndOptions options = small_back_end(false);
  options.posterior.max_fragments = 5;
  const InArena<BackEnd> back_end(options);
  for (const Fragment& fragment : world.fragments()) (void)test::grow(&*back_end, fragment);
  const TemporaryFolder folder;
  const std::vector<OdometryPose> frames = test::frames_of(world);
  const Status status = write_results(folder.path(), *back_end, view_of(frames), view_of(world.fragments()));
  ASSERT_TRUE(status.ok()) << status.error().message;
  const auto trajectory = read_trajectory(folder / "trajectory.txt");
  ASSERT_TRUE(trajectory.ok());
  EXPECT_EQ(trajectory->poses.size(), frames.size());
  std::size_t surfels = 0;
  for (const Fragment& fragment : world.fragments()) surfels += fragment.surfels.size();
  EXPECT_GT(std::filesystem::file_size(folder / "map.ply"), surfels * 35);
}

}  // namespace
}  // namespace loopsift
