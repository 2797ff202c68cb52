// SPDX-License-Identifier: MIT
// The images of bot_core.images_t as pixels. One thread; allocates when made, and never again.
#pragma once
#include "core/geometry/image.hpp"
#include "drivers/codec/inflater.hpp"
#include "drivers/codec/jpeg_decoder.hpp"
#include "drivers/lcm/images_message.hpp"

namespace loopsift {

class ImagesDecoder {
 public:
  /// For colour images of up to this size.
  ImagesDecoder(int color_width, int color_height) : jpeg_(color_width, color_height) {}

  // Each writes the whole of `image`, whose size it must be. Null, or what is wrong (static text).
  /// Raw or zipped, little-endian, millimetres.
  [[nodiscard]] const char* decode_depth(const ImagesMessage& message, const ImageView<std::uint16_t>& image);
  /// RGB, grey or JPEG.
  [[nodiscard]] const char* decode_color(const EncodedImage& encoded, const ImageView<Rgb8>& image);

 private:
  Inflater inflater_{true};
  JpegDecoder jpeg_;
};

}  // namespace loopsift
