// SPDX-License-Identifier: MIT
#include "firmware_app/thread_monitor.hpp"

#include <pthread.h>
#include <sched.h>

#include <array>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kTouchedStackBytes = std::size_t{128} * 1024;

// So that no page fault of the stack is left for the first frames.
[[gnu::noinline]] void touch_stack() {
  constexpr std::size_t kPageBytes = 4096;
  std::array<volatile char, kTouchedStackBytes> pages;
  for (std::size_t k = 0; k < pages.size(); k += kPageBytes) pages[k] = 0;
}

bool run_fifo(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

void run_on(int core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<unsigned>(core), &cores);
  (void)pthread_setaffinity_np(pthread_self(), sizeof(cores), &cores);  // a core that is not there: any
}

}  // namespace

std::int64_t ThreadMonitor::busy_ns(std::int64_t now_ns) const {
  const std::int64_t since = busy_since_ns_.load(std::memory_order_relaxed);
  return since == 0 || now_ns < since ? 0 : now_ns - since;
}

std::int64_t ThreadMonitor::heap_calls() const {
  if (!heap_is_watched() || !sealed_.load(std::memory_order_relaxed)) return -1;
  return heap_calls_.load(std::memory_order_relaxed);
}

std::int64_t ThreadMonitor::library_heap_calls() const {
  if (heap_calls() < 0) return -1;
  return library_heap_calls_.load(std::memory_order_relaxed);
}

ThreadTenure::ThreadTenure(ThreadMonitor* monitor) : monitor_(monitor) {
  if (monitor_ == nullptr) return;
  pthread_setname_np(pthread_self(), monitor_->name());
  const ThreadPlan& plan = monitor_->plan_;
  if (plan.core >= 0) run_on(plan.core);
  monitor_->realtime_ = plan.fifo_priority > 0 && run_fifo(plan.fifo_priority);
  touch_stack();
  monitor_->running_ = true;
}

ThreadTenure::~ThreadTenure() {
  if (monitor_ == nullptr) return;
  seal_.reset();
  monitor_->running_.store(false, std::memory_order_release);
}

void ThreadTenure::seal_heap() {
  if (monitor_ == nullptr || seal_) return;
  monitor_->sealed_ = true;
  seal_.emplace(&monitor_->heap_calls_, monitor_->plan_.sealed, &monitor_->library_heap_calls_);
}

WorkSpan::WorkSpan(ThreadMonitor* monitor) : monitor_(monitor) {
  if (monitor_ == nullptr) return;
  since_ns_ = steady_now_ns();
  monitor_->busy_since_ns_.store(since_ns_, std::memory_order_relaxed);
}

WorkSpan::~WorkSpan() {
  if (monitor_ == nullptr) return;
  const bool late = steady_now_ns() - since_ns_ > monitor_->plan_.deadline_ns;
  if (late && monitor_->plan_.deadline_ns > 0)
    monitor_->misses_.store(monitor_->misses_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  monitor_->busy_since_ns_.store(0, std::memory_order_relaxed);
}

}  // namespace loopsift
