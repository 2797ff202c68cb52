// SPDX-License-Identifier: MIT
#include "core/base/heap_watch.hpp"

#include <pthread.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace loopsift {
namespace {

using Counter = std::atomic<std::int64_t>;

// Trivial, so that it is there before any constructor and needs no heap of its own.
struct ThreadHeap {
  HeapMode mode;
  Counter *calls, *pardoned_calls;
  HeapFence::Figures* fence;
  std::int64_t limit_bytes, library_bytes;
  std::int64_t used_bytes, peak_bytes;
  bool pardoned, in_library, refused;
};
thread_local ThreadHeap heap = {HeapMode::kAllow, nullptr, nullptr, nullptr, 0, 0, 0, 0, false, false, false};

std::atomic<bool> watched{false};

// One thread writes: no need for an atomic addition.
void add(Counter* counter, std::int64_t amount) {
  counter->store(counter->load(std::memory_order_relaxed) + amount, std::memory_order_relaxed);
}

[[noreturn]] void trap(const char* call) {
  heap.mode = HeapMode::kAllow;
  char thread[16] = "?";
  pthread_getname_np(pthread_self(), thread, sizeof(thread));
  for (const char* part :
       {"loopsift: ", call, " in the sealed thread ", static_cast<const char*>(thread), "\n"})
    (void)!write(STDERR_FILENO, part, std::strlen(part));
  std::abort();
}

void note_call(const char* call) {
  if (heap.mode == HeapMode::kAllow) return;
  if (heap.pardoned) {
    if (heap.pardoned_calls != nullptr) add(heap.pardoned_calls, 1);
    return;
  }
  if (heap.mode == HeapMode::kAbort) trap(call);
  add(heap.calls, 1);
}

}  // namespace

bool heap_is_watched() { return watched.load(std::memory_order_relaxed); }

HeapSeal::HeapSeal(std::atomic<std::int64_t>* calls, HeapMode mode, std::atomic<std::int64_t>* pardoned) {
  heap.calls = calls;
  heap.pardoned_calls = pardoned;
  heap.mode = mode;
}
HeapSeal::~HeapSeal() { heap.mode = HeapMode::kAllow; }

HeapPardon::HeapPardon() { heap.pardoned = true; }
HeapPardon::~HeapPardon() { heap.pardoned = false; }

HeapFence::HeapFence(std::int64_t limit_bytes, std::int64_t library_bytes, Figures* figures) {
  heap.fence = figures;
  heap.limit_bytes = limit_bytes;
  heap.library_bytes = library_bytes;
  heap.used_bytes = heap.peak_bytes = 0;
}
HeapFence::~HeapFence() { heap.fence = nullptr; }

namespace heap_detail {

LibraryScope::LibraryScope() : outermost_(!heap.in_library) {
  if (!outermost_) return;
  heap.in_library = true;
  heap.refused = false;
}
LibraryScope::~LibraryScope() {
  if (!outermost_) return;
  heap.in_library = false;
  if (heap.refused && heap.fence != nullptr) add(&heap.fence->refusals, 1);
  heap.refused = false;
}

void set_watched() { watched = true; }

bool admit(const char* call, std::size_t bytes) {
  note_call(call);
  if (heap.fence == nullptr) return true;
  const std::int64_t limit = heap.in_library ? heap.library_bytes : heap.limit_bytes;
  if (bytes <= static_cast<std::size_t>(PTRDIFF_MAX) &&
      heap.used_bytes + static_cast<std::int64_t>(bytes) <= limit)
    return true;
  if (heap.in_library) {
    heap.refused = true;
  } else {
    add(&heap.fence->refusals, 1);
  }
  return false;
}

void note_release(const char* call) { note_call(call); }

void note_bytes(std::int64_t gained) {
  if (heap.fence == nullptr) return;
  heap.used_bytes += gained;
  heap.fence->used_bytes.store(heap.used_bytes, std::memory_order_relaxed);
  if (heap.used_bytes <= heap.peak_bytes) return;
  heap.peak_bytes = heap.used_bytes;
  heap.fence->peak_bytes.store(heap.peak_bytes, std::memory_order_relaxed);
}

}  // namespace heap_detail
}  // namespace loopsift
