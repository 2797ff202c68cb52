// SPDX-License-Identifier: MIT
// Colour images, PNG or JPEG, from memory into the caller's buffer. The libraries get their working memory
// from blocks that are taken once, so that decoding makes no heap call.
#pragma once
#include <cstdint>
#include <memory>

#include "core/base/span.hpp"
#include "core/geometry/image.hpp"

namespace loopsift {

[[nodiscard]] bool is_png(Span<const std::uint8_t> file);
[[nodiscard]] bool is_jpeg(Span<const std::uint8_t> file);

/// One thread.
class ColorDecoder {
 public:
  /// For images of up to width × height pixels; with 0 × 0 it holds no memory and decodes nothing.
  ColorDecoder(int width, int height);
  ~ColorDecoder();
  ColorDecoder(const ColorDecoder&) = delete;
  ColorDecoder& operator=(const ColorDecoder&) = delete;

  /// The file decoded into `image`, whose size it must have. Null, or what is wrong (static text).
  [[nodiscard]] const char* decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image);

 private:
  struct Jpeg;
  struct Png;
  std::unique_ptr<Jpeg> jpeg_;
  std::unique_ptr<Png> png_;
};

}  // namespace loopsift
