// SPDX-License-Identifier: MIT
// Any bytes as a 16-bit PNG of depth.
#include "drivers/replay/png16.hpp"
#include "tests/fuzz/image_size.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopsift;
  static Png16Decoder decoder;
  static std::vector<std::uint16_t> pixels;
  if (pixels.empty()) {
    decoder.reserve(fuzz::kWidth, fuzz::kHeight);
    pixels.resize(static_cast<std::size_t>(fuzz::kWidth) * fuzz::kHeight);
  }
  (void)decoder.decode({data, size}, {pixels.data(), fuzz::kWidth, fuzz::kHeight});
  return 0;
}
