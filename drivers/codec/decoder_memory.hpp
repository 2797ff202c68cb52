// SPDX-License-Identifier: MIT
// Memory for an image library that would otherwise take it from the heap, frame by frame: handed out in order
// and taken back all at once. One thread. Allocates when made, and never again.
#pragma once
#include <cstddef>
#include <vector>

namespace loopsift {

class DecoderMemory {
 public:
  explicit DecoderMemory(std::size_t bytes) : block_(bytes + kAlignment) {}

  /// 64-byte aligned; null when it is used up.
  [[nodiscard]] void* take(std::size_t bytes);
  /// Everything taken since the mark (see mark()) is free again.
  void back_to_mark() { used_ = mark_; }
  /// What is taken now stays taken.
  void mark() { mark_ = used_; }

 private:
  static constexpr std::size_t kAlignment = 64;
  std::vector<std::byte> block_;
  std::size_t used_ = 0, mark_ = 0;
};

}  // namespace loopsift
