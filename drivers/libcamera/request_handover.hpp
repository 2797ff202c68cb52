// SPDX-License-Identifier: MIT
// The way of requests from one thread to another: filled ones from libcamera's to the reader's, read ones on
// to the thread that queues them again. A ring without a lock, and a semaphore to sleep on. Bounded by the
// number of requests there are, each of which is on its way once at most. Never allocates after it is made.
#pragma once
#include <atomic>
#include <cstdint>
#include <vector>

#include "core/base/semaphore.hpp"
#include "core/base/spsc_ring.hpp"

namespace loopsift {

class RequestHandover {
 public:
  enum class Wait { kRequest, kTimeout, kEnded };

  explicit RequestHandover(std::size_t requests) : storage_(requests), ring_(storage_) {}

  /// The one thread that hands over. False when more are on their way than there are.
  [[nodiscard]] bool push(std::uint32_t request) {
    const bool pushed = ring_.try_push(request);
    changed_.post();
    return pushed;
  }
  /// Any thread: nothing more will come.
  void end() {
    ended_.store(true, std::memory_order_release);
    changed_.post();
  }
  /// The other thread: the oldest request, also after the end; waits until deadline_ns of the steady clock.
  [[nodiscard]] Wait pop(std::uint32_t* request, std::int64_t deadline_ns) {
    while (true) {
      // Looked at first: what was pushed before the end is seen by the pop after it.
      const bool over = ended_.load(std::memory_order_acquire);
      if (ring_.try_pop(request)) return Wait::kRequest;
      if (over) return Wait::kEnded;
      if (!changed_.wait_until(deadline_ns)) return Wait::kTimeout;
    }
  }

 private:
  std::vector<std::uint32_t> storage_;
  SpscRing<std::uint32_t> ring_;
  Semaphore changed_;
  std::atomic<bool> ended_{false};
};

}  // namespace loopsift
