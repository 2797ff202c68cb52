// SPDX-License-Identifier: MIT
// Any bytes as a PNG or JPEG of colour.
#include <vector>

#include "drivers/replay/image_file.hpp"
#include "tests/fuzz/image_size.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopsift;
  static ColorDecoder decoder(fuzz::kWidth, fuzz::kHeight);
  static std::vector<Rgb8> pixels(static_cast<std::size_t>(fuzz::kWidth) * fuzz::kHeight);
  (void)jpeg_size({data, size});
  (void)decoder.decode({data, size}, {pixels.data(), fuzz::kWidth, fuzz::kHeight});
  return 0;
}
