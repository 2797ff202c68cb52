// SPDX-License-Identifier: MIT
// Image files of recordings: 16-bit grey PNG for depth, 8-bit PNG or JPEG for colour. Decoded straight into
// the caller's buffers.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/span.hpp"
#include "core/geometry/image.hpp"
#include "drivers/replay/color_image.hpp"
#include "drivers/replay/png16.hpp"

namespace loopsift {

struct ImageSize {
  int width = 0;
  int height = 0;
};

/// Reads and decodes image files. One thread. All memory is taken in the constructor.
class ImageReader {
 public:
  /// For depth images of up to `depth` and colour images of up to `color` pixels (0 × 0: none).
  ImageReader(ImageSize depth, ImageSize color);

  /// The file decoded into `image`, whose size it must have. Null, or what is wrong (static text, without the
  /// name).
  [[nodiscard]] const char* read_depth(const std::string& path, const ImageView<std::uint16_t>& image);
  [[nodiscard]] const char* read_color(const std::string& path, const ImageView<Rgb8>& image);
  /// A colour image that is in memory already.
  [[nodiscard]] const char* decode_color(Span<const std::uint8_t> file, const ImageView<Rgb8>& image) {
    return color_.decode(file, image);
  }

 private:
  [[nodiscard]] const char* load(const std::string& path, Span<const std::uint8_t>* file);

  Png16Decoder png16_;
  std::vector<std::uint8_t> file_;  // the last file's bytes
  ColorDecoder color_;
};

/// Width and height from the head of a PNG or JPEG file; set-up only. Errors name the file.
[[nodiscard]] Expected<ImageSize> read_image_size(const std::string& path);
/// The same for a JPEG in memory; 0 × 0 if it is none, or beyond kLargestSide.
[[nodiscard]] ImageSize jpeg_size(Span<const std::uint8_t> file);

/// Writers, for sequences that we make ourselves; they allocate. Errors name the file. (16-bit: png16.hpp.)
[[nodiscard]] Status write_png_rgb(const std::string& path, const ImageView<const Rgb8>& image);
/// quality 1…100.
[[nodiscard]] Status write_jpeg(const std::string& path, const ImageView<const Rgb8>& image, int quality);
[[nodiscard]] Expected<std::vector<std::uint8_t>> encode_jpeg(const ImageView<const Rgb8>& image,
                                                              int quality);

}  // namespace loopsift
