// SPDX-License-Identifier: MIT
#include "drivers/replay/klg_source.hpp"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>

#include "core/base/steady_time.hpp"
#include "drivers/replay/calibration.hpp"

namespace loopsift {
namespace {

// ElasticFusion's default for such files.
const Calibration kDefault{{640, 480, 528.0F, 528.0F, 320.0F, 240.0F}, 1000};
constexpr std::int64_t kLatestTimestampUs = std::numeric_limits<std::int64_t>::max() / 1000;

struct FrameHead {
  std::int64_t timestamp_us = 0;
  std::int32_t depth_bytes = 0;
  std::int32_t image_bytes = 0;
};

// False at the end of the file.
bool read_head(std::FILE* file, FrameHead* head) {
  return std::fread(&head->timestamp_us, 8, 1, file) == 1 &&
         std::fread(&head->depth_bytes, 4, 1, file) == 1 && std::fread(&head->image_bytes, 4, 1, file) == 1;
}

bool read_bytes(std::FILE* file, std::int32_t count, std::vector<std::uint8_t>* bytes) {
  return std::fread(bytes->data(), 1, static_cast<std::size_t>(count), file) ==
         static_cast<std::size_t>(count);
}

// Room for an image stored raw, or compressed to no gain.
std::size_t largest_image(int width, int height, std::size_t bytes_per_pixel) {
  const std::size_t raw =
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * bytes_per_pixel;
  return raw + raw / 8 + 4096;
}

// The colour image's size, from the first frame: a JPEG says it, a raw image has the depth's.
ImageSize peek_color_size(std::FILE* file, const PinholeCamera& camera) {
  FrameHead head;
  std::vector<std::uint8_t> image(largest_image(camera.width, camera.height, 3));
  const bool readable = read_head(file, &head) && head.depth_bytes > 0 && head.image_bytes > 0 &&
                        static_cast<std::size_t>(head.image_bytes) <= image.size() &&
                        std::fseek(file, head.depth_bytes, SEEK_CUR) == 0 &&
                        read_bytes(file, head.image_bytes, &image);
  if (!readable) return {};
  if (head.image_bytes == camera.width * camera.height * 3) return {camera.width, camera.height};
  return jpeg_size({image.data(), static_cast<std::size_t>(head.image_bytes)});
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> KlgSource::open(const std::string& path,
                                                       const SourceOptions& options) {
  const std::string folder = std::filesystem::absolute(path).parent_path().string();
  const Expected<Calibration> calibration = resolve_calibration(kDefault, folder, options);
  if (!calibration) return calibration.error();
  if (!calibration->camera.is_valid()) {
    return Error{ErrorCode::kFormat, path + ": the camera is not usable; check " + folder + "/camera.txt"};
  }
  File file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) {
    const ErrorCode code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return Error{code, path + ": cannot be opened: " + std::strerror(errno)};
  }
  std::int32_t count = 0;
  if (std::fread(&count, sizeof(count), 1, file.get()) != 1 || count <= 0) {
    return Error{ErrorCode::kFormat, path + ": holds no frames, or is no .klg recording"};
  }
  SourceInfo info;
  info.description = "klg " + path + ", " + std::to_string(count) + " frames";
  info.camera = calibration->camera;
  info.depth_unit_m = 1.0 / calibration->depth_scale;
  info.frame_count = count;
  if (options.rate_hz > 0) info.nominal_rate_hz = options.rate_hz;
  if (options.want_color) {
    const ImageSize color = peek_color_size(file.get(), info.camera);
    info.color_width = color.width;
    info.color_height = color.height;
  }
  if (std::fseek(file.get(), sizeof(count), SEEK_SET) != 0) {
    return Error{ErrorCode::kIo, path + ": cannot be rewound: " + std::strerror(errno)};
  }
  return std::unique_ptr<FrameSource>(std::make_unique<KlgSource>(path, std::move(file), std::move(info)));
}

KlgSource::KlgSource(std::string path, File file, SourceInfo info)
    : path_(std::move(path)),
      file_(std::move(file)),
      info_(std::move(info)),
      depth_bytes_(largest_image(info_.camera.width, info_.camera.height, 2)),
      // Room for images that are not wanted too: they must be passed over.
      image_bytes_(largest_image(std::max(info_.color_width, info_.camera.width),
                                 std::max(info_.color_height, info_.camera.height), 3)),
      reader_({0, 0}, {info_.color_width, info_.color_height}),
      last_timestamp_ns_(std::numeric_limits<std::int64_t>::min()) {
  message_.reserve(1024);
}

ReadStatus KlgSource::bad(const char* problem, bool at_end) {
  char number[32];
  std::snprintf(number, sizeof(number), ", frame %lld: ", static_cast<long long>(next_ - 1));
  message_.append(path_).append(number).append(problem);
  ended_ = ended_ || at_end;
  return ReadStatus::kBad;
}

const char* KlgSource::decode_depth(Span<const std::uint8_t> bytes, const ImageView<std::uint16_t>& image) {
  const Span<std::uint8_t> raw(reinterpret_cast<std::uint8_t*>(image.data), 2 * image.size());
  if (bytes.size() == raw.size()) {
    std::memcpy(raw.data(), bytes.data(), raw.size());
    return nullptr;
  }
  inflater_.begin(raw);
  if (inflater_.feed(bytes) && inflater_.finished()) return nullptr;
  return "the depth image is corrupt, or of another size than the camera (camera.txt gives width and height)";
}

const char* KlgSource::decode_image(Span<const std::uint8_t> bytes, const ImageView<Rgb8>& image) {
  if (bytes.size() != 3 * image.size()) return reader_.decode_color(bytes, image);
  std::memcpy(&image.data->r, bytes.data(), bytes.size());
  return nullptr;
}

ReadStatus KlgSource::read(RawFrame& frame, int /*timeout_ms*/) {
  message_.clear();
  if (ended_ || next_ == info_.frame_count) return ReadStatus::kEnd;
  frame.sequence = next_++;
  frame.captured_ns = steady_now_ns();
  FrameHead head;
  if (!read_head(file_.get(), &head)) return bad("the file is truncated", true);
  const bool sane = head.depth_bytes > 0 && head.image_bytes >= 0 &&
                    static_cast<std::size_t>(head.depth_bytes) <= depth_bytes_.size() &&
                    static_cast<std::size_t>(head.image_bytes) <= image_bytes_.size();
  if (!sane) return bad("its size fields are damaged; what follows cannot be found", true);
  if (!read_bytes(file_.get(), head.depth_bytes, &depth_bytes_) ||
      !read_bytes(file_.get(), head.image_bytes, &image_bytes_)) {
    return bad("the file is truncated", true);
  }
  if (head.timestamp_us < 0 || head.timestamp_us > kLatestTimestampUs ||
      head.timestamp_us * 1000 <= last_timestamp_ns_) {
    return bad("its time stamp does not go forward", false);
  }
  last_timestamp_ns_ = frame.timestamp_ns = head.timestamp_us * 1000;
  frame.depth = ImageView(frame.depth_buffer.data(), info_.camera.width, info_.camera.height);
  frame.color = {};
  assert(frame.depth_buffer.size() >= frame.depth.size());
  if (const char* problem =
          decode_depth({depth_bytes_.data(), static_cast<std::size_t>(head.depth_bytes)}, frame.depth)) {
    return bad(problem, false);
  }
  if (info_.color_width == 0 || head.image_bytes == 0) return ReadStatus::kFrame;
  const ImageView<Rgb8> color(frame.color_buffer.data(), info_.color_width, info_.color_height);
  assert(frame.color_buffer.size() >= color.size());
  if (const char* problem =
          decode_image({image_bytes_.data(), static_cast<std::size_t>(head.image_bytes)}, color)) {
    (void)bad(problem, false);
    return ReadStatus::kFrame;
  }
  frame.color = color;
  return ReadStatus::kFrame;
}

}  // namespace loopsift
