// SPDX-License-Identifier: MIT
#include "drivers/codec/decoder_memory.hpp"

#include <memory>

namespace loopsift {

void* DecoderMemory::take(std::size_t bytes) {
  void* p = block_.data() + used_;
  std::size_t room = block_.size() - used_;
  if (std::align(kAlignment, bytes, p, room) == nullptr) return nullptr;
  used_ = block_.size() - room + bytes;
  return p;
}

}  // namespace loopsift
