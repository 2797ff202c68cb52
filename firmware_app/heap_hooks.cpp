// SPDX-License-Identifier: MIT
// The C library's heap functions, with a word to heap_watch before each. Part of a program only as one of its
// own object files, and never together with a sanitizer, which has hooks of its own. The real work is glibc's
// (its __libc_ names). Thread: all. No locks.
#include <malloc.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>

#include "core/base/heap_watch.hpp"

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): glibc's names
extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* p, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* p);
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)
// NOLINTBEGIN(cppcoreguidelines-no-malloc): this is what it is all about

namespace {

using loopsift::heap_detail::admit;
using loopsift::heap_detail::note_bytes;
using loopsift::heap_detail::note_release;

[[gnu::constructor]] void install() { loopsift::heap_detail::set_watched(); }

std::int64_t size_of(void* p) { return static_cast<std::int64_t>(malloc_usable_size(p)); }

void* refuse() {
  errno = ENOMEM;
  return nullptr;
}

void* taken(void* p) {
  if (p != nullptr) note_bytes(size_of(p));
  return p;
}

void* take_aligned(const char* call, std::size_t alignment, std::size_t bytes) {
  return admit(call, bytes) ? taken(__libc_memalign(alignment, bytes)) : refuse();
}

bool is_power_of_two(std::size_t n) { return n != 0 && (n & (n - 1)) == 0; }

}  // namespace

extern "C" {

void* malloc(std::size_t bytes) noexcept {
  return admit("malloc", bytes) ? taken(__libc_malloc(bytes)) : refuse();
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  std::size_t all = 0;
  if (__builtin_mul_overflow(count, bytes, &all)) return refuse();
  return admit("calloc", all) ? taken(__libc_calloc(count, bytes)) : refuse();
}

void* realloc(void* p, std::size_t bytes) noexcept {
  if (p == nullptr) return malloc(bytes);
  const std::int64_t before = size_of(p);
  const auto had = static_cast<std::size_t>(before);
  if (!admit("realloc", bytes > had ? bytes - had : 0)) return refuse();
  void* moved = __libc_realloc(p, bytes);
  if (moved != nullptr) {
    note_bytes(size_of(moved) - before);
  } else if (bytes == 0) {
    note_bytes(-before);  // glibc frees it
  }
  return moved;
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  return take_aligned("memalign", alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  return take_aligned("aligned_alloc", alignment, bytes);
}

int posix_memalign(void** out, std::size_t alignment, std::size_t bytes) noexcept {
  if (!is_power_of_two(alignment) || alignment % sizeof(void*) != 0) return EINVAL;
  void* p = take_aligned("posix_memalign", alignment, bytes);
  if (p == nullptr) return ENOMEM;
  *out = p;
  return 0;
}

void free(void* p) noexcept {
  if (p == nullptr) return;
  note_release("free");
  note_bytes(-size_of(p));
  __libc_free(p);
}

}  // extern "C"
// NOLINTEND(cppcoreguidelines-no-malloc)
