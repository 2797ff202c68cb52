// SPDX-License-Identifier: MIT
// Any bytes as a bot_core.images_t: parsed, its images decoded.
#include <vector>

#include "drivers/lcm/images_decoder.hpp"
#include "drivers/lcm/images_message.hpp"
#include "tests/fuzz/image_size.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopsift;
  static ImagesDecoder decoder(fuzz::kWidth, fuzz::kHeight);
  static std::vector<std::uint16_t> depth(static_cast<std::size_t>(fuzz::kWidth) * fuzz::kHeight);
  static std::vector<Rgb8> color(depth.size());
  ImagesMessage message;
  if (parse_images({data, size}, &message) != nullptr) return 0;
  if (message.depth.width == fuzz::kWidth && message.depth.height == fuzz::kHeight)
    (void)decoder.decode_depth(message, {depth.data(), fuzz::kWidth, fuzz::kHeight});
  if (message.color.width == fuzz::kWidth && message.color.height == fuzz::kHeight)
    (void)decoder.decode_color(message.color, {color.data(), fuzz::kWidth, fuzz::kHeight});
  return 0;
}
