// SPDX-License-Identifier: MIT
// libjpeg with a memory manager of ours, which its own (jmemmgr.c) is replaced by after it has made what a
// decoder needs for life. Working memory comes from one block and is free again after each image.
#pragma once
#include <cstdint>
#include <memory>

#include "core/base/span.hpp"
#include "core/geometry/image.hpp"

namespace loopsift {

/// One thread. Allocates when made, and never again.
class JpegDecoder {
 public:
  /// For images of up to width × height pixels, progressive ones included.
  JpegDecoder(int width, int height);
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  /// The file decoded into `image`, whose size it must have. Null, or what is wrong (static text). A damaged
  /// file that libjpeg would fill up with grey is a failure, too.
  [[nodiscard]] const char* decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopsift
