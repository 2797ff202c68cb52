// SPDX-License-Identifier: MIT
#include "core/pipeline/corrected_trajectory.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

constexpr std::int64_t kMs = 1'000'000;

// Nodes at 1 s, 2 s and 3 s, frames every 0.1 s from 0.5 s to 3.5 s, on a curve.
struct CurvedPath {
  CurvedPath() {
    for (int n = 0; n < 3; ++n) {
      graph.nodes.push_back({FragmentId{n}, Se3(), (1000 + 1000 * n) * kMs});
      graph.first_node.push_back(n);
      graph.T_map_node.push_back(pose_at(1.0 + n));
    }
    graph.first_node.push_back(3);
    for (int n = 0; n < 2; ++n) graph.odometry.push_back({n, n + 1, Se3(), Matrix6d::Identity(), LoopId{}});
    for (int k = 0; k <= 30; ++k) frames.push_back({(500 + 100 * k) * kMs, pose_at(0.5 + 0.1 * k)});
  }
  static Se3 pose_at(double s) { return {so3_exp({0.1 * s, 0.4 * s, 0}), {0.5 * s, 0.1 * s * s, 0}}; }
  [[nodiscard]] Trajectory corrected(const std::vector<Se3>& T_map_odom) const {
    std::vector<Se3> T_map_node;
    for (std::size_t n = 0; n < 3; ++n) T_map_node.push_back(T_map_odom[n] * graph.T_map_node[n]);
    return corrected_trajectory(Span<const OdometryPose>(frames.data(), frames.size()), graph, T_map_node);
  }
  PoseGraph graph;
  std::vector<OdometryPose> frames;
};

double distance(const Se3& a, const Se3& b) { return (a.inverse() * b).log().norm(); }

TEST(CorrectedTrajectory, IsTheOdometryWhereNothingIsCorrected) {
  const CurvedPath path;
  const Trajectory trajectory = path.corrected({Se3(), Se3(), Se3()});
  const Trajectory odometry =
      odometry_trajectory(Span<const OdometryPose>(path.frames.data(), path.frames.size()));
  ASSERT_EQ(trajectory.poses.size(), path.frames.size());
  ASSERT_EQ(odometry.poses.size(), path.frames.size());
  EXPECT_FALSE(trajectory.indexed);
  for (std::size_t k = 0; k < path.frames.size(); ++k) {
    EXPECT_NEAR(trajectory.poses[k].time_s, 0.5 + 0.1 * static_cast<double>(k), 1e-9);
    EXPECT_LT(distance(trajectory.poses[k].T_world_camera, path.frames[k].T_odom_camera), 1e-9);
    EXPECT_EQ(odometry.poses[k].T_world_camera.matrix(), path.frames[k].T_odom_camera.matrix());
  }
}

TEST(CorrectedTrajectory, MovesRigidlyWithOneCorrection) {
  const CurvedPath path;
  const Se3 T_map_odom(so3_exp({0, 0.3, 0.1}), {1, -2, 0.5});
  const Trajectory trajectory = path.corrected({T_map_odom, T_map_odom, T_map_odom});
  for (std::size_t k = 0; k < path.frames.size(); ++k)
    EXPECT_LT(distance(trajectory.poses[k].T_world_camera, T_map_odom * path.frames[k].T_odom_camera), 1e-9);
}

TEST(CorrectedTrajectory, BlendsBetweenTheNodesByTime) {
  const CurvedPath path;
  const Se3 shift(Eigen::Matrix3d::Identity(), {0.4, 0, 0});
  const Trajectory trajectory = path.corrected({Se3(), shift, shift});
  for (std::size_t k = 0; k < path.frames.size(); ++k) {
    const double time = trajectory.poses[k].time_s;
    const double part = std::min(1.0, std::max(0.0, time - 1.0));
    const Eigen::Vector3d moved =
        trajectory.poses[k].T_world_camera.translation() - path.frames[k].T_odom_camera.translation();
    EXPECT_LT((moved - Eigen::Vector3d(0.4 * part, 0, 0)).norm(), 1e-9) << "at " << time << " s";
  }
}

TEST(CorrectedTrajectory, PutsTheNodesFramesWhereTheNodesAre) {
  const CurvedPath path;
  const std::vector<Se3> T_map_odom = {Se3(so3_exp({0, 0.1, 0}), {0.1, 0, 0}),
                                       Se3(so3_exp({0.2, 0, 0}), {0, 0.3, 0}),
                                       Se3(so3_exp({0, 0, -0.1}), {0, 0, -0.2})};
  const Trajectory trajectory = path.corrected(T_map_odom);
  for (const std::size_t n : {0U, 1U, 2U}) {
    const std::size_t frame = 5 + 10 * n;
    EXPECT_LT(distance(trajectory.poses[frame].T_world_camera,
                       T_map_odom[n] * CurvedPath::pose_at(1.0 + static_cast<double>(n))),
              1e-6);
  }
  double largest_step = 0;  // against the odometry's own
  for (std::size_t k = 1; k < path.frames.size(); ++k) {
    const double step = (trajectory.poses[k].T_world_camera.translation() -
                         trajectory.poses[k - 1].T_world_camera.translation())
                            .norm();
    const double own =
        (path.frames[k].T_odom_camera.translation() - path.frames[k - 1].T_odom_camera.translation()).norm();
    largest_step = std::max(largest_step, std::abs(step - own));
  }
  EXPECT_LT(largest_step, 0.08) << "no jump: a tenth of the corrections' difference a frame";
}

TEST(CorrectedTrajectory, HoldsTheNearestCorrectionBeforeAndAfterTheNodes) {
  const CurvedPath path;
  const Se3 first(Eigen::Matrix3d::Identity(), {1, 0, 0}), last(Eigen::Matrix3d::Identity(), {0, 2, 0});
  const Trajectory trajectory = path.corrected({first, Se3(), last});
  EXPECT_LT(distance(trajectory.poses.front().T_world_camera, first * path.frames.front().T_odom_camera),
            1e-9);
  EXPECT_LT(distance(trajectory.poses.back().T_world_camera, last * path.frames.back().T_odom_camera), 1e-9);
}

TEST(CorrectedTrajectory, NothingIsBlendedWhereTrackingWasLost) {
  CurvedPath path;
  path.graph.odometry.pop_back();  // between 2 s and 3 s
  const Se3 far(Eigen::Matrix3d::Identity(), {5, 0, 0});
  const Trajectory trajectory = path.corrected({Se3(), Se3(), far});
  for (std::size_t k = 0; k < path.frames.size(); ++k) {
    const Se3& expected = trajectory.poses[k].time_s < 2.95 ? Se3() : far;
    EXPECT_LT(distance(trajectory.poses[k].T_world_camera, expected * path.frames[k].T_odom_camera), 1e-9)
        << "at " << trajectory.poses[k].time_s << " s";
  }
}

TEST(CorrectedTrajectory, WithoutNodesIsTheOdometry) {
  const CurvedPath path;
  const Trajectory trajectory =
      corrected_trajectory(Span<const OdometryPose>(path.frames.data(), path.frames.size()), PoseGraph{}, {});
  ASSERT_EQ(trajectory.poses.size(), path.frames.size());
  EXPECT_EQ(trajectory.poses[7].T_world_camera.matrix(), path.frames[7].T_odom_camera.matrix());
  EXPECT_TRUE(corrected_trajectory({}, path.graph, path.graph.T_map_node).poses.empty());
}

}  // namespace
}  // namespace loopsift
