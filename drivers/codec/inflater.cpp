// SPDX-License-Identifier: MIT
#include "drivers/codec/inflater.hpp"

namespace loopsift {

void* Inflater::take(void* self, unsigned count, unsigned size) {
  auto* inflater = static_cast<Inflater*>(self);
  const std::size_t bytes = (std::size_t{count} * size + 63) / 64 * 64;
  if (inflater->used_ + bytes > kMemoryBytes) return nullptr;
  void* p = inflater->memory_.data() + inflater->used_;
  inflater->used_ += bytes;
  return p;
}

Inflater::Inflater(bool verify_checksum) {
  stream_.zalloc = &Inflater::take;
  stream_.zfree = [](void*, void*) {};
  stream_.opaque = this;
  inflateInit(&stream_);
  inflateValidate(&stream_, verify_checksum ? 1 : 0);
}

void Inflater::begin(Span<std::uint8_t> output) {
  inflateReset(&stream_);
  stream_.next_out = output.data();
  stream_.avail_out = static_cast<unsigned>(output.size());
  ended_ = false;
}

bool Inflater::feed(Span<const std::uint8_t> piece) {
  stream_.next_in = const_cast<std::uint8_t*>(piece.data());  // zlib's interface predates const
  stream_.avail_in = static_cast<unsigned>(piece.size());
  while (stream_.avail_in > 0 && !ended_) {
    const int result = inflate(&stream_, Z_NO_FLUSH);
    ended_ = result == Z_STREAM_END;
    if (result != Z_OK && !ended_) return false;
  }
  return true;
}

}  // namespace loopsift
