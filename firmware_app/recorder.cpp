// SPDX-License-Identifier: MIT
#include "firmware_app/recorder.hpp"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "drivers/replay/image_file.hpp"

namespace loopsift {
namespace {

constexpr int kFastest = 1;  // of zlib: a third of the time for a tenth more bytes
constexpr std::int64_t kHeadBytes = sizeof(std::int32_t);  // the number of frames

std::size_t pixels(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

template <class T>
void append(const T& value, std::vector<std::uint8_t>* bytes) {
  const auto* raw = reinterpret_cast<const std::uint8_t*>(&value);
  bytes->insert(bytes->end(), raw, raw + sizeof value);
}

Status write_camera(const std::string& path, const SourceInfo& info) {
  const PinholeCamera& c = info.camera;
  std::ofstream out(path);
  out.precision(9);
  out << "fx " << c.fx << "\nfy " << c.fy << "\ncx " << c.cx << "\ncy " << c.cy << "\nwidth " << c.width
      << "\nheight " << c.height << "\ndepth_scale " << 1.0 / info.depth_unit_m << "\n";
  out.flush();
  if (out) return {};
  return Error{ErrorCode::kIo, path + ": cannot be written: " + std::strerror(errno)};
}

}  // namespace

FrameRecorder::FrameRecorder(const RecordOptions& options, const SourceInfo& info, Arena& arena)
    : options_(options),
      info_(info),
      depth_pixels_(pixels(info.camera.width, info.camera.height)),
      color_pixels_(pixels(info.color_width, info.color_height)),
      slots_(arena.carve<Slot>("record/slots", options.folder.empty() ? 0 : kWaiting)),
      depth_(arena.carve<std::uint16_t>("record/depth", slots_.size() * depth_pixels_)),
      color_(arena.carve<Rgb8>("record/color", slots_.size() * color_pixels_)),
      free_(arena.carve<std::uint32_t>("record/free", slots_.size())),
      ready_(arena.carve<std::uint32_t>("record/ready", slots_.size())) {}

Status FrameRecorder::start() {
  if (options_.folder.empty()) return {};
  const std::string path = options_.folder + "/recording.klg";
  std::error_code error;
  std::filesystem::create_directories(options_.folder, error);
  file_ = error ? -1 : open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file_ < 0)
    return Error{ErrorCode::kIo,
                 path + ": cannot be made: " + (error ? error.message() : std::string(std::strerror(errno))) +
                     "; name a new folder with --record"};
  if (const Status camera = write_camera(options_.folder + "/camera.txt", info_); !camera) return camera;
  for (std::uint32_t k = 0; k < slots_.size(); ++k) (void)free_.try_push(k);
  thread_ = std::thread([this] { run(); });
  return {};
}

void FrameRecorder::offer(const RawFrame& frame) {
  if (slots_.empty() || counts_.full.load(std::memory_order_relaxed)) return;
  // Who reads the file takes the size of colour from its first frame.
  begun_ = begun_ || color_pixels_ == 0 || !frame.color.empty();
  if (!begun_) return;
  std::uint32_t index = 0;
  if (!free_.try_pop(&index)) {
    counts_.left_out.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  slots_[index] = {frame.timestamp_ns, !frame.color.empty()};
  const auto copy = [](const auto& image, auto* to) {
    for (int y = 0; y < image.height; ++y)
      std::memcpy(to + y * image.width, image.row(y), sizeof(*to) * static_cast<std::size_t>(image.width));
  };
  copy(frame.depth, depth_.data() + index * depth_pixels_);
  if (slots_[index].has_color) copy(frame.color, color_.data() + index * color_pixels_);
  (void)ready_.try_push(index);  // there is a place for each slot
  ready_or_end_.post();
}

std::string FrameRecorder::finish() {
  if (!thread_.joinable()) return {};
  ending_ = true;
  ready_or_end_.post();
  thread_.join();
  close(file_);
  std::string text = options_.folder + "/recording.klg: " + std::to_string(counts_.written) + " frames, " +
                     std::to_string(counts_.bytes >> 20) + " MiB";
  if (counts_.left_out > 0)
    text += "; " + std::to_string(counts_.left_out) + " left out, because writing was slower than the camera";
  return text;
}

void FrameRecorder::run() {
  counts_.bytes = kHeadBytes;
  const std::int32_t none = 0;
  if (!put(&none, sizeof none, 0)) stop_writing(std::strerror(errno));
  std::uint32_t index = 0;
  while (true) {
    while (ready_.try_pop(&index)) {
      if (!counts_.full) write(index);
      (void)free_.try_push(index);
    }
    if (ending_ && ready_.size() == 0) return;
    ready_or_end_.wait();
  }
}

// One entry of the file (drivers/replay/klg_source.hpp), and then the number of entries.
void FrameRecorder::write(std::size_t slot) {
  const auto* depth = reinterpret_cast<const Bytef*>(depth_.data() + slot * depth_pixels_);
  std::vector<Bytef> packed(compressBound(static_cast<uLong>(2 * depth_pixels_)));
  auto packed_bytes = static_cast<uLongf>(packed.size());
  if (compress2(packed.data(), &packed_bytes, depth, static_cast<uLong>(2 * depth_pixels_), kFastest) != Z_OK)
    return stop_writing("zlib could not compress a depth image");
  std::vector<std::uint8_t> jpeg;
  if (slots_[slot].has_color) {
    const ImageView<const Rgb8> color(color_.data() + slot * color_pixels_, info_.color_width,
                                      info_.color_height);
    auto encoded = encode_jpeg(color, options_.jpeg_quality);
    if (!encoded) return stop_writing(encoded.error().message);
    jpeg = std::move(*encoded);
  }
  entry_.clear();
  append(slots_[slot].timestamp_ns / 1000, &entry_);
  append(static_cast<std::int32_t>(packed_bytes), &entry_);
  append(static_cast<std::int32_t>(jpeg.size()), &entry_);
  entry_.insert(entry_.end(), packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(packed_bytes));
  entry_.insert(entry_.end(), jpeg.begin(), jpeg.end());
  const auto size = static_cast<std::int64_t>(entry_.size());
  if (counts_.bytes + size > std::int64_t{options_.max_mib} << 20)
    return stop_writing("record.max_mib are written");
  const auto count = static_cast<std::int32_t>(counts_.written + 1);
  if (!put(entry_.data(), entry_.size(), counts_.bytes) || !put(&count, sizeof count, 0))
    return stop_writing(std::strerror(errno));
  counts_.bytes += size;
  counts_.written = count;
}

bool FrameRecorder::put(const void* bytes, std::size_t size, std::int64_t offset) const {
  const auto* next = static_cast<const std::uint8_t*>(bytes);
  while (size > 0) {
    const ssize_t written = pwrite(file_, next, size, offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    next += written;
    offset += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

// What was half written is cut off.
void FrameRecorder::stop_writing(const std::string& why) {
  counts_.full = true;
  const bool cut = ftruncate(file_, counts_.bytes) == 0;
  spdlog::warn("{}/recording.klg ends after {} frames: {}. The run goes on{}", options_.folder,
               counts_.written.load(), why, cut ? "" : "; the end of the file is damaged");
}

}  // namespace loopsift
