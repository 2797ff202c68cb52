// SPDX-License-Identifier: MIT
// make_corpus DIR: what the fuzzers start from, a folder for each: a few frames of a rendered room in every
// form that the parsers read.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>

#include "drivers/replay/image_file.hpp"
#include "drivers/synth/synth_source.hpp"
#include "tests/fuzz/image_size.hpp"
#include "tests/support/lcm_images.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift {
namespace {

struct Frame {
  test::DepthImage depth{fuzz::kWidth, fuzz::kHeight};
  test::ColorImage color{fuzz::kWidth, fuzz::kHeight};
};

std::vector<Frame> render() {
  const auto source = open_synth(
      "room?frames=3&width=" + std::to_string(fuzz::kWidth) + "&height=" + std::to_string(fuzz::kHeight), {});
  std::vector<Frame> frames;
  if (!source.ok()) return frames;
  for (Frame frame;;) {
    RawFrame raw;
    raw.depth_buffer = frame.depth.pixels;
    raw.color_buffer = frame.color.pixels;
    if ((*source)->read(raw, 0) != ReadStatus::kFrame) return frames;
    frames.push_back(frame);
  }
}

std::string folder(const std::string& parent, const std::string& name) {
  std::filesystem::create_directories(parent + "/" + name);
  return parent + "/" + name + "/";
}

void write_bytes(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void write_klg(const std::string& to, const std::vector<Frame>& frames) {
  std::vector<test::KlgFrame> packed, raw;
  for (const Frame& frame : frames) {
    const auto time_us = static_cast<std::int64_t>(packed.size() + 1) * 33333;
    packed.push_back({time_us, test::zlib_bytes(frame.depth), test::jpeg_bytes(frame.color)});
    raw.push_back({time_us, test::raw_bytes(frame.depth), test::raw_bytes(frame.color)});
  }
  test::write_klg(to + "packed.klg", packed);
  packed[0].timestamp_us = std::numeric_limits<std::int64_t>::min();
  test::write_klg(to + "early.klg", packed);
  test::write_klg(to + "raw.klg", raw);
}

// Depth raw and packed; colour raw, grey and as JPEG.
void write_images(const std::string& to, const Frame& frame) {
  for (const bool zipped : {false, true}) {
    bot_core::images_t message = test::images(7, fuzz::kWidth, fuzz::kHeight, 1000, zipped);
    const std::string name = to + (zipped ? "zipped" : "raw");
    write_bytes(name, test::encode(message));
    bot_core::image_t& color = message.images[0];
    color.row_stride = fuzz::kWidth;
    color.pixelformat = bot_core::image_t::PIXEL_FORMAT_GRAY;
    color.data.assign(static_cast<std::size_t>(fuzz::kWidth) * fuzz::kHeight, 100);
    color.size = static_cast<std::int32_t>(color.data.size());
    write_bytes(name + "_grey", test::encode(message));
    color.pixelformat = bot_core::image_t::PIXEL_FORMAT_MJPEG;
    color.data = test::jpeg_bytes(frame.color);
    color.size = static_cast<std::int32_t>(color.data.size());
    write_bytes(name + "_jpeg", test::encode(message));
  }
}

void write_all(const std::string& to, const std::vector<Frame>& frames) {
  write_klg(folder(to, "fuzz_klg"), frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string number = std::to_string(i);
    test::write_depth(folder(to, "fuzz_png16") + number + ".png", frames[i].depth);
    test::write_color_png(folder(to, "fuzz_color") + number + ".png", frames[i].color);
    test::write_color_jpeg(folder(to, "fuzz_color") + number + ".jpg", frames[i].color);
  }
  write_images(folder(to, "fuzz_images"), frames.front());
}

}  // namespace
}  // namespace loopsift

int main(int argc, char** argv) {
  const auto frames = loopsift::render();
  if (argc != 2 || frames.empty()) {
    std::fprintf(stderr, "usage: make_corpus DIR\n");
    return 2;
  }
  loopsift::write_all(argv[1], frames);
  return 0;
}
