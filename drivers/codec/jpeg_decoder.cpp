// SPDX-License-Identifier: MIT
#include "drivers/codec/jpeg_decoder.hpp"

#include <cstdio>  // jpeglib.h wants it

#include <jpeglib.h>

#include <jerror.h>

#include <csetjmp>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "drivers/codec/decoder_memory.hpp"

// libjpeg leaves these two to its memory manager: an array of rows that is all in memory.
struct jvirt_sarray_control {
  JSAMPARRAY rows;
  JDIMENSION count;
};
struct jvirt_barray_control {
  JBLOCKARRAY rows;
  JDIMENSION count;
};

namespace loopsift {
namespace {

constexpr const char* kCorrupt = "the JPEG is truncated or corrupt";
constexpr std::size_t kForLifeBytes = std::size_t{64} << 10;

// The coefficients of a progressive image are kept whole: two bytes for each sample of each component, in
// blocks that reach over the edge. Else there are only some rows.
std::size_t working_bytes(int width, int height) {
  const auto padded = [](int n) { return static_cast<std::size_t>((n + 31) / 32 * 32); };
  return padded(width) * (padded(height) + 96) * 3 * sizeof(JCOEF) + (std::size_t{512} << 10);
}

}  // namespace

struct JpegDecoder::Impl {
  Impl(int width, int height);
  ~Impl();
  const char* decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image);
  const char* read(Span<const std::uint8_t> file, const ImageView<Rgb8>& image);
  void fill_manager();

  static Impl& of(j_common_ptr info) { return *static_cast<Impl*>(info->client_data); }
  static void* take(j_common_ptr info, int pool, std::size_t bytes);
  template <class Row>
  static Row* take_rows(j_common_ptr info, int pool, std::size_t row_bytes, JDIMENSION count);
  template <class Array>
  static Array* request(j_common_ptr info, int pool, boolean zero, std::size_t row_bytes, JDIMENSION count);
  template <class Array>
  static auto access(j_common_ptr info, Array* array, JDIMENSION first, JDIMENSION count);
  [[noreturn]] static void fail(j_common_ptr info) { std::longjmp(of(info).failed, 1); }

  jpeg_decompress_struct info{};
  jpeg_error_mgr errors{};
  jpeg_memory_mgr manager{};
  jpeg_memory_mgr* original = nullptr;
  DecoderMemory for_life, working;
  std::jmp_buf failed{};
};

void* JpegDecoder::Impl::take(j_common_ptr info, int pool, std::size_t bytes) {
  Impl& self = of(info);
  void* p = (pool == JPOOL_PERMANENT ? self.for_life : self.working).take(bytes);
  if (p == nullptr) fail(info);
  return p;
}

// Rows are as long as SIMD code wants them, which writes past their ends.
template <class Row>
Row* JpegDecoder::Impl::take_rows(j_common_ptr info, int pool, std::size_t row_bytes, JDIMENSION count) {
  constexpr std::size_t kRowAlignment = 64;
  const std::size_t pitch = (row_bytes + kRowAlignment - 1) / kRowAlignment * kRowAlignment;
  auto* rows = static_cast<Row*>(take(info, pool, count * sizeof(Row)));
  auto* bytes = static_cast<std::byte*>(take(info, pool, count * pitch));
  for (JDIMENSION y = 0; y < count; ++y) rows[y] = reinterpret_cast<Row>(bytes + y * pitch);
  return rows;
}

template <class Array>
Array* JpegDecoder::Impl::request(j_common_ptr info, int pool, boolean zero, std::size_t row_bytes,
                                  JDIMENSION count) {
  using Row = std::remove_reference_t<decltype(*Array::rows)>;
  auto* array = static_cast<Array*>(take(info, pool, sizeof(Array)));
  *array = {take_rows<Row>(info, pool, row_bytes, count), count};
  for (JDIMENSION y = 0; zero != 0 && y < count; ++y)
    std::memset(static_cast<void*>(array->rows[y]), 0, row_bytes);
  return array;
}

template <class Array>
auto JpegDecoder::Impl::access(j_common_ptr info, Array* array, JDIMENSION first, JDIMENSION count) {
  if (first > array->count || count > array->count - first) fail(info);
  return array->rows + first;
}

void JpegDecoder::Impl::fill_manager() {
  manager = *original;
  manager.alloc_small = manager.alloc_large = take;
  manager.alloc_sarray = [](j_common_ptr i, int pool, JDIMENSION samples, JDIMENSION rows) {
    return take_rows<JSAMPROW>(i, pool, samples * sizeof(JSAMPLE), rows);
  };
  manager.alloc_barray = [](j_common_ptr i, int pool, JDIMENSION blocks, JDIMENSION rows) {
    return take_rows<JBLOCKROW>(i, pool, blocks * sizeof(JBLOCK), rows);
  };
  manager.request_virt_sarray = [](j_common_ptr i, int pool, boolean zero, JDIMENSION samples,
                                   JDIMENSION rows, JDIMENSION /*at once*/) {
    return request<jvirt_sarray_control>(i, pool, zero, samples * sizeof(JSAMPLE), rows);
  };
  manager.request_virt_barray = [](j_common_ptr i, int pool, boolean zero, JDIMENSION blocks, JDIMENSION rows,
                                   JDIMENSION /*at once*/) {
    return request<jvirt_barray_control>(i, pool, zero, blocks * sizeof(JBLOCK), rows);
  };
  manager.realize_virt_arrays = [](j_common_ptr) {};
  manager.access_virt_sarray = [](j_common_ptr i, jvirt_sarray_ptr array, JDIMENSION first, JDIMENSION count,
                                  boolean) { return access(i, array, first, count); };
  manager.access_virt_barray = [](j_common_ptr i, jvirt_barray_ptr array, JDIMENSION first, JDIMENSION count,
                                  boolean) { return access(i, array, first, count); };
  manager.free_pool = [](j_common_ptr i, int pool) {
    if (pool != JPOOL_PERMANENT) of(i).working.back_to_mark();
  };
}

JpegDecoder::Impl::Impl(int width, int height)
    : for_life(kForLifeBytes), working(working_bytes(width, height)) {
  info.err = jpeg_std_error(&errors);
  errors.error_exit = fail;
  errors.output_message = [](j_common_ptr) {};
  info.client_data = this;
  if (setjmp(failed) != 0) return;  // NOLINT(cert-err52-cpp): another library than we were built for
  jpeg_create_decompress(&info);
  original = info.mem;
  fill_manager();
  info.mem = &manager;
}

JpegDecoder::Impl::~Impl() {
  if (original == nullptr) return;
  info.mem = original;
  jpeg_destroy_decompress(&info);
}

const char* JpegDecoder::Impl::decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image) {
  if (original == nullptr) return "this build's libjpeg does not work";
  if (setjmp(failed) != 0) {  // NOLINT(cert-err52-cpp): libjpeg's way to fail
    jpeg_abort_decompress(&info);
    return kCorrupt;
  }
  const char* problem = read(file, image);
  jpeg_abort_decompress(&info);
  return problem;
}

const char* JpegDecoder::Impl::read(Span<const std::uint8_t> file, const ImageView<Rgb8>& image) {
  jpeg_mem_src(&info, file.data(), static_cast<unsigned long>(file.size()));
  if (jpeg_read_header(&info, TRUE) != JPEG_HEADER_OK) return kCorrupt;
  if (info.image_width != static_cast<unsigned>(image.width) ||
      info.image_height != static_cast<unsigned>(image.height))
    return "the image has another size than the camera";
  info.out_color_space = JCS_RGB;
  if (jpeg_start_decompress(&info) == 0) return kCorrupt;
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = &image.row(static_cast<int>(info.output_scanline))->r;
    if (jpeg_read_scanlines(&info, &row, 1) != 1) return kCorrupt;
  }
  jpeg_finish_decompress(&info);
  return errors.num_warnings == 0 ? nullptr : kCorrupt;  // a truncated file is grey from there on
}

JpegDecoder::JpegDecoder(int width, int height) : impl_(std::make_unique<Impl>(width, height)) {}
JpegDecoder::~JpegDecoder() = default;

const char* JpegDecoder::decode(Span<const std::uint8_t> file, const ImageView<Rgb8>& image) {
  return impl_->decode(file, image);
}

}  // namespace loopsift
