// SPDX-License-Identifier: MIT
#include "core/geometry/trajectory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::TemporaryFolder;
using ::testing::HasSubstr;

Se3 some_pose(double angle) {
  Vector6d xi;
  xi << 1.5, -2.25, 0.125, 0.1, angle, -0.2;
  return Se3::exp(xi);
}

Trajectory three_poses() {
  Trajectory trajectory;
  for (int i = 0; i < 3; ++i) trajectory.poses.push_back({1305031102.25 + 0.5 * i, some_pose(0.3 * i)});
  return trajectory;
}

double distance(const Se3& a, const Se3& b) { return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff(); }

std::string message_of(const TemporaryFolder& folder, const std::string& content) {
  const auto trajectory = read_trajectory(folder.write("t.txt", content));
  return trajectory.ok() ? "accepted" : trajectory.error().message;
}

TEST(Trajectory, TumRoundTrip) {
  const TemporaryFolder folder;
  const Trajectory written = three_poses();
  ASSERT_TRUE(write_trajectory_tum(folder / "t.txt", written).ok());
  const auto read = read_trajectory(folder / "t.txt");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_FALSE(read->indexed);
  ASSERT_EQ(read->poses.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(read->poses[i].time_s, written.poses[i].time_s);
    EXPECT_LT(distance(read->poses[i].T_world_camera, written.poses[i].T_world_camera), 5e-9);
  }
}

TEST(Trajectory, RedwoodLogRoundTripCountsFrames) {
  const TemporaryFolder folder;
  const Trajectory written = three_poses();
  ASSERT_TRUE(write_trajectory_log(folder / "t.log", written).ok());
  const auto read = read_trajectory(folder / "t.log");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(read->indexed);
  ASSERT_EQ(read->poses.size(), 3U);
  EXPECT_EQ(read->poses[2].time_s, 2.0);
  EXPECT_LT(distance(read->poses[2].T_world_camera, written.poses[2].T_world_camera), 1e-9);
}

TEST(Trajectory, TumOrderIsTranslationThenQuaternionWithWLast) {
  const TemporaryFolder folder;
  const auto read =
      read_trajectory(folder.write("t.txt", "# time x y z qx qy qz qw\r\n\n1 10 20 30 0 0 1 0\r\n"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_LT((read->poses[0].T_world_camera * Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(9, 18, 33)).norm(),
            1e-12);
}

TEST(Trajectory, AtInterpolatesOnlyInsideShortGaps) {
  const Trajectory trajectory = three_poses();
  Se3 T;
  const double t0 = trajectory.poses[0].time_s;
  ASSERT_TRUE(trajectory.at(t0, 0.0, &T));
  EXPECT_EQ(distance(T, trajectory.poses[0].T_world_camera), 0.0);
  ASSERT_TRUE(trajectory.at(t0 + 0.25, 0.5, &T));
  const Se3 half = interpolate(trajectory.poses[0].T_world_camera, trajectory.poses[1].T_world_camera, 0.5);
  EXPECT_LT(distance(T, half), 1e-12);
  EXPECT_FALSE(trajectory.at(t0 + 0.25, 0.4, &T));
  EXPECT_FALSE(trajectory.at(t0 - 0.1, 1.0, &T));
  EXPECT_FALSE(trajectory.at(t0 + 1.1, 1.0, &T));
  EXPECT_FALSE(Trajectory().at(0, 1, &T));
}

TEST(Trajectory, AtTakesAPoseWhoseTimeWasRounded) {
  Trajectory trajectory;
  for (const double t : {1305031102.1753, 1305031102.4253})
    trajectory.poses.push_back(
        {t, Se3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(t - 1305031102.0, 0, 0))});
  Se3 T;
  ASSERT_TRUE(trajectory.at(1305031102.175260, 0.1, &T));  // before the first
  EXPECT_EQ(T.translation(), trajectory.poses[0].T_world_camera.translation());
  ASSERT_TRUE(trajectory.at(1305031102.425304, 0.1, &T));  // past the last
  EXPECT_EQ(T.translation(), trajectory.poses[1].T_world_camera.translation());
  EXPECT_FALSE(trajectory.at(1305031102.4255, 0.1, &T));
}

TEST(Trajectory, BadLinesAreNamedByFileAndLine) {
  const TemporaryFolder folder;
  const std::string good = "1 0 0 0 0 0 0 1\n";
  EXPECT_THAT(message_of(folder, good + "2 0 nan 0 0 0 0 1\n"), HasSubstr("t.txt:2: 'nan' is not a finite"));
  EXPECT_THAT(message_of(folder, good + "2 0 0 0 0 0 0\n"), HasSubstr("t.txt:2: neither a TUM line"));
  EXPECT_THAT(message_of(folder, good + good + "0.5 0 0 0 0 0 0 1\n"), HasSubstr("t.txt:3: time goes back"));
  EXPECT_THAT(message_of(folder, "1 0 0 0 0 0 0 0\n"), HasSubstr("t.txt:1: qx qy qz qw is no rotation"));
  EXPECT_THAT(message_of(folder, "1 0 0 0 0 0 0 1x\n"), HasSubstr("'1x' is not a finite number"));
  EXPECT_THAT(message_of(folder, "# nothing\n"), HasSubstr("holds no pose"));
  const auto missing = read_trajectory(folder / "none.txt");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("none.txt"));
}

TEST(Trajectory, BadLogRecordsAreNamedByFileAndLine) {
  const TemporaryFolder folder;
  const std::string identity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  EXPECT_THAT(message_of(folder, "0 0 1\n1 0 0 0\n0 2 0 0\n0 0 1 0\n0 0 0 1\n"),
              HasSubstr("t.txt:5: the 4x4"));
  EXPECT_THAT(message_of(folder, "0 0 1\n1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n"),
              HasSubstr("no rigid motion"));
  EXPECT_THAT(message_of(folder, "0 0 1\n1 0 0 0\n0 1 0 0\n"), HasSubstr("ends inside a record"));
  EXPECT_THAT(message_of(folder, "0 0 1\n1 0 0\n"), HasSubstr("t.txt:2: expected 4 numbers, found 3 words"));
  EXPECT_THAT(message_of(folder, "1 1 2\n" + identity + "0 0 1\n" + identity), HasSubstr("time goes back"));
  EXPECT_THAT(message_of(folder, "0 0 x\n" + identity), HasSubstr("t.txt:1: expected a record's header"));
}

TEST(LogFile, LoopsKeepTheirNumbersAndTransforms) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_log(folder / "l.log", {{3, 17, 57, some_pose(0.7)}, {4, 20, 57, some_pose(-2.9)}}).ok());
  const auto read = read_log(folder / "l.log");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].a, 3);
  EXPECT_EQ((*read)[0].b, 17);
  EXPECT_EQ((*read)[0].n, 57);
  EXPECT_LT(distance((*read)[1].T, some_pose(-2.9)), 1e-9);
}

TEST(LogFile, ASlightlyScaledRotationIsBroughtToTheNearestTrueOne) {
  const TemporaryFolder folder;
  const auto read = read_log(folder.write("l.log", "0 2 3\n1.05 0 0 1\n0 1.05 0 2\n0 0 1.05 3\n0 0 0 1\n"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_LT(distance((*read)[0].T, Se3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(1, 2, 3))), 1e-12);
}

TEST(InfoFile, CostOfASmallMotionIsTheSameInBothTangents) {
  // ξ_qᵀ Λ_q ξ_q with ξ_q = (t, q_xyz) must equal ξ_ωᵀ Λ_ω ξ_ω with ξ_ω = (t, ω).
  const Matrix6d A = Matrix6d::Random();
  const Matrix6d L_q = A * A.transpose() + Matrix6d::Identity();
  std::ostringstream text;
  text.precision(17);
  text << "0 2 5\n" << L_q << "\n";
  const TemporaryFolder folder;
  const auto read = read_info(folder.write("l.info", text.str()));
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->size(), 1U);
  EXPECT_EQ((*read)[0].b, 2);
  Vector6d xi;
  xi << 0.01, -0.02, 0.005, 1e-4, -2e-4, 3e-4;
  Vector6d xi_q = xi;
  xi_q.tail<3>() = Se3::exp(xi).quaternion().vec();
  EXPECT_NEAR(xi_q.dot(L_q * xi_q), xi.dot((*read)[0].information * xi), 1e-10);
}

TEST(InfoFile, RoundTrip) {
  const Matrix6d A = Matrix6d::Random();
  const InfoRecord record{1, 9, 57, 1e4 * A * A.transpose()};
  const TemporaryFolder folder;
  ASSERT_TRUE(write_info(folder / "l.info", {record}).ok());
  const auto read = read_info(folder / "l.info");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_LT(((*read)[0].information - record.information).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(InfoFile, RefusesWhatIsNoInformationMatrix) {
  const TemporaryFolder folder;
  std::string text = "0 2 5\n";
  for (int i = 0; i < 6; ++i) text += "1 2 3 4 5 6\n";
  const auto read = read_info(folder.write("l.info", text));
  ASSERT_FALSE(read.ok());
  EXPECT_THAT(read.error().message, HasSubstr("l.info:7: the 6x6 matrix"));
}

TEST(TrajectoryFiles, AFileThatCannotBeWrittenIsNamed) {
  const TemporaryFolder folder;
  const Status status = write_trajectory_tum(folder.path() + "/no/such/t.txt", three_poses());
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kIo);
  EXPECT_THAT(status.error().message, HasSubstr("/no/such/t.txt: cannot be written: No such file"));
}

}  // namespace
}  // namespace loopsift
