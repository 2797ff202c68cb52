// SPDX-License-Identifier: MIT
#include "drivers/libcamera/request_handover.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

using Wait = RequestHandover::Wait;

std::int64_t far_deadline() { return steady_now_ns() + 60'000'000'000; }

TEST(RequestHandover, ArriveInOrder) {
  RequestHandover requests(3);
  for (const std::uint32_t k : {2U, 0U, 1U}) ASSERT_TRUE(requests.push(k));
  std::uint32_t got = 9;
  for (const std::uint32_t k : {2U, 0U, 1U}) {
    EXPECT_EQ(requests.pop(&got, far_deadline()), Wait::kRequest);
    EXPECT_EQ(got, k);
  }
  EXPECT_EQ(requests.pop(&got, steady_now_ns()), Wait::kTimeout);
}

TEST(RequestHandover, MoreThanThereAreIsRefused) {
  RequestHandover requests(2);
  EXPECT_TRUE(requests.push(0));
  EXPECT_TRUE(requests.push(1));
  EXPECT_FALSE(requests.push(0));
}

TEST(RequestHandover, TheEndComesAfterWhatWasPushed) {
  RequestHandover requests(2);
  ASSERT_TRUE(requests.push(1));
  requests.end();
  std::uint32_t got = 9;
  EXPECT_EQ(requests.pop(&got, far_deadline()), Wait::kRequest);
  EXPECT_EQ(requests.pop(&got, far_deadline()), Wait::kEnded);
  EXPECT_EQ(requests.pop(&got, far_deadline()), Wait::kEnded);
}

// Three requests go round between two threads, as the camera and the reader pass them.
TEST(RequestHandover, NoneIsLostOrDoubledBetweenThreads) {
  constexpr std::uint32_t kRequests = 3, kRounds = 20000;
  RequestHandover to_reader(kRequests), to_camera(kRequests);
  std::thread camera([&] {
    std::uint32_t request = 0;
    for (std::uint32_t k = 0; k < kRequests; ++k) EXPECT_TRUE(to_reader.push(k));
    for (std::uint32_t k = kRequests; k < kRounds; ++k) {
      EXPECT_EQ(to_camera.pop(&request, far_deadline()), Wait::kRequest);
      EXPECT_TRUE(to_reader.push(request));
    }
    to_reader.end();
  });
  std::uint32_t request = 0, taken = 0;
  while (to_reader.pop(&request, far_deadline()) == Wait::kRequest) {
    EXPECT_EQ(request, taken++ % kRequests);
    EXPECT_TRUE(to_camera.push(request) || taken + kRequests > kRounds);
  }
  camera.join();
  EXPECT_EQ(taken, kRounds);
}

}  // namespace
}  // namespace loopsift
