// SPDX-License-Identifier: MIT
// The heap seal and the fence, with the hooks in this program.
#include "core/base/heap_watch.hpp"

#include <gtest/gtest.h>
#include <pthread.h>

#include <Eigen/Core>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

// NOLINTBEGIN(cppcoreguidelines-no-malloc): this is what it is all about

namespace loopsift {
namespace {

using Calls = std::atomic<std::int64_t>;
constexpr std::size_t kKib = 1024;

// Keeps the compiler from leaving the call out.
void keep(void* p) { asm volatile("" : : "r"(p) : "memory"); }

template <class Work>
std::int64_t calls_of(Work&& work) {
  Calls calls{0};
  {
    const HeapSeal seal(&calls, HeapMode::kCount);
    work();
  }
  return calls;
}

TEST(HeapSeal, ThisProgramHasTheHooks) { EXPECT_TRUE(heap_is_watched()); }

TEST(HeapSeal, CountsEveryKindOfCall) {
  void* p = std::malloc(8);
  EXPECT_EQ(calls_of([] { keep(std::malloc(0)); }), 1);
  EXPECT_EQ(calls_of([] { keep(std::calloc(2, 8)); }), 1);
  EXPECT_EQ(calls_of([&] { keep(p = std::realloc(p, 4096)); }), 1);
  EXPECT_EQ(calls_of([&] { std::free(p); }), 1);
  EXPECT_EQ(calls_of([] { keep(std::aligned_alloc(64, 128)); }), 1);
  EXPECT_EQ(calls_of([&] { EXPECT_EQ(posix_memalign(&p, 64, 128), 0); }), 1);
  std::free(p);
  EXPECT_EQ(calls_of([] { keep(new int(1)); }), 1);
  EXPECT_EQ(calls_of([] { std::free(nullptr); }), 0);
  EXPECT_EQ(calls_of([] {}), 0);
}

TEST(HeapSeal, SeesWhatALibraryHides) {
  EXPECT_GT(calls_of([] {
              const Eigen::MatrixXd a = Eigen::MatrixXd::Ones(8, 8);
              const Eigen::MatrixXd b = a * a;
              keep(const_cast<double*>(b.data()));
            }),
            0);
  EXPECT_EQ(calls_of([] {
              const Eigen::Matrix4d a = Eigen::Matrix4d::Ones();
              Eigen::Matrix4d b = a * a;
              keep(b.data());
            }),
            0);
}

TEST(HeapSeal, WhatALibraryIsPardonedIsCountedApart) {
  Calls calls{0}, pardoned{0};
  {
    const HeapSeal seal(&calls, HeapMode::kCount, &pardoned);
    keep(std::make_unique<int>(1).get());
    const HeapPardon library;
    keep(std::make_unique<int>(2).get());
    keep(std::make_unique<int>(3).get());
  }
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(pardoned, 4);
}

TEST(HeapSeal, ThePardonEndsWithItsScope) {
  { const HeapPardon library; }
  EXPECT_EQ(calls_of([] { keep(std::malloc(0)); }), 1);
}

TEST(HeapSeal, OtherThreadsAreFree) {
  std::atomic<int> step{0};
  std::thread other([&] {
    while (step < 1) std::this_thread::yield();
    for (int k = 0; k < 100; ++k) keep(std::make_unique<int>(k).get());
    step = 2;
  });
  const std::int64_t calls = calls_of([&] {
    step = 1;
    while (step < 2) std::this_thread::yield();
  });
  other.join();
  EXPECT_EQ(calls, 0);
}

TEST(HeapSealDeathTest, TheTrapTrapsAndNamesTheThread) {
  const auto trapped = [] {
    pthread_setname_np(pthread_self(), "front");
    Calls calls{0};
    const HeapSeal seal(&calls, HeapMode::kAbort);
    keep(std::malloc(16));
  };
  EXPECT_EXIT(trapped(), ::testing::KilledBySignal(SIGABRT), "malloc in the sealed thread front");
}

TEST(HeapSealDeathTest, TheTrapTrapsAFree) {
  const auto trapped = [] {
    void* p = std::malloc(16);
    keep(p);
    Calls calls{0};
    const HeapSeal seal(&calls, HeapMode::kAbort);
    std::free(p);
  };
  EXPECT_EXIT(trapped(), ::testing::KilledBySignal(SIGABRT), "free in the sealed thread");
}

TEST(HeapFence, HoldsBytesUpToItsLimitAndNoMore) {
  HeapFence::Figures figures;
  const HeapFence fence(64 * kKib, 64 * kKib, &figures);
  auto first = std::make_unique<char[]>(40 * kKib);
  keep(first.get());
  EXPECT_GE(figures.used_bytes, 40 * static_cast<std::int64_t>(kKib));
  EXPECT_THROW(keep(std::make_unique<char[]>(40 * kKib).get()), std::bad_alloc);
  EXPECT_EQ(std::malloc(40 * kKib), nullptr);
  EXPECT_EQ(figures.refusals, 2);
  first.reset();
  EXPECT_NO_THROW(keep(std::make_unique<char[]>(40 * kKib).get())) << "what was given back can be had again";
  EXPECT_EQ(figures.used_bytes, 0);
  EXPECT_GE(figures.peak_bytes, 40 * static_cast<std::int64_t>(kKib));
  EXPECT_LE(figures.peak_bytes, 64 * static_cast<std::int64_t>(kKib));
}

TEST(HeapFence, AGrowingBlockIsChargedForItsGrowth) {
  HeapFence::Figures figures;
  const HeapFence fence(64 * kKib, 64 * kKib, &figures);
  void* p = std::malloc(40 * kKib);
  p = std::realloc(p, 60 * kKib);
  ASSERT_NE(p, nullptr);
  void* larger = std::realloc(p, 100 * kKib);
  EXPECT_EQ(larger, nullptr);
  std::free(larger != nullptr ? larger : p);
  EXPECT_EQ(figures.used_bytes, 0);
}

TEST(HeapFence, LibraryWorkFailsFirstAndIsCountedOnce) {
  HeapFence::Figures figures;
  const HeapFence fence(64 * kKib, 32 * kKib, &figures);
  const auto wants = [](std::size_t bytes) {
    return within_fence([&] {
      std::vector<char> some(bytes);
      keep(some.data());
    });
  };
  EXPECT_TRUE(wants(20 * kKib));
  EXPECT_FALSE(wants(40 * kKib));
  EXPECT_EQ(figures.refusals, 1);
  std::vector<char> ours(40 * kKib);  // outside of library work there is still room
  keep(ours.data());
  EXPECT_FALSE(wants(kKib)) << "past its share whoever holds the memory";
  std::vector<char>().swap(ours);
  EXPECT_TRUE(wants(20 * kKib)) << "recovers";
  EXPECT_EQ(figures.refusals, 2);
}

// A C library that gets null and copes with it is refused, too, though nothing is thrown.
TEST(HeapFence, ARefusalThatALibrarySwallowsIsCounted) {
  HeapFence::Figures figures;
  const HeapFence fence(64 * kKib, 32 * kKib, &figures);
  EXPECT_TRUE(within_fence([] { EXPECT_EQ(std::malloc(40 * kKib), nullptr); }));
  EXPECT_EQ(figures.refusals, 1);
}

TEST(HeapFence, ThreadsWithoutOneAreNotHeldUp) {
  EXPECT_TRUE(within_fence([] { keep(std::make_unique<char[]>(1024 * kKib).get()); }));
  HeapFence::Figures figures;
  const HeapFence fence(kKib, kKib, &figures);
  bool other = false;
  void* place = &other;
  keep(place);
  pthread_t thread;  // std::thread would itself need the heap
  const auto body = [](void* done) -> void* {
    *static_cast<bool*>(done) = within_fence([] { keep(std::make_unique<char[]>(1024 * kKib).get()); });
    return nullptr;
  };
  ASSERT_EQ(pthread_create(&thread, nullptr, body, &other), 0);
  pthread_join(thread, nullptr);
  EXPECT_TRUE(other);
}

}  // namespace
}  // namespace loopsift
// NOLINTEND(cppcoreguidelines-no-malloc)
