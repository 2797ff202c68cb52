// SPDX-License-Identifier: MIT
// zlib streams inflated into a caller's buffer, again and again, without a heap call: zlib's own state and
// window live inside the object.
#pragma once
#include <zlib.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/span.hpp"

namespace loopsift {

/// One stream at a time: begin(), feed() its pieces in order, finished(). One thread.
class Inflater {
 public:
  /// verify_checksum: false where the container has a checksum of its own (PNG).
  explicit Inflater(bool verify_checksum);
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// The next stream goes to `output`.
  void begin(Span<std::uint8_t> output);
  /// False when the stream is corrupt or holds more than `output` takes.
  [[nodiscard]] bool feed(Span<const std::uint8_t> piece);
  /// The stream came to its end, and filled `output` exactly.
  [[nodiscard]] bool finished() const { return ended_ && stream_.avail_out == 0; }

 private:
  static void* take(void* self, unsigned count, unsigned size);

  // zlib takes its state (7 KiB) once and its window (32 KiB) at most once.
  static constexpr std::size_t kMemoryBytes = std::size_t{64} * 1024;
  alignas(64) std::array<std::byte, kMemoryBytes> memory_;
  std::size_t used_ = 0;
  z_stream stream_{};
  bool ended_ = false;
};

}  // namespace loopsift
