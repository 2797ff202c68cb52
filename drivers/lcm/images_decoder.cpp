// SPDX-License-Identifier: MIT
#include "drivers/lcm/images_decoder.hpp"

#include <bot_core/image_t.hpp>
#include <cstring>

#include "drivers/codec/pixel_rows.hpp"

namespace loopsift {
namespace {

using bot_core::image_t;

constexpr const char* kOtherSize = "the image has another size than when the source was opened";
constexpr const char* kTooFewBytes = "the image has fewer bytes than its size says";

/// Whether `image.height` rows of `row_bytes` are there. A stride of 0 is taken to mean none.
bool holds_rows(const EncodedImage& image, std::size_t row_bytes, std::size_t* stride) {
  *stride = image.row_stride > 0 ? static_cast<std::size_t>(image.row_stride) : row_bytes;
  const auto rows = static_cast<std::size_t>(image.height);
  return *stride >= row_bytes && image.data.size() >= (rows - 1) * *stride + row_bytes;
}

}  // namespace

const char* ImagesDecoder::decode_depth(const ImagesMessage& message, const ImageView<std::uint16_t>& image) {
  const EncodedImage& encoded = message.depth;
  if (encoded.width != image.width || encoded.height != image.height) return kOtherSize;
  const std::size_t row_bytes = 2 * static_cast<std::size_t>(image.width);
  if (message.depth_zipped) {
    inflater_.begin({reinterpret_cast<std::uint8_t*>(image.data), 2 * image.size()});
    const bool whole = inflater_.feed(encoded.data) && inflater_.finished();
    return whole ? nullptr : "the depth image is corrupt, or of another size than it says";
  }
  std::size_t stride = 0;
  if (!holds_rows(encoded, row_bytes, &stride)) return kTooFewBytes;
  for (int y = 0; y < image.height; ++y)
    std::memcpy(image.row(y), encoded.data.data() + static_cast<std::size_t>(y) * stride, row_bytes);
  return nullptr;
}

const char* ImagesDecoder::decode_color(const EncodedImage& encoded, const ImageView<Rgb8>& image) {
  if (encoded.width != image.width || encoded.height != image.height) return kOtherSize;
  if (encoded.format == image_t::PIXEL_FORMAT_MJPEG) return jpeg_.decode(encoded.data, image);
  const bool grey = encoded.format == image_t::PIXEL_FORMAT_GRAY;
  if (!grey && encoded.format != image_t::PIXEL_FORMAT_RGB)
    return "colour in a format other than RGB, GRAY, MJPEG";
  std::size_t stride = 0;
  if (!holds_rows(encoded, static_cast<std::size_t>(image.width) * (grey ? 1 : 3), &stride))
    return kTooFewBytes;
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* row = encoded.data.data() + static_cast<std::size_t>(y) * stride;
    grey ? grey_to_rgb(row, image.width, image.row(y)) : rgb_to_rgb(row, image.width, image.row(y));
  }
  return nullptr;
}

}  // namespace loopsift
