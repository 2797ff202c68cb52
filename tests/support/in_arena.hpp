// SPDX-License-Identifier: MIT
// A part that carves its stores, in an arena of exactly the size that it measures.
#pragma once
#include <cstddef>
#include <memory>

#include "core/base/arena.hpp"

namespace loopsift::test {

template <class Part>
class InArena {
 public:
  /// Part's constructor takes these arguments and then the arena.
  template <class... Arguments>
  explicit InArena(const Arguments&... arguments) {
    Arena measuring;
    { const Part unused(arguments..., measuring); }
    measured_bytes_ = measuring.used_bytes();
    arena_ = std::make_unique<Arena>(measured_bytes_);
    part_ = std::make_unique<Part>(arguments..., *arena_);
  }
  [[nodiscard]] std::size_t measured_bytes() const { return measured_bytes_; }
  [[nodiscard]] std::size_t carved_bytes() const { return arena_->used_bytes(); }
  Part& operator*() const { return *part_; }
  Part* operator->() const { return part_.get(); }

 private:
  std::size_t measured_bytes_ = 0;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<Part> part_;
};

}  // namespace loopsift::test
