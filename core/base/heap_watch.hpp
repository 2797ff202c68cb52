// SPDX-License-Identifier: MIT
// Who may use the heap, and how much of it. In: the heap calls of every thread, as the program's heap hooks
// (firmware_app/heap_hooks.cpp) report them. Out: a count per sealed thread, or the end of the process; a
// refusal to a thread that has used up its fence.
//
// - A *sealed* thread makes no heap call: each is counted, or ends the process (HeapMode).
//   A library that cannot be kept from it is called under a HeapPardon: counted apart.
// - A *fenced* thread holds at most a given number of bytes; a call past that fails as if memory had run out.
//   Library work goes through within_fence(), which turns the failure into an answer.
//
// A program without the hooks (sanitizers have their own, tests, desk tools) counts and refuses nothing.
// All of it is per thread; nothing here locks or allocates.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>

namespace loopsift {

enum class HeapMode : std::uint8_t {
  kAllow,  ///< as any thread
  kCount,  ///< each call is counted
  kAbort,  ///< the first call ends the process, naming the thread
};

/// Whether this program's heap calls are seen at all.
[[nodiscard]] bool heap_is_watched();

/// Seals the calling thread for as long as it lives. malloc, calloc, realloc, the aligned forms and free (of
/// more than null) are heap calls.
class HeapSeal {
 public:
  /// Counts into `calls`, and what was pardoned into `pardoned` (null: not counted). Both must outlive this;
  /// only the sealed thread writes them, any may read them.
  HeapSeal(std::atomic<std::int64_t>* calls, HeapMode mode, std::atomic<std::int64_t>* pardoned = nullptr);
  ~HeapSeal();
  HeapSeal(const HeapSeal&) = delete;
  HeapSeal& operator=(const HeapSeal&) = delete;
};

/// While this lives, heap calls of a sealed thread are the library's that is being called: counted apart and
/// never trapped. For libraries that take memory at every call and offer no way around it; not nested.
class HeapPardon {
 public:
  HeapPardon();
  ~HeapPardon();
  HeapPardon(const HeapPardon&) = delete;
  HeapPardon& operator=(const HeapPardon&) = delete;
};

/// How much of the heap one thread may hold, above what it held when the fence went up (giving back memory
/// from before makes room), to within what the heap rounds a block up by. Up while this lives; one at a time
/// on a thread.
class HeapFence {
 public:
  /// What a fence has seen. Written by the fenced thread, read by any.
  struct Figures {
    std::atomic<std::int64_t> used_bytes{0};
    std::atomic<std::int64_t> peak_bytes{0};
    std::atomic<std::int64_t> refusals{0};  ///< pieces of work that were refused memory
  };
  /// limit_bytes for all the thread does, library_bytes for what it does within_fence(): the smaller, so that
  /// a library that wants too much fails while our own lists still have room.
  HeapFence(std::int64_t limit_bytes, std::int64_t library_bytes, Figures* figures);
  ~HeapFence();
  HeapFence(const HeapFence&) = delete;
  HeapFence& operator=(const HeapFence&) = delete;
};

namespace heap_detail {

class LibraryScope {
 public:
  LibraryScope();
  ~LibraryScope();  // counts a refusal, if there was one
  LibraryScope(const LibraryScope&) = delete;
  LibraryScope& operator=(const LibraryScope&) = delete;

 private:
  bool outermost_;
};

// For the hooks alone. admit() is asked before a call that takes memory, `bytes` being what is asked for.
void set_watched();
[[nodiscard]] bool admit(const char* call, std::size_t bytes);
void note_release(const char* call);
void note_bytes(std::int64_t gained);

}  // namespace heap_detail

/// Runs work() with the library's limit of the thread's fence, if there is one. False when memory ran out
/// (std::bad_alloc); what work() had built is gone by then, what it had changed must be fit to go on with.
template <class Work>
[[nodiscard]] bool within_fence(Work&& work) {
  const heap_detail::LibraryScope scope;
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

}  // namespace loopsift
