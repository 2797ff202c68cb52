// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_loop_in.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <loopsift/loop_in_t.hpp>
#include <random>
#include <vector>

#include "firmware_app/publisher_messages.hpp"

namespace loopsift {
namespace {

loop_in_t sound() {
  loop_in_t message{};
  message.utime_i = 1'000'000;
  message.utime_j = 9'000'000;
  message.T_i_j.trans[0] = 2;  // X: ahead
  message.T_i_j.quat[0] = 1;
  return message;
}

std::vector<std::uint8_t> encode(const loop_in_t& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

bool accepted(const loop_in_t& message) {
  OutsideLoop loop;
  const std::vector<std::uint8_t> bytes = encode(message);
  return parse_loop_in(bytes.data(), bytes.size(), &loop);
}

TEST(LoopIn, ComesInCameraAxesAsEverythingElseGoesOut) {
  loop_in_t message = sound();
  for (int k = 0; k < 6; ++k) message.covariance[7 * k] = k + 1;
  OutsideLoop loop;
  const std::vector<std::uint8_t> bytes = encode(message);
  ASSERT_TRUE(parse_loop_in(bytes.data(), bytes.size(), &loop));
  EXPECT_EQ(loop.timestamp_i_ns, 1'000'000'000);
  EXPECT_EQ(loop.timestamp_j_ns, 9'000'000'000);
  EXPECT_TRUE(loop.T_i_j.translation().isApprox(Eigen::Vector3d(0, 0, 2), 1e-12));
  const Matrix6d back = in_body_axes(loop.covariance);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(back(k, k), k + 1, 1e-12);
  transform_t sent{};
  fill(&sent, loop.T_i_j);
  EXPECT_NEAR(sent.trans[0], 2, 1e-12);
}

TEST(LoopIn, WithoutACovarianceTheUsualOneIsTaken) {
  OutsideLoop loop;
  const std::vector<std::uint8_t> bytes = encode(sound());
  ASSERT_TRUE(parse_loop_in(bytes.data(), bytes.size(), &loop));
  EXPECT_NEAR(loop.covariance(0, 0), 1e-4, 1e-12);
  EXPECT_NEAR(loop.covariance(5, 5), 7.62e-5, 1e-6);
}

TEST(LoopIn, WhatIsNoLoopIsRefused) {
  const auto refused = [](const auto& change) {
    loop_in_t message = sound();
    change(&message);
    return !accepted(message);
  };
  EXPECT_FALSE(refused([](auto*) {}));
  EXPECT_TRUE(refused([](auto* m) { m->utime_i = -1; }));
  EXPECT_TRUE(refused([](auto* m) { m->utime_j = std::numeric_limits<std::int64_t>::max(); }));
  EXPECT_TRUE(refused([](auto* m) { m->T_i_j.quat[0] = 0; }));
  EXPECT_TRUE(refused([](auto* m) { m->T_i_j.trans[2] = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](auto* m) { m->covariance[0] = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](auto* m) { m->covariance[0] = -1; })) << "not positive definite";
  EXPECT_TRUE(refused([](auto* m) { m->covariance[1] = 1; })) << "not positive definite";
}

TEST(LoopIn, RandomBytesDoNothing) {
  const std::vector<std::uint8_t> whole = encode(sound());
  std::mt19937 random(1);
  OutsideLoop loop;
  for (int round = 0; round < 2000; ++round) {
    std::vector<std::uint8_t> bytes(random() % (whole.size() + 40));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    EXPECT_FALSE(parse_loop_in(bytes.data(), bytes.size(), &loop)) << "another type's fingerprint";
  }
  EXPECT_FALSE(parse_loop_in(whole.data(), whole.size() - 1, &loop));
}

}  // namespace
}  // namespace loopsift
