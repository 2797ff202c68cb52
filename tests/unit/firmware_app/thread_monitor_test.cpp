// SPDX-License-Identifier: MIT
#include "firmware_app/thread_monitor.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

#include "core/base/semaphore.hpp"
#include "core/base/steady_time.hpp"
#include "firmware_app/realtime.hpp"

namespace loopsift {
namespace {

TEST(ThreadMonitor, SeesNameRunningAndEnd) {
  ThreadMonitor monitor(ThreadRole::kPublish);
  Semaphore started, end;
  char name[16] = "";
  EXPECT_FALSE(monitor.running());
  std::thread thread([&] {
    const ThreadTenure tenure(&monitor);
    pthread_getname_np(pthread_self(), name, sizeof(name));
    started.post();
    end.wait();
  });
  started.wait();
  EXPECT_TRUE(monitor.running());
  EXPECT_STREQ(name, "publish");
  EXPECT_FALSE(monitor.realtime()) << "none was asked for";
  EXPECT_EQ(monitor.heap_calls(), -1) << "never sealed";
  end.post();
  thread.join();
  EXPECT_FALSE(monitor.running());
}

TEST(ThreadMonitor, CountsWhatTookLongerThanItsDeadline) {
  ThreadMonitor monitor(ThreadRole::kFront);
  monitor.set_plan({0, -1, 1, HeapMode::kAllow});  // a nanosecond: always late
  EXPECT_EQ(monitor.busy_ns(steady_now_ns()), 0);
  {
    const WorkSpan span(&monitor);
    EXPECT_GT(monitor.busy_ns(steady_now_ns() + 1000), 0);
  }
  EXPECT_EQ(monitor.busy_ns(steady_now_ns()), 0);
  EXPECT_EQ(monitor.deadline_misses(), 1);
  monitor.set_plan({0, -1, std::int64_t{3600} * 1'000'000'000, HeapMode::kAllow});
  { const WorkSpan span(&monitor); }
  EXPECT_EQ(monitor.deadline_misses(), 1);
  monitor.set_plan({});  // no deadline: never late
  { const WorkSpan span(&monitor); }
  EXPECT_EQ(monitor.deadline_misses(), 1);
}

TEST(ThreadMonitor, WorkThatGetsOnDoesNotHang) {
  ThreadMonitor monitor(ThreadRole::kBack);
  const WorkSpan span(&monitor);
  const std::int64_t later = steady_now_ns() + std::int64_t{1000} * 1'000'000'000;
  EXPECT_GT(monitor.busy_ns(later), std::int64_t{900} * 1'000'000'000);
  monitor.get_on(later - 1000);
  EXPECT_EQ(monitor.busy_ns(later), 1000);
}

TEST(ThreadMonitor, RunsOnTheProcessorOfItsPlan) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  ASSERT_EQ(sched_getaffinity(0, sizeof(allowed), &allowed), 0);
  std::size_t core = 0;  // the first that this process may use
  while (!CPU_ISSET(core, &allowed)) ++core;
  ThreadMonitor monitor(ThreadRole::kBack);
  monitor.set_plan({0, static_cast<int>(core), 0, HeapMode::kAllow});
  int cores = 0;
  std::thread thread([&] {
    const ThreadTenure tenure(&monitor);
    cpu_set_t set;
    CPU_ZERO(&set);
    pthread_getaffinity_np(pthread_self(), sizeof(set), &set);
    cores = CPU_COUNT(&set);
  });
  thread.join();
  EXPECT_EQ(cores, 1);
}

TEST(ThreadMonitor, NobodyMayWatch) {
  ThreadTenure tenure(nullptr);
  tenure.seal_heap();
  const WorkSpan span(nullptr);
}

TEST(Realtime, IsNotAskedForWhereFramesDoNotComeAtThePaceOfTheWorld) {
  ThreadSettings settings;
  settings.lock_memory = false;
  const RealtimeRights rights = prepare_realtime(settings, false);
  EXPECT_FALSE(rights.scheduling);
  EXPECT_TRUE(rights.warning.empty());
  const auto plans = thread_plans(Settings(), rights);
  for (const ThreadPlan& plan : plans) EXPECT_EQ(plan.fifo_priority, 0);
}

TEST(Realtime, WhatIsDeniedIsSaidOnce) {
  const ThreadSettings settings;
  const RealtimeRights rights = prepare_realtime(settings, true);
  EXPECT_EQ(rights.warning.empty(), rights.scheduling && rights.memory_locked);
  RealtimeRights granted;
  granted.scheduling = true;
  const auto plans = thread_plans(Settings(), granted);
  EXPECT_GT(plans[static_cast<std::size_t>(ThreadRole::kCapture)].fifo_priority,
            plans[static_cast<std::size_t>(ThreadRole::kFront)].fifo_priority);
  EXPECT_EQ(plans[static_cast<std::size_t>(ThreadRole::kBack)].fifo_priority, 0);
}

TEST(Realtime, KnowsWhatIsResident) { EXPECT_GT(resident_bytes(), 1 << 20); }

/// {resident, mapped} KiB of this program's code.
std::array<long, 2> code_kib() {
  std::array<char, 4096> path{};
  EXPECT_GT(readlink("/proc/self/exe", path.data(), path.size() - 1), 0);
  std::ifstream maps("/proc/self/smaps");
  std::array<long, 2> kib{};
  bool code = false;
  for (std::string line; std::getline(maps, line);) {
    std::istringstream words(line);
    std::string name, second;
    words >> name >> second;
    if (name.back() != ':') code = second == "r-xp" && line.find(path.data()) != std::string::npos;
    if (code && name == "Rss:") kib[0] += std::stol(second);
    if (code && name == "Size:") kib[1] += std::stol(second);
  }
  return kib;
}

TEST(Realtime, AllOfTheProgramsCodeIsThereOnceItIsLoaded) {
  load_program_code();
  const auto [resident, mapped] = code_kib();
  EXPECT_GT(mapped, 0);
  EXPECT_EQ(resident, mapped);
}

}  // namespace
}  // namespace loopsift
