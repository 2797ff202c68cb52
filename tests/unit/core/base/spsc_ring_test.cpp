// SPDX-License-Identifier: MIT
#include "core/base/spsc_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "core/base/drop_oldest_ring.hpp"
#include "core/base/semaphore.hpp"
#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

TEST(SpscRing, KeepsOrderAndRefusesPastItsCapacity) {
  std::array<int, 3> storage{};
  SpscRing<int> ring(storage);
  EXPECT_EQ(ring.capacity(), 3U);
  int value = 0;
  EXPECT_FALSE(ring.try_pop(&value));
  for (int round = 0; round < 5; ++round) {  // past the end of the storage and round again
    EXPECT_TRUE(ring.try_push(10 * round));
    EXPECT_TRUE(ring.try_push(10 * round + 1));
    EXPECT_TRUE(ring.try_push(10 * round + 2));
    EXPECT_FALSE(ring.try_push(99));
    EXPECT_EQ(ring.size(), 3U);
    for (int k = 0; k < 3; ++k) {
      ASSERT_TRUE(ring.try_pop(&value));
      EXPECT_EQ(value, 10 * round + k);
    }
    EXPECT_FALSE(ring.try_pop(&value));
    EXPECT_EQ(ring.size(), 0U);
  }
}

TEST(SpscRing, TakesTypesThatOnlyMove) {
  std::array<std::unique_ptr<int>, 2> storage;
  SpscRing<std::unique_ptr<int>> ring(storage);
  EXPECT_TRUE(ring.try_push(std::make_unique<int>(7)));
  std::unique_ptr<int> value;
  ASSERT_TRUE(ring.try_pop(&value));
  EXPECT_EQ(*value, 7);
}

TEST(SpscRing, TwoThreadsLoseAndReorderNothing) {
  constexpr int kCount = 200000;
  std::array<int, 8> storage{};
  SpscRing<int> ring(storage);
  std::thread producer([&] {
    for (int k = 0; k < kCount;) {
      if (ring.try_push(k))
        ++k;
      else
        std::this_thread::yield();
    }
  });
  std::vector<int> taken;
  for (int value = 0; taken.size() < kCount;) {
    if (ring.try_pop(&value))
      taken.push_back(value);
    else
      std::this_thread::yield();
  }
  producer.join();
  for (int k = 0; k < kCount; ++k) ASSERT_EQ(taken[static_cast<std::size_t>(k)], k);
}

TEST(DropOldestRing, TheProducerTakesTheOldestOut) {
  std::array<DropOldestRing::Slot, 2> storage{};
  DropOldestRing ring(storage);
  EXPECT_TRUE(ring.try_push(1));
  EXPECT_TRUE(ring.try_push(2));
  EXPECT_FALSE(ring.try_push(3));
  std::uint32_t value = 0;
  ASSERT_TRUE(ring.try_pop(&value));
  EXPECT_EQ(value, 1U);
  EXPECT_TRUE(ring.try_push(3));
  ASSERT_TRUE(ring.try_pop(&value));
  EXPECT_EQ(value, 2U);
  ASSERT_TRUE(ring.try_pop(&value));
  EXPECT_EQ(value, 3U);
  EXPECT_FALSE(ring.try_pop(&value));
}

TEST(DropOldestRing, EveryEntryGoesToExactlyOneOfTwoThreadsInOrder) {
  constexpr std::uint32_t kCount = 200000;
  std::array<DropOldestRing::Slot, 4> storage{};
  DropOldestRing ring(storage);
  std::vector<std::uint32_t> dropped, taken;
  dropped.reserve(kCount);
  taken.reserve(kCount);
  std::atomic<bool> done{false};
  std::thread producer([&] {
    for (std::uint32_t k = 0; k < kCount; ++k) {
      std::uint32_t oldest = 0;
      while (!ring.try_push(k)) {
        if (ring.try_pop(&oldest)) dropped.push_back(oldest);
      }
    }
    done = true;
  });
  std::uint32_t value = 0;
  while (true) {
    const bool was_done = done;
    if (ring.try_pop(&value))
      taken.push_back(value);
    else if (was_done)
      break;
  }
  producer.join();
  EXPECT_TRUE(std::is_sorted(taken.begin(), taken.end()));
  EXPECT_TRUE(std::is_sorted(dropped.begin(), dropped.end()));
  std::vector<std::uint32_t> all(taken);
  all.insert(all.end(), dropped.begin(), dropped.end());
  std::sort(all.begin(), all.end());
  ASSERT_EQ(all.size(), kCount);
  for (std::uint32_t k = 0; k < kCount; ++k) ASSERT_EQ(all[k], k);
}

TEST(Semaphore, WakesAThreadAndTimesOut) {
  Semaphore semaphore;
  EXPECT_FALSE(semaphore.wait_until(steady_now_ns() + 1'000'000));
  std::thread other([&] { semaphore.post(); });
  semaphore.wait();
  other.join();
  semaphore.post();
  EXPECT_TRUE(semaphore.wait_until(0)) << "a post that is there counts even past the deadline";
}

}  // namespace
}  // namespace loopsift
