// SPDX-License-Identifier: MIT
#include "core/base/arena.hpp"

#include <sys/mman.h>

#include <cassert>
#include <cstring>
#include <new>

namespace loopsift {
namespace {
constexpr std::size_t kAlignment = 64;  // a cache line, and the widest vector register
}

Arena::Arena(std::size_t bytes) : capacity_(bytes) {
  const std::size_t reserved = bytes > 0 ? bytes : kAlignment;
  void* p =
      mmap(nullptr, reserved, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (p == MAP_FAILED) throw std::bad_alloc();
  std::memset(p, 0, reserved);  // touched, so that no page fault is left for the frame path
  locked_ = mlock(p, reserved) == 0;
  block_ = static_cast<std::byte*>(p);
}

Arena::~Arena() {
  if (block_ != nullptr) munmap(block_, capacity_ > 0 ? capacity_ : kAlignment);
}

void* Arena::take(const std::string& owner, std::size_t count, std::size_t bytes) {
  const std::size_t rounded = (bytes + kAlignment - 1) / kAlignment * kAlignment;
  if (measuring()) {
    budget_.add(owner, count, rounded);
    used_ += rounded;
    return nullptr;
  }
  assert(used_ + rounded <= capacity_ && "a part carves more than it did on the measuring arena");
  if (used_ + rounded > capacity_) throw std::bad_alloc();
  budget_.add(owner, count, rounded);
  void* p = block_ + used_;
  used_ += rounded;
  return p;
}

}  // namespace loopsift
