// SPDX-License-Identifier: MIT
#include "drivers/lcm/images_message.hpp"

#include <array>
#include <bot_core/images_t.hpp>

#include "drivers/image_limits.hpp"

namespace loopsift {
namespace {

constexpr int kMaxImages = 16;
constexpr const char* kCut = "the message is cut, or a length in it is wrong";

/// LCM's encoding: big-endian, without padding. After the first read past the end nothing is read any more.
class Reader {
 public:
  explicit Reader(Span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <class T>
  T get() {
    const Span<const std::uint8_t> raw = get_bytes(sizeof(T));
    std::uint64_t value = 0;
    for (const std::uint8_t byte : raw) value = value << 8U | byte;
    return static_cast<T>(value);
  }
  Span<const std::uint8_t> get_bytes(std::int64_t count) {
    ok_ = ok_ && count >= 0 && static_cast<std::uint64_t>(count) <= bytes_.size() - next_;
    if (!ok_) return {};
    const Span<const std::uint8_t> part(bytes_.data() + next_, static_cast<std::size_t>(count));
    next_ += part.size();
    return part;
  }
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool at_end() const { return next_ == bytes_.size(); }

 private:
  Span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
  bool ok_ = true;
};

void skip_metadata(Reader* reader) {
  const auto count = reader->get<std::int32_t>();
  for (std::int32_t k = 0; k < count && reader->ok(); ++k) {
    (void)reader->get_bytes(reader->get<std::int32_t>());  // key
    (void)reader->get_bytes(reader->get<std::int32_t>());  // value
  }
}

EncodedImage get_image(Reader* reader) {
  EncodedImage image;
  (void)reader->get<std::int64_t>();  // its own utime
  image.width = reader->get<std::int32_t>();
  image.height = reader->get<std::int32_t>();
  image.row_stride = reader->get<std::int32_t>();
  image.format = reader->get<std::int32_t>();
  image.data = reader->get_bytes(reader->get<std::int32_t>());
  skip_metadata(reader);
  return image;
}

bool sane(const EncodedImage& image) {
  return image.width > 0 && image.height > 0 && image.width <= kLargestSide && image.height <= kLargestSide;
}

}  // namespace

const char* parse_images(Span<const std::uint8_t> bytes, ImagesMessage* message) {
  using bot_core::images_t;
  *message = {};
  Reader reader(bytes);
  if (reader.get<std::int64_t>() != images_t::getHash()) return "the message is no bot_core.images_t";
  message->utime_us = reader.get<std::int64_t>();
  const auto count = reader.get<std::int32_t>();
  if (!reader.ok() || count < 0 || count > kMaxImages) return kCut;
  std::array<std::int16_t, kMaxImages> types{};
  for (int k = 0; k < count; ++k) types[static_cast<std::size_t>(k)] = reader.get<std::int16_t>();
  for (int k = 0; k < count; ++k) {
    const EncodedImage image = get_image(&reader);
    const std::int16_t type = types[static_cast<std::size_t>(k)];
    const bool is_depth = type == images_t::DEPTH_MM || type == images_t::DEPTH_MM_ZIPPED;
    if (is_depth && message->depth.data.empty()) {
      message->depth = image;
      message->depth_zipped = type == images_t::DEPTH_MM_ZIPPED;
    }
    if (type == images_t::LEFT && message->color.data.empty()) message->color = image;
  }
  if (!reader.ok() || !reader.at_end()) return kCut;
  if (message->depth.data.empty()) return "no depth image (DEPTH_MM, DEPTH_MM_ZIPPED) is in the message";
  if (!sane(message->depth) || (!message->color.data.empty() && !sane(message->color)))
    return "an image of the message has no size, or one beyond 8192 pixels";
  return nullptr;
}

}  // namespace loopsift
