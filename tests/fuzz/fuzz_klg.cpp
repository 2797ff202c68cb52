// SPDX-License-Identifier: MIT
// Any bytes as a .klg recording: opened and read to its end.
#include <vector>

#include "drivers/replay/klg_source.hpp"
#include "tests/fuzz/image_size.hpp"
#include "tests/fuzz/input_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopsift;
  const fuzz::InputFile file(data, size);
  SourceOptions options;
  options.camera.width = fuzz::kWidth;
  options.camera.height = fuzz::kHeight;
  const auto source = KlgSource::open(file.path(), options);
  if (!source.ok()) return 0;
  const SourceInfo& info = (*source)->info();
  std::vector<std::uint16_t> depth(static_cast<std::size_t>(info.camera.width * info.camera.height));
  std::vector<Rgb8> color(static_cast<std::size_t>(info.color_width) *
                          static_cast<std::size_t>(info.color_height));
  RawFrame frame;
  frame.depth_buffer = depth;
  frame.color_buffer = color;
  constexpr int kFrames = 64;
  for (int i = 0; i < kFrames && (*source)->read(frame, 0) != ReadStatus::kEnd; ++i) {
  }
  return 0;
}
