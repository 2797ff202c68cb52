// SPDX-License-Identifier: MIT
// One thread as the supervisor sees it: how it is to run, whether it works, how often it was late, what it
// did to the heap. The thread itself writes, any thread reads; all of it is lock-free and never allocates.
//
//   ThreadTenure tenure(&monitor);        // first thing on the thread: name, scheduling, processor
//   tenure.seal_heap();                   // once all is warm
//   while (…) { wait(); WorkSpan span(&monitor); work(); }
//
// A null monitor is allowed in both and means that nobody watches.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "core/base/heap_watch.hpp"
#include "firmware_app/run_health.hpp"

namespace loopsift {

/// How a thread is to run.
struct ThreadPlan {
  int fifo_priority = 0;  ///< of SCHED_FIFO; 0: normal scheduling
  int core = -1;          ///< the only processor it runs on; −1: any
  std::int64_t deadline_ns = 0;
  HeapMode sealed = HeapMode::kCount;
};

class ThreadMonitor {
 public:
  explicit ThreadMonitor(ThreadRole role) : role_(role) {}
  ThreadMonitor(const ThreadMonitor&) = delete;
  ThreadMonitor& operator=(const ThreadMonitor&) = delete;

  /// Before the thread starts.
  void set_plan(const ThreadPlan& plan) { plan_ = plan; }

  /// The thread itself, in a long piece of work: it gets on, the time that it has been busy begins anew.
  void get_on(std::int64_t now_ns) { busy_since_ns_.store(now_ns, std::memory_order_relaxed); }

  // Any thread.
  [[nodiscard]] const char* name() const { return kThreadNames[static_cast<std::size_t>(role_)]; }
  [[nodiscard]] bool running() const { return running_.load(std::memory_order_acquire); }
  [[nodiscard]] bool realtime() const { return realtime_.load(std::memory_order_relaxed); }
  /// Pieces of work that took longer than the plan's deadline.
  [[nodiscard]] std::int64_t deadline_misses() const { return misses_.load(std::memory_order_relaxed); }
  /// For how long the present piece of work has been going on, or since it last got on; 0 while the thread
  /// waits.
  [[nodiscard]] std::int64_t busy_ns(std::int64_t now_ns) const;
  /// Since the seal; −1 when the thread was never sealed or this program does not count.
  [[nodiscard]] std::int64_t heap_calls() const;
  /// Those that a library made under a HeapPardon; −1 as above.
  [[nodiscard]] std::int64_t library_heap_calls() const;

 private:
  friend class ThreadTenure;
  friend class WorkSpan;
  ThreadRole role_;
  ThreadPlan plan_;
  std::atomic<bool> running_{false}, realtime_{false}, sealed_{false};
  std::atomic<std::int64_t> busy_since_ns_{0}, misses_{0}, heap_calls_{0}, library_heap_calls_{0};
};

/// On the thread's own stack for as long as it runs.
class ThreadTenure {
 public:
  explicit ThreadTenure(ThreadMonitor* monitor);
  ~ThreadTenure();
  ThreadTenure(const ThreadTenure&) = delete;
  ThreadTenure& operator=(const ThreadTenure&) = delete;
  /// From now on the thread makes no heap call. May be called again.
  void seal_heap();
  /// Until seal_heap() it may: a device was opened anew.
  void unseal_heap() { seal_.reset(); }

 private:
  ThreadMonitor* monitor_;
  std::optional<HeapSeal> seal_;
};

using ThreadMonitors = std::array<ThreadMonitor, kThreadCount>;  ///< by ThreadRole

/// One piece of work with a deadline.
class WorkSpan {
 public:
  explicit WorkSpan(ThreadMonitor* monitor);
  ~WorkSpan();
  WorkSpan(const WorkSpan&) = delete;
  WorkSpan& operator=(const WorkSpan&) = delete;

 private:
  ThreadMonitor* monitor_;
  std::int64_t since_ns_ = 0;
};

}  // namespace loopsift
