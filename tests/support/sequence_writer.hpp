// SPDX-License-Identifier: MIT
// Small recordings on disk for tests, in every format that the replay driver reads, and what frames they
// hold.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/image.hpp"
#include "core/geometry/raw_frame.hpp"
#include "drivers/frame_source.hpp"

namespace loopsift::test {

/// An image that owns its pixels.
template <class T>
struct OwnedImage {
  int width = 0, height = 0;
  std::vector<T> pixels;
  OwnedImage(int w, int h)
      : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  [[nodiscard]] ImageView<T> view() { return {pixels.data(), width, height}; }
  [[nodiscard]] ImageView<const T> view() const { return {pixels.data(), width, height}; }
};
using DepthImage = OwnedImage<std::uint16_t>;
using ColorImage = OwnedImage<Rgb8>;

/// A different image for each `seed`: ramps, steps, the values 0 and 65535.
[[nodiscard]] DepthImage make_depth(int width, int height, int seed);
/// Smooth colours, so that JPEG keeps them nearly.
[[nodiscard]] ColorImage make_color(int width, int height, int seed);

[[nodiscard]] bool equal(const ImageView<const std::uint16_t>& a, const ImageView<const std::uint16_t>& b);
/// The largest difference in any channel; 256 for images of different sizes.
[[nodiscard]] int largest_difference(const ImageView<const Rgb8>& a, const ImageView<const Rgb8>& b);

/// Writers for tests: they throw std::runtime_error when a file cannot be written.
void write_depth(const std::string& path, const DepthImage& image);
void write_color_jpeg(const std::string& path, const ColorImage& image);
void write_color_png(const std::string& path, const ColorImage& image);
/// Cuts a file to its first `fraction`.
void truncate_file(const std::string& path, double fraction);

/// One frame of a .klg file; `image` is what goes into the file (JPEG, raw RGB or nothing).
struct KlgFrame {
  std::int64_t timestamp_us = 0;
  std::vector<std::uint8_t> depth;
  std::vector<std::uint8_t> image;
};
[[nodiscard]] std::vector<std::uint8_t> zlib_bytes(const DepthImage& image);
[[nodiscard]] std::vector<std::uint8_t> raw_bytes(const DepthImage& image);
[[nodiscard]] std::vector<std::uint8_t> jpeg_bytes(const ColorImage& image);
[[nodiscard]] std::vector<std::uint8_t> raw_bytes(const ColorImage& image);
/// The same JPEG with another size in its head.
[[nodiscard]] std::vector<std::uint8_t> claim_jpeg_size(std::vector<std::uint8_t> jpeg, int width,
                                                        int height);
void write_klg(const std::string& path, const std::vector<KlgFrame>& frames);

/// A RawFrame with buffers of its own that fit a source.
class FrameBuffers {
 public:
  explicit FrameBuffers(const SourceInfo& info);
  RawFrame frame;

 private:
  std::vector<std::uint16_t> depth_;
  std::vector<Rgb8> color_;
};

}  // namespace loopsift::test
