// SPDX-License-Identifier: MIT
#include "drivers/lcm/lcm_poses.hpp"

#include <gtest/gtest.h>

#include <bot_core/pose_t.hpp>
#include <limits>
#include <vector>

#include "core/geometry/body_axes.hpp"

namespace loopsift {
namespace {

std::vector<std::uint8_t> encode(const bot_core::pose_t& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

bot_core::pose_t turned_left() {
  bot_core::pose_t message{};
  message.utime = 123;
  message.pos[0] = 1;
  message.pos[2] = 3;
  message.orientation[0] = message.orientation[3] = std::sqrt(0.5);  // 90° about Z
  return message;
}

TEST(LcmPoses, APoseIsReadInItsOwnConvention) {
  std::int64_t utime_us = 0;
  Se3 T;
  const std::vector<std::uint8_t> bytes = encode(turned_left());
  ASSERT_TRUE(parse_pose(bytes.data(), bytes.size(), &utime_us, &T));
  EXPECT_EQ(utime_us, 123);
  EXPECT_TRUE((T * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 1, 3), 1e-9)) << "W first";
}

TEST(LcmPoses, WhatIsNoPoseIsRefused) {
  const auto refused = [](const auto& change) {
    bot_core::pose_t message = turned_left();
    change(&message);
    const std::vector<std::uint8_t> bytes = encode(message);
    std::int64_t utime_us = 0;
    Se3 T;
    return !parse_pose(bytes.data(), bytes.size(), &utime_us, &T);
  };
  EXPECT_FALSE(refused([](auto*) {}));
  EXPECT_TRUE(refused([](auto* m) { m->pos[1] = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](auto* m) { m->orientation[0] = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](auto* m) { m->orientation[0] = m->orientation[3] = 0; }));
  EXPECT_TRUE(refused([](auto* m) { m->utime = -1; }));
  EXPECT_TRUE(refused([](auto* m) { m->utime = std::numeric_limits<std::int64_t>::max(); }));
  std::vector<std::uint8_t> bytes = encode(turned_left());
  std::int64_t utime_us = 0;
  Se3 T;
  EXPECT_FALSE(parse_pose(bytes.data(), bytes.size() - 1, &utime_us, &T));
  bytes[0] = static_cast<std::uint8_t>(bytes[0] + 1);
  EXPECT_FALSE(parse_pose(bytes.data(), bytes.size(), &utime_us, &T));
}

TEST(LcmPoses, TheCameraSitsOnTheBody) {
  const Se3 T_local_body(Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                         {1, 2, 0});
  const Se3 T_body_mount(Eigen::Matrix3d::Identity(), {0.5, 0, 0.2});
  const Se3 T = camera_pose(T_local_body, T_body_mount);
  // The mount is at (1, 2.5, 0.2) in the body's axes: X forward is z, Y left is −x, Z up is −y.
  EXPECT_TRUE(T.translation().isApprox(Eigen::Vector3d(-2.5, -0.2, 1), 1e-9)) << T.translation();
  // What the camera has before it lies to the left of where it began: at −x.
  EXPECT_TRUE((T.rotation() * Eigen::Vector3d::UnitZ()).isApprox(-Eigen::Vector3d::UnitX(), 1e-9));
}

}  // namespace
}  // namespace loopsift
