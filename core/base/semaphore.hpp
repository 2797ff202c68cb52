// SPDX-License-Identifier: MIT
// A counting semaphore (POSIX, within the process): wakes a sleeping thread without a lock and without
// allocating.
#pragma once
#include <semaphore.h>

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace loopsift {

class Semaphore {
 public:
  Semaphore() { sem_init(&semaphore_, 0, 0); }
  ~Semaphore() { sem_destroy(&semaphore_); }
  Semaphore(const Semaphore&) = delete;
  Semaphore& operator=(const Semaphore&) = delete;

  void post() { sem_post(&semaphore_); }
  void wait() {
    while (sem_wait(&semaphore_) != 0 && errno == EINTR) {
    }
  }
  /// False when the steady clock (steady_now_ns) reached deadline_ns first.
  [[nodiscard]] bool wait_until(std::int64_t deadline_ns) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    const timespec deadline{static_cast<std::time_t>(deadline_ns / kSecond),
                            static_cast<long>(deadline_ns % kSecond)};
    int result = 0;
    while ((result = sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &deadline)) != 0 && errno == EINTR) {
    }
    return result == 0;
  }

 private:
  sem_t semaphore_;
};

}  // namespace loopsift
