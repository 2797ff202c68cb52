// SPDX-License-Identifier: MIT
#include "firmware_app/realtime.hpp"

#include <link.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <vector>

namespace loopsift {
namespace {

// Whether SCHED_FIFO is to be had; the calling thread is as before when it returns.
bool may_run_fifo() {
  sched_param before{}, fifo{};
  int policy = SCHED_OTHER;
  pthread_getschedparam(pthread_self(), &policy, &before);
  fifo.sched_priority = 1;
  if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo) != 0) return false;
  pthread_setschedparam(pthread_self(), policy, &before);
  return true;
}

// Pages are locked as they are used: the arena is touched anyway, and of the libraries most is never needed.
bool lock_memory() { return mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0; }

// Of the first object, which is the program: a byte of each page of its code.
int read_code(dl_phdr_info* object, std::size_t /*size*/, void* sum) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (int k = 0; k < object->dlpi_phnum; ++k) {
    const auto& segment = object->dlpi_phdr[k];
    if (segment.p_type != PT_LOAD || (segment.p_flags & PF_X) == 0) continue;
    const auto* code = reinterpret_cast<const volatile unsigned char*>(object->dlpi_addr + segment.p_vaddr);
    for (std::size_t at = 0; at < segment.p_memsz; at += page) *static_cast<unsigned*>(sum) += code[at];
  }
  return 1;  // no further object
}

std::int64_t nanoseconds(double milliseconds) { return std::llround(milliseconds * 1e6); }

#ifdef LOOPSIFT_HEAP_TRAP
constexpr HeapMode kSealed = HeapMode::kAbort;
#else
constexpr HeapMode kSealed = HeapMode::kCount;
#endif

}  // namespace

RealtimeRights prepare_realtime(const ThreadSettings& settings, bool live) {
  RealtimeRights rights;
  const bool wants_fifo = settings.realtime && live;
  rights.scheduling = wants_fifo && may_run_fifo();
  rights.memory_locked = settings.lock_memory && lock_memory();
  const bool no_fifo = wants_fifo && !rights.scheduling;
  const bool no_lock = settings.lock_memory && !rights.memory_locked;
  if (no_fifo || no_lock) {
    rights.warning =
        std::string("running without ") + (no_fifo ? "real-time scheduling" : "") +
        (no_fifo && no_lock ? " and " : "") + (no_lock ? "locked memory" : "") +
        ": no right to it; frames may come late on a busy computer. Allow it with LimitRTPRIO= and "
        "LimitMEMLOCK= in the service, or rtprio and memlock in /etc/security/limits.d; or set "
        "threads.realtime and threads.lock_memory to false";
  }
  return rights;
}

std::array<ThreadPlan, kThreadCount> thread_plans(const Settings& settings, const RealtimeRights& rights) {
  const ThreadSettings& t = settings.threads;
  const WatchdogSettings& w = settings.watchdog;
  const auto fifo = [&](int priority) { return rights.scheduling ? priority : 0; };
  return {{{fifo(t.capture_priority), t.capture_core, nanoseconds(w.capture_deadline_ms), kSealed},
           {fifo(t.front_priority), t.front_core, nanoseconds(w.front_deadline_ms), kSealed},
           {0, t.back_core, nanoseconds(w.back_deadline_ms), HeapMode::kAllow},
           {fifo(t.publish_priority), t.publish_core, nanoseconds(w.publish_deadline_ms), kSealed}}};
}

void limit_stacks() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kStackBytes);
  pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

void load_program_code() {
  unsigned sum = 0;
  dl_iterate_phdr(&read_code, &sum);
}

void warm_heap(std::size_t bytes) {
  constexpr int kNeverTrim = 0x7fffffff;
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, kNeverTrim);
  constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
  std::vector<std::unique_ptr<char[]>> blocks;
  for (std::size_t taken = 0; taken < bytes; taken += kBlockBytes) {
    blocks.push_back(std::make_unique<char[]>(kBlockBytes));  // zeroed, hence touched
  }
}

std::int64_t resident_bytes() {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen("/proc/self/statm", "r"),
                                                             &std::fclose);
  long long total = 0, resident = 0;
  if (!file || std::fscanf(file.get(), "%lld %lld", &total, &resident) != 2) return 0;
  return resident * sysconf(_SC_PAGESIZE);
}

}  // namespace loopsift
