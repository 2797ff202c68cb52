// SPDX-License-Identifier: MIT
#include "drivers/replay/image_file.hpp"

#include <fcntl.h>
#include <png.h>
#include <sys/stat.h>
#include <turbojpeg.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "drivers/image_limits.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kHeadBytes =
    std::size_t{64} * 1024;  // room for a file's other content beside the pixels

// An image file is never larger than its pixels and a little: zlib and JPEG fall back to storing them.
std::size_t largest_file(ImageSize size, std::size_t bytes_per_pixel) {
  const std::size_t pixels =
      static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * bytes_per_pixel;
  return pixels + pixels / 8 + kHeadBytes;
}

// At most `bytes` of a file into `buffer`, by one read in the common case; −1 and errno on failure.
std::ptrdiff_t read_file(const std::string& path, std::uint8_t* buffer, std::size_t bytes) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return -1;
  std::size_t done = 0;
  std::ptrdiff_t n = 0;
  while (done < bytes && (n = ::read(descriptor, buffer + done, bytes - done)) > 0)
    done += static_cast<std::size_t>(n);
  const int problem = errno;
  ::close(descriptor);
  errno = problem;
  return n < 0 ? -1 : static_cast<std::ptrdiff_t>(done);
}

}  // namespace

ImageReader::ImageReader(ImageSize depth, ImageSize color)
    : file_(std::max(largest_file(depth, 2), largest_file(color, 3))), color_(color.width, color.height) {
  png16_.reserve(depth.width, depth.height);
}

const char* ImageReader::load(const std::string& path, Span<const std::uint8_t>* file) {
  const std::ptrdiff_t size = read_file(path, file_.data(), file_.size());
  if (size < 0) return errno == ENOENT ? "the file does not exist" : "the file cannot be read";
  if (static_cast<std::size_t>(size) == file_.size())
    return "the file is larger than an image of this size can be";
  *file = {file_.data(), static_cast<std::size_t>(size)};
  return nullptr;
}

const char* ImageReader::read_depth(const std::string& path, const ImageView<std::uint16_t>& image) {
  Span<const std::uint8_t> file;
  if (const char* problem = load(path, &file)) return problem;
  return png16_.decode(file, image);
}

const char* ImageReader::read_color(const std::string& path, const ImageView<Rgb8>& image) {
  Span<const std::uint8_t> file;
  if (const char* problem = load(path, &file)) return problem;
  return color_.decode(file, image);
}

ImageSize jpeg_size(Span<const std::uint8_t> file) {
  ImageSize size;
  int subsampling = 0, colors = 0;
  if (!is_jpeg(file)) return size;
  const tjhandle decoder = tjInitDecompress();
  if (tjDecompressHeader3(decoder, file.data(), static_cast<unsigned long>(file.size()), &size.width,
                          &size.height, &subsampling, &colors) != 0) {
    size = {};
  }
  tjDestroy(decoder);
  return size.width <= kLargestSide && size.height <= kLargestSide ? size : ImageSize();
}

Expected<ImageSize> read_image_size(const std::string& path) {
  std::vector<std::uint8_t> head(kHeadBytes);
  const std::ptrdiff_t bytes = read_file(path, head.data(), head.size());
  if (bytes < 0) {
    const ErrorCode code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return Error{code, path + ": cannot be read: " + std::strerror(errno)};
  }
  head.resize(static_cast<std::size_t>(bytes));
  ImageSize size = jpeg_size(head);
  if (is_png(head) && head.size() >= 24) {
    const auto number = [&](std::size_t i) {
      return head[i] << 24 | head[i + 1] << 16 | head[i + 2] << 8 | head[i + 3];
    };
    size = {number(16), number(20)};
  }
  if (size.width <= 0 || size.height <= 0 || size.width > kLargestSide || size.height > kLargestSide) {
    return Error{ErrorCode::kFormat, path + ": is neither a PNG nor a JPEG image of at most " +
                                         std::to_string(kLargestSide) + " pixels on a side"};
  }
  return size;
}

Status write_png_rgb(const std::string& path, const ImageView<const Rgb8>& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<unsigned>(image.width);
  png.height = static_cast<unsigned>(image.height);
  png.format = PNG_FORMAT_RGB;
  png.flags = PNG_IMAGE_FLAG_FAST;
  if (png_image_write_to_file(&png, path.c_str(), 0, image.data, 3 * image.stride, nullptr) != 0) return {};
  return Error{ErrorCode::kIo, path + ": cannot be written: " + png.message};
}

Expected<std::vector<std::uint8_t>> encode_jpeg(const ImageView<const Rgb8>& image, int quality) {
  const tjhandle encoder = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int result = tjCompress2(encoder, &image.data->r, image.width, 3 * image.stride, image.height,
                                 TJPF_RGB, &bytes, &size, TJSAMP_420, quality, 0);
  std::vector<std::uint8_t> jpeg;
  if (result == 0) jpeg.assign(bytes, bytes + size);
  const std::string problem = result == 0 ? "" : tjGetErrorStr2(encoder);
  tjFree(bytes);
  tjDestroy(encoder);
  if (result != 0) return Error{ErrorCode::kUsage, "JPEG encoding failed: " + problem};
  return jpeg;
}

Status write_jpeg(const std::string& path, const ImageView<const Rgb8>& image, int quality) {
  const Expected<std::vector<std::uint8_t>> jpeg = encode_jpeg(image, quality);
  if (!jpeg) return Error{jpeg.error().code, path + ": " + jpeg.error().message};
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(path.c_str(), "wb"), &std::fclose);
  if (out && std::fwrite(jpeg->data(), 1, jpeg->size(), out.get()) == jpeg->size() &&
      std::fflush(out.get()) == 0) {
    return {};
  }
  return Error{ErrorCode::kIo, path + ": cannot be written: " + std::strerror(errno)};
}

}  // namespace loopsift
