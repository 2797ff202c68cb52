// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/comparison/task_pool.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {
namespace {

// What the workers and the waiting thread share.
struct Progress {
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t done = 0;
  std::exception_ptr thrown;
};

void work(const std::vector<std::function<void()>>& tasks, std::atomic<std::size_t>* next,
          Progress* progress) {
  for (std::size_t k = (*next)++; k < tasks.size(); k = (*next)++) {
    std::exception_ptr thrown;
    try {
      tasks[k]();
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::lock_guard<std::mutex> lock(progress->mutex);
    ++progress->done;
    if (thrown && !progress->thrown) progress->thrown = thrown;
    progress->changed.notify_one();
  }
}

}  // namespace

void run_tasks(const std::string& activity, const std::vector<std::function<void()>>& tasks) {
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  std::atomic<std::size_t> next{0};
  Progress progress;
  std::vector<std::thread> workers;
  for (std::size_t k = 0; k < std::min(cores, tasks.size()); ++k)
    workers.emplace_back(work, std::cref(tasks), &next, &progress);
  {
    Ticker ticker(activity);
    std::unique_lock<std::mutex> lock(progress.mutex);
    while (progress.done < tasks.size()) {
      progress.changed.wait_for(lock, std::chrono::milliseconds(200));
      ticker.update(progress.done, tasks.size());
    }
  }
  for (std::thread& worker : workers) worker.join();
  if (progress.thrown) std::rethrow_exception(progress.thrown);
}

}  // namespace loopsift::tool
