// SPDX-License-Identifier: MIT
// Fragments of a recording with a given trajectory: numbers hold whatever is broken, gaps are bridged.
#include "tools/loopsift_tool/offline_map.hpp"

#include <gmock/gmock.h>

#include "tests/support/sequence_writer.hpp"
#include "tests/unit/tools/desk_sequence.hpp"

namespace loopsift::tool {
namespace {

using ::testing::HasSubstr;

class OfflineMapTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 25;
  void SetUp() override {
    ASSERT_EQ(run_desk({"synth", "room?width=80&height=60&rate=10", "--frames", std::to_string(kFrames),
                        "--no-color", "--out", folder_ / "room"})
                  .exit_code,
              0);
    auto gt = read_trajectory(folder_ / "room/groundtruth.txt");
    ASSERT_TRUE(gt.ok());
    for (int k = 0; k < kFrames; ++k)
      records_.push_back({k, k, k + 1, gt->poses[static_cast<std::size_t>(k)].T_world_camera});
  }
  /// Frames of 10 per fragment, with the records that are left as trajectory.
  Expected<std::unique_ptr<OfflineMap>> build() {
    EXPECT_TRUE(write_log(folder_ / "poses.log", records_).ok());
    const auto odometry = GivenOdometry::open(folder_ / "poses.log", info_path_);
    if (!odometry) return odometry.error();
    SourceOptions options;
    options.want_color = false;
    options.depth_scale = depth_scale_;
    auto source = open_source("replay:tum:" + (folder_ / "room"), options);
    EXPECT_TRUE(source.ok());
    OfflineMapOptions map;
    map.fragment_frames = 10;
    return OfflineMap::build(**source, *odometry, map);
  }
  void lose_poses(std::size_t first, std::size_t last) {
    records_.erase(records_.begin() + static_cast<std::ptrdiff_t>(first),
                   records_.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  }
  [[nodiscard]] std::string depth_file(std::size_t index) const {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "room/depth"))
      files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    return files[index];
  }

  test::TemporaryFolder folder_;
  std::vector<LogRecord> records_;
  std::string info_path_;
  double depth_scale_ = 0;  // as the recording says
};

TEST_F(OfflineMapTest, FullFragmentsAndALastShortOne) {
  const auto map = build();
  ASSERT_TRUE(map.ok()) << map.error().message;
  const Span<const Fragment> fragments = (*map)->fragments();
  ASSERT_EQ(fragments.size(), 3U);
  for (std::size_t f = 0; f < 3; ++f) {
    EXPECT_EQ(fragments[f].frames.size(), f < 2 ? 10U : 5U);
    EXPECT_EQ(fragments[f].frames[0].frame.value, static_cast<int>(10 * f));
    EXPECT_GT(fragments[f].surfels.size(), 100U);
    EXPECT_LT((fragments[f].T_odom_fragment.inverse() * records_[10 * f].T).log().norm(), 1e-9);
  }
  EXPECT_EQ((*map)->frames().size(), 25U);
  EXPECT_EQ((*map)->back_end(0).fragment_count(), 3);
  EXPECT_EQ((*map)->back_end(0).odometry_graph().odometry.size(), 5U);
}

TEST_F(OfflineMapTest, ABrokenFrameDoesNotShiftTheNumbers) {
  test::truncate_file(depth_file(10), 0.5);  // the first of fragment 1
  testing::internal::CaptureStderr();
  const auto map = build();
  const std::string told = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(map.ok()) << map.error().message;
  EXPECT_THAT(told, HasSubstr("frame skipped"));
  EXPECT_EQ((*map)->figures().frames.received, 25);
  EXPECT_EQ((*map)->figures().frames.dropped, 1);
  const Span<const Fragment> fragments = (*map)->fragments();
  ASSERT_EQ(fragments.size(), 3U);
  EXPECT_EQ(fragments[1].frames[0].frame.value, 11);
  EXPECT_EQ(fragments[1].frames.size(), 9U);
  EXPECT_LT((fragments[1].T_odom_fragment.inverse() * records_[11].T).log().norm(), 1e-9);
  EXPECT_EQ(fragments[2].frames[0].frame.value, 20);
}

TEST_F(OfflineMapTest, AGapInTheTrajectoryIsBridged) {
  lose_poses(7, 12);
  const auto map = build();
  ASSERT_TRUE(map.ok()) << map.error().message;
  const Span<const Fragment> fragments = (*map)->fragments();
  ASSERT_EQ(fragments.size(), 3U);
  EXPECT_EQ(fragments[0].frames.size(), 7U);
  EXPECT_EQ(fragments[1].frames[0].frame.value, 13);
  EXPECT_TRUE(fragments[1].joined_to_previous);
  EXPECT_EQ((*map)->figures().frames.lost, 6);
  for (const Edge& edge : (*map)->back_end(0).odometry_graph().odometry)
    EXPECT_TRUE(edge.information.allFinite());
}

TEST_F(OfflineMapTest, AFragmentWithoutPosesIsAnError) {
  lose_poses(10, 19);
  const auto map = build();
  ASSERT_FALSE(map.ok());
  EXPECT_THAT(map.error().message, HasSubstr("frames 10 to 19"));
  EXPECT_THAT(map.error().message, HasSubstr("fragment 1 would be empty"));
}

TEST_F(OfflineMapTest, TwoPosesAreNoTrajectory) {
  records_.resize(2);
  const auto map = build();
  ASSERT_FALSE(map.ok());
  EXPECT_THAT(map.error().message, HasSubstr("has poses for frames 0 to 1; only 2 usable"));
}

TEST_F(OfflineMapTest, DepthOutOfRangeGivesAnEmptyMap) {
  depth_scale_ = 1e6;  // millimetres taken for micrometres
  const auto map = build();
  ASSERT_FALSE(map.ok());
  EXPECT_THAT(map.error().message, HasSubstr("is empty"));
  EXPECT_THAT(map.error().message, HasSubstr("depth_scale"));
}

TEST_F(OfflineMapTest, BackEndsOfItsOwnHaveTheSameGraph) {
  const auto map = build();
  ASSERT_TRUE(map.ok()) << map.error().message;
  const PoseGraph& graph = (*map)->back_end(0).odometry_graph();
  const auto same = (*map)->make_back_end(ScoreKind::kPlain, 1.0);
  const auto surer = (*map)->make_back_end(ScoreKind::kPosterior, 4.0);
  ASSERT_EQ((*surer)->odometry_graph().odometry.size(), graph.odometry.size());
  for (std::size_t k = 0; k < graph.odometry.size(); ++k) {
    EXPECT_EQ((*same)->odometry_graph().odometry[k].information, graph.odometry[k].information);
    EXPECT_LT(
        ((*surer)->odometry_graph().odometry[k].information - 4.0 * graph.odometry[k].information).norm(),
        1e-9 * graph.odometry[k].information.norm());
  }
  EXPECT_EQ((*same)->scorer().view_count(), (*map)->back_end(0).scorer().view_count());
}

TEST_F(OfflineMapTest, GivenInformationIsTaken) {
  std::vector<InfoRecord> infos;
  for (int k = 0; k + 1 < kFrames; ++k)
    infos.push_back({k, k + 1, kFrames, (100.0 + k) * Matrix6d::Identity()});
  info_path_ = folder_ / "odometry.info";
  ASSERT_TRUE(write_info(info_path_, infos).ok());
  const auto map = build();
  ASSERT_TRUE(map.ok()) << map.error().message;
  EXPECT_NEAR((*map)->fragments()[1].frames[0].information(0, 0), 109.0, 1e-6);
  EXPECT_NEAR((*map)->fragments()[1].frames[4].information(5, 5), 113.0, 1e-6);
}

TEST_F(OfflineMapTest, InformationThatDoesNotFitIsNamed) {
  info_path_ = folder_ / "odometry.info";
  ASSERT_TRUE(write_info(info_path_, {{3, 5, kFrames, Matrix6d::Identity()}}).ok());
  EXPECT_THAT(build().error().message, HasSubstr("record 3 5"));
  ASSERT_TRUE(write_info(info_path_, {{3, 4, kFrames, Matrix6d::Zero()}}).ok());
  EXPECT_THAT(build().error().message, HasSubstr("not positive definite"));
}

}  // namespace
}  // namespace loopsift::tool
