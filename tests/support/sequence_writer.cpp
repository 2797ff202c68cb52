// SPDX-License-Identifier: MIT
#include "tests/support/sequence_writer.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "drivers/replay/image_file.hpp"

namespace loopsift::test {
namespace {

void require(const Status& status) {
  if (!status) throw std::runtime_error(status.error().message);
}

template <class T>
std::vector<std::uint8_t> bytes_of(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

template <class T>
void put(std::ofstream& file, const T& value) {
  file.write(reinterpret_cast<const char*>(&value), sizeof(value));
}

void put(std::ofstream& file, const std::vector<std::uint8_t>& bytes) {
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

DepthImage make_depth(int width, int height, int seed) {
  DepthImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int step = (x / 7 + y / 5 + seed) % 3 * 700;
      image.view()(x, y) = static_cast<std::uint16_t>(800 + 13 * seed + 3 * x + 5 * y + step);
    }
  }
  image.view()(seed % width, 0) = 0;
  image.view()(0, seed % height) = 65535;
  return image;
}

ColorImage make_color(int width, int height, int seed) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.view()(x, y) = {static_cast<unsigned char>(40 + 100 * x / width + seed % 50),
                            static_cast<unsigned char>(60 + 100 * y / height),
                            static_cast<unsigned char>(200 - 100 * x / width)};
    }
  }
  return image;
}

bool equal(const ImageView<const std::uint16_t>& a, const ImageView<const std::uint16_t>& b) {
  if (a.width != b.width || a.height != b.height) return false;
  for (int y = 0; y < a.height; ++y) {
    if (!std::equal(a.row(y), a.row(y) + a.width, b.row(y))) return false;
  }
  return true;
}

int largest_difference(const ImageView<const Rgb8>& a, const ImageView<const Rgb8>& b) {
  if (a.width != b.width || a.height != b.height) return 256;
  int largest = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const Rgb8 p = a(x, y), q = b(x, y);
      largest = std::max({largest, std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
    }
  }
  return largest;
}

void write_depth(const std::string& path, const DepthImage& image) {
  require(write_png16(path, image.view()));
}
void write_color_jpeg(const std::string& path, const ColorImage& image) {
  require(write_jpeg(path, image.view(), 95));
}
void write_color_png(const std::string& path, const ColorImage& image) {
  require(write_png_rgb(path, image.view()));
}

void truncate_file(const std::string& path, double fraction) {
  const auto size = static_cast<double>(std::filesystem::file_size(path));
  std::filesystem::resize_file(path, static_cast<std::uintmax_t>(size * fraction));
}

std::vector<std::uint8_t> raw_bytes(const DepthImage& image) { return bytes_of(image.pixels); }
std::vector<std::uint8_t> raw_bytes(const ColorImage& image) { return bytes_of(image.pixels); }

std::vector<std::uint8_t> zlib_bytes(const DepthImage& image) {
  const std::vector<std::uint8_t> raw = raw_bytes(image);
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  std::vector<std::uint8_t> compressed(size);
  if (compress(compressed.data(), &size, raw.data(), static_cast<uLong>(raw.size())) != Z_OK) {
    throw std::runtime_error("zlib cannot compress the depth image");
  }
  compressed.resize(size);
  return compressed;
}

std::vector<std::uint8_t> jpeg_bytes(const ColorImage& image) {
  const auto jpeg = encode_jpeg(image.view(), 95);
  if (!jpeg) throw std::runtime_error(jpeg.error().message);
  return *jpeg;
}

std::vector<std::uint8_t> claim_jpeg_size(std::vector<std::uint8_t> jpeg, int width, int height) {
  for (std::size_t k = 0; k + 8 < jpeg.size(); ++k) {
    if (jpeg[k] != 0xFF || jpeg[k + 1] != 0xC0) continue;  // start of frame: length, bits, height, width
    for (int i = 0; i < 2; ++i) {
      jpeg[k + 5 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(height >> (8 - 8 * i));
      jpeg[k + 7 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(width >> (8 - 8 * i));
    }
    return jpeg;
  }
  throw std::runtime_error("the JPEG has no head");
}

void write_klg(const std::string& path, const std::vector<KlgFrame>& frames) {
  std::ofstream file(path, std::ios::binary);
  put(file, static_cast<std::int32_t>(frames.size()));
  for (const KlgFrame& frame : frames) {
    put(file, frame.timestamp_us);
    put(file, static_cast<std::int32_t>(frame.depth.size()));
    put(file, static_cast<std::int32_t>(frame.image.size()));
    put(file, frame.depth);
    put(file, frame.image);
  }
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

FrameBuffers::FrameBuffers(const SourceInfo& info)
    : depth_(static_cast<std::size_t>(info.camera.width) * static_cast<std::size_t>(info.camera.height)),
      color_(static_cast<std::size_t>(info.color_width) * static_cast<std::size_t>(info.color_height)) {
  frame.depth_buffer = depth_;
  frame.color_buffer = color_;
}

}  // namespace loopsift::test
