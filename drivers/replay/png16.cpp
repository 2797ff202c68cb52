// SPDX-License-Identifier: MIT
#include "drivers/replay/png16.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace loopsift {
namespace {

constexpr std::uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr const char* kTruncated = "the file is truncated";
constexpr const char* kCorrupt = "the file is corrupt";
constexpr std::size_t kChunkOverhead = 12;  // length, type, CRC

std::uint32_t big_endian(const std::uint8_t* p) {
  return std::uint32_t{p[0]} << 24 | std::uint32_t{p[1]} << 16 | std::uint32_t{p[2]} << 8 | p[3];
}

// The predictor of filter type 4: whichever of left, above, above left is nearest to left + above − above
// left. Without branches: depth noise makes them unpredictable.
int paeth(int left, int above, int above_left) {
  const int toward_left = above - above_left, toward_above = left - above_left;
  const int p_left = std::abs(toward_left), p_above = std::abs(toward_above),
            p_corner = std::abs(toward_left + toward_above);
  const int nearer = p_left <= p_above ? left : above;
  const int distance = p_left <= p_above ? p_left : p_above;
  return distance <= p_corner ? nearer : above_left;
}

void unfilter_paeth(const std::uint8_t* above, int bytes, std::uint8_t* row) {
  int left_high = 0, left_low = 0, corner_high = 0, corner_low = 0;
  for (int i = 0; i < bytes; i += 2) {  // the two bytes of a pixel are two independent chains
    const int above_high = above[i], above_low = above[i + 1];
    left_high = (row[i] + paeth(left_high, above_high, corner_high)) & 0xFF;
    left_low = (row[i + 1] + paeth(left_low, above_low, corner_low)) & 0xFF;
    row[i] = static_cast<std::uint8_t>(left_high);
    row[i + 1] = static_cast<std::uint8_t>(left_low);
    corner_high = above_high;
    corner_low = above_low;
  }
}

// Undoes one row's filter in place; `above` is the row before, unfiltered, or zeros. False: no such filter.
bool unfilter(int type, const std::uint8_t* above, int bytes, std::uint8_t* row) {
  switch (type) {
    case 0:
      return true;
    case 1:
      for (int i = 2; i < bytes; ++i) row[i] = static_cast<std::uint8_t>(row[i] + row[i - 2]);
      return true;
    case 2:
      for (int i = 0; i < bytes; ++i) row[i] = static_cast<std::uint8_t>(row[i] + above[i]);
      return true;
    case 3:
      for (int i = 0; i < bytes; ++i) {
        const int left = i < 2 ? 0 : row[i - 2];
        row[i] = static_cast<std::uint8_t>(row[i] + (left + above[i]) / 2);
      }
      return true;
    case 4:
      unfilter_paeth(above, bytes, row);
      return true;
    default:
      return false;
  }
}

const char* check_header(const std::uint8_t* ihdr, const ImageView<std::uint16_t>& image) {
  if (ihdr[8] != 16 || ihdr[9] != 0 || ihdr[12] != 0)
    return "the file is not a 16-bit grey PNG without interlacing";
  if (big_endian(ihdr) != static_cast<std::uint32_t>(image.width) ||
      big_endian(ihdr + 4) != static_cast<std::uint32_t>(image.height)) {
    return "the image has another size than the camera";
  }
  return nullptr;
}

}  // namespace

void Png16Decoder::reserve(int width, int height) {
  // One row of zeros goes before the first.
  const std::size_t bytes =
      (std::size_t{2} * static_cast<std::size_t>(width) + 1) * (static_cast<std::size_t>(height) + 1);
  if (rows_.size() < bytes) rows_.resize(bytes);
}

const char* Png16Decoder::decode(Span<const std::uint8_t> file, const ImageView<std::uint16_t>& image) {
  if (file.size() < sizeof(kSignature) || std::memcmp(file.data(), kSignature, sizeof(kSignature)) != 0) {
    return file.size() < sizeof(kSignature) ? kTruncated : "the file is not a PNG";
  }
  reserve(image.width, image.height);
  const std::size_t pitch = std::size_t{2} * static_cast<std::size_t>(image.width) + 1;
  std::memset(rows_.data(), 0, pitch);
  inflater_.begin({rows_.data() + pitch, pitch * static_cast<std::size_t>(image.height)});
  bool header_seen = false;
  for (std::size_t at = sizeof(kSignature); !inflater_.finished();) {
    if (file.size() < at + kChunkOverhead) return kTruncated;
    const std::uint8_t* chunk = file.data() + at;
    const std::size_t length = big_endian(chunk);
    if (file.size() - at - kChunkOverhead < length) return kTruncated;
    const std::uint8_t *type = chunk + 4, *data = chunk + 8;
    const bool is_header = std::memcmp(type, "IHDR", 4) == 0, is_data = std::memcmp(type, "IDAT", 4) == 0;
    if (is_header || is_data) {
      if (crc32(0, type, static_cast<unsigned>(length + 4)) != big_endian(data + length)) return kCorrupt;
    }
    if (is_header) {
      if (length != 13) return kCorrupt;
      if (const char* problem = check_header(data, image)) return problem;
      header_seen = true;
    }
    if (is_data && (!header_seen || !inflater_.feed({data, length}))) return kCorrupt;
    if (std::memcmp(type, "IEND", 4) == 0 && !inflater_.finished()) return kCorrupt;
    at += kChunkOverhead + length;
  }
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* row = rows_.data() + pitch * static_cast<std::size_t>(y + 1) + 1;
    if (!unfilter(row[-1], row - pitch, 2 * image.width, row)) return kCorrupt;
    std::uint16_t* out = image.row(y);
    for (int x = 0; x < image.width; ++x)
      out[x] = static_cast<std::uint16_t>(row[2 * x] << 8 | row[2 * x + 1]);
  }
  return nullptr;
}

namespace {

void put_big_endian(std::uint32_t value, std::vector<std::uint8_t>* bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes->push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_chunk(const char* type, Span<const std::uint8_t> data, std::vector<std::uint8_t>* bytes) {
  put_big_endian(static_cast<std::uint32_t>(data.size()), bytes);
  const std::size_t start = bytes->size();
  bytes->insert(bytes->end(), type, type + 4);
  bytes->insert(bytes->end(), data.begin(), data.end());
  put_big_endian(
      static_cast<std::uint32_t>(crc32(0, bytes->data() + start, static_cast<unsigned>(data.size() + 4))),
      bytes);
}

// Rows with filter type 2 (difference to the row above), which is the quickest to undo.
std::vector<std::uint8_t> filtered_rows(const ImageView<const std::uint16_t>& image) {
  std::vector<std::uint8_t> rows;
  rows.reserve((std::size_t{2} * static_cast<std::size_t>(image.width) + 1) *
               static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    rows.push_back(2);
    for (int x = 0; x < image.width; ++x) {
      const int value = image(x, y), above = y > 0 ? image(x, y - 1) : 0;
      rows.push_back(static_cast<std::uint8_t>((value >> 8) - (above >> 8)));
      rows.push_back(static_cast<std::uint8_t>(value - above));
    }
  }
  return rows;
}

}  // namespace

Status write_png16(const std::string& path, const ImageView<const std::uint16_t>& image) {
  const std::vector<std::uint8_t> rows = filtered_rows(image);
  uLongf compressed_size = compressBound(static_cast<uLong>(rows.size()));
  std::vector<std::uint8_t> compressed(compressed_size), header,
      file(kSignature, kSignature + sizeof(kSignature));
  compress2(compressed.data(), &compressed_size, rows.data(), static_cast<uLong>(rows.size()), 4);
  put_big_endian(static_cast<std::uint32_t>(image.width), &header);
  put_big_endian(static_cast<std::uint32_t>(image.height), &header);
  header.insert(header.end(), {16, 0, 0, 0, 0});
  put_chunk("IHDR", header, &file);
  put_chunk("IDAT", {compressed.data(), compressed_size}, &file);
  put_chunk("IEND", {}, &file);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(path.c_str(), "wb"), &std::fclose);
  if (out && std::fwrite(file.data(), 1, file.size(), out.get()) == file.size() &&
      std::fflush(out.get()) == 0)
    return {};
  return Error{ErrorCode::kIo, path + ": cannot be written: " + std::strerror(errno)};
}

}  // namespace loopsift
