// SPDX-License-Identifier: MIT
#include "drivers/replay/color_image.hpp"

#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <vector>

#include "drivers/codec/decoder_memory.hpp"
#include "drivers/codec/jpeg_decoder.hpp"

namespace loopsift {
namespace {

constexpr const char* kWrongSize = "the image has another size than the camera";
constexpr const char* kBadPng = "the PNG is truncated or corrupt";

std::size_t pixels(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// Where libpng reads from, and where its errors go.
struct PngInput {
  Span<const std::uint8_t> rest;
  std::jmp_buf failed;
};

void read_png(png_structp png, png_bytep out, std::size_t bytes) {
  auto* input = static_cast<PngInput*>(png_get_io_ptr(png));
  if (input->rest.size() < bytes) png_error(png, "truncated");
  std::memcpy(out, input->rest.data(), bytes);
  input->rest = {input->rest.data() + bytes, input->rest.size() - bytes};
}

[[noreturn]] void png_failed(png_structp png, png_const_charp /*why*/) {
  std::longjmp(static_cast<PngInput*>(png_get_error_ptr(png))->failed, 1);
}

void ignore(png_structp /*png*/, png_const_charp /*why*/) {}

}  // namespace

bool is_png(Span<const std::uint8_t> file) {
  return file.size() >= 8 && std::memcmp(file.data(), "\x89PNG\r\n\x1a\n", 8) == 0;
}
bool is_jpeg(Span<const std::uint8_t> file) { return file.size() >= 2 && file[0] == 0xFF && file[1] == 0xD8; }

struct ColorDecoder::Jpeg {
  Jpeg(int width, int height) : decoder(width, height) {}
  JpegDecoder decoder;
};

struct ColorDecoder::Png {
  // Its structures and zlib's window, and a few rows of up to four 16-bit channels.
  Png(int width, int height)
      : memory((std::size_t{512} << 10) + 64 * static_cast<std::size_t>(width)),
        rows(static_cast<std::size_t>(height)) {}

  const char* decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image);
  const char* read(png_structp png, png_infop info, const ImageView<Rgb8>& image);

  static void* take(png_structp png, png_alloc_size_t bytes) {
    return static_cast<Png*>(png_get_mem_ptr(png))->memory.take(bytes);
  }
  static void give_back(png_structp /*png*/, png_voidp /*p*/) {}

  DecoderMemory memory;
  std::vector<png_bytep> rows;
};

const char* ColorDecoder::Png::decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image) {
  memory.back_to_mark();
  PngInput input{file, {}};
  png_structp png =
      png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &input, png_failed, ignore, this, take, give_back);
  if (png == nullptr) return kBadPng;
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(input.failed) != 0) {  // NOLINT(cert-err52-cpp): libpng's way to fail
    png_destroy_read_struct(&png, &info, nullptr);
    return kBadPng;
  }
  png_set_read_fn(png, &input, read_png);
  const char* problem = read(png, info, image);
  png_destroy_read_struct(&png, &info, nullptr);
  return problem;
}

const char* ColorDecoder::Png::read(png_structp png, png_infop info, const ImageView<Rgb8>& image) {
  png_read_info(png, info);
  if (png_get_image_width(png, info) != static_cast<unsigned>(image.width) ||
      png_get_image_height(png, info) != static_cast<unsigned>(image.height))
    return kWrongSize;
  png_set_expand(png);
  png_set_scale_16(png);
  png_set_strip_alpha(png);
  png_set_gray_to_rgb(png);
  (void)png_set_interlace_handling(png);
  png_read_update_info(png, info);
  for (int y = 0; y < image.height; ++y) rows[static_cast<std::size_t>(y)] = &image.row(y)->r;
  png_read_image(png, rows.data());
  png_read_end(png, nullptr);
  return nullptr;
}

ColorDecoder::ColorDecoder(int width, int height) {
  if (pixels(width, height) == 0) return;
  jpeg_ = std::make_unique<Jpeg>(width, height);
  png_ = std::make_unique<Png>(width, height);
}
ColorDecoder::~ColorDecoder() = default;

const char* ColorDecoder::decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image) {
  if (!jpeg_) return kWrongSize;
  if (is_png(file)) return png_->decode(file, image);
  if (is_jpeg(file)) return jpeg_->decoder.decode(file, image);
  return "the image is neither PNG nor JPEG";
}

}  // namespace loopsift
