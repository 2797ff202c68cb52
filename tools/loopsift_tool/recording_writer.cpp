// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/recording_writer.hpp"

#include <zlib.h>

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include "drivers/replay/image_file.hpp"
#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {
namespace {

constexpr int kJpegQuality = 95;
constexpr double kTumScale = 5000;
constexpr const char* kFormats = "klg, tum, 7scenes, redwood, sun3d";

Error write_error(const std::string& path) {
  return {ErrorCode::kIo, path + ": cannot be written; check the folder's rights and free space"};
}

Status write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  return file ? Status() : Status(write_error(path));
}

Status make_folders(const std::string& folder, const std::vector<std::string>& names) {
  std::error_code error;
  std::filesystem::create_directories(folder.empty() ? "." : folder, error);
  for (const std::string& name : names)
    if (!error) std::filesystem::create_directories(folder + "/" + name, error);
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be made: " + error.message()};
  return {};
}

Status write_camera(const std::string& folder, const PinholeCamera& c, double depth_scale) {
  std::ostringstream text;
  text.precision(9);
  text << "fx " << c.fx << "\nfy " << c.fy << "\ncx " << c.cx << "\ncy " << c.cy << "\nwidth " << c.width
       << "\nheight " << c.height << "\ndepth_scale " << depth_scale << "\n";
  return write_text((folder.empty() ? "." : folder) + "/camera.txt", text.str());
}

std::string numbered(const char* pattern, std::int64_t number) {
  char name[64];
  std::snprintf(name, sizeof name, pattern, number);
  return name;
}

/// The formats that keep an image per file differ in names and lists.
class FolderWriter : public RecordingWriter {
 public:
  explicit FolderWriter(std::string folder) : folder_(std::move(folder)) {}

  Status write(std::int64_t timestamp_ns, const ImageView<const std::uint16_t>& depth,
               const ImageView<const Rgb8>& color) override {
    const std::string depth_name = name_of_depth(timestamp_ns);
    if (Status s = write_png16(folder_ + "/" + depth_name, stored(depth)); !s) return s;
    std::string color_name;
    if (!color.empty()) {
      color_name = name_of_color(timestamp_ns);
      if (Status s = write_jpeg(folder_ + "/" + color_name, color, kJpegQuality); !s) return s;
    }
    list(timestamp_ns, depth_name, color_name);
    ++count_;
    return {};
  }
  Status finish() override { return {}; }

 protected:
  [[nodiscard]] virtual std::string name_of_depth(std::int64_t timestamp_ns) const = 0;
  [[nodiscard]] virtual std::string name_of_color(std::int64_t timestamp_ns) const = 0;
  virtual void list(std::int64_t /*timestamp_ns*/, const std::string& /*depth*/,
                    const std::string& /*color*/) {}
  virtual ImageView<const std::uint16_t> stored(const ImageView<const std::uint16_t>& depth) { return depth; }

  std::string folder_;
  std::int64_t count_ = 0;
};

class TumWriter final : public FolderWriter {
 public:
  using FolderWriter::FolderWriter;
  Status finish() override {
    for (const auto& [name, text] : {std::pair("/depth.txt", &depth_), std::pair("/rgb.txt", &color_),
                                     std::pair("/associations.txt", &both_)})
      if (!text->empty())
        if (Status s = write_text(folder_ + name, *text); !s) return s;
    return {};
  }
  [[nodiscard]] double depth_scale() const override { return kTumScale; }

 private:
  [[nodiscard]] std::string name_of_depth(std::int64_t /*timestamp_ns*/) const override {
    return numbered("depth/%06" PRId64 ".png", count_);
  }
  [[nodiscard]] std::string name_of_color(std::int64_t /*timestamp_ns*/) const override {
    return numbered("rgb/%06" PRId64 ".jpg", count_);
  }
  void list(std::int64_t timestamp_ns, const std::string& depth, const std::string& color) override {
    char time[48];
    std::snprintf(time, sizeof time, "%" PRId64 ".%09" PRId64, timestamp_ns / 1'000'000'000,
                  timestamp_ns % 1'000'000'000);
    const std::string first = std::string(time) + " " + depth;
    depth_ += first + "\n";
    if (!color.empty()) color_ += std::string(time) + " " + color + "\n";
    if (!color.empty()) both_ += first + " " + time + " " + color + "\n";
  }
  std::string depth_, color_, both_;
};

class SevenScenesWriter final : public FolderWriter {
 public:
  using FolderWriter::FolderWriter;

 private:
  [[nodiscard]] std::string name_of_depth(std::int64_t /*timestamp_ns*/) const override {
    return numbered("frame-%06" PRId64 ".depth.png", count_);
  }
  [[nodiscard]] std::string name_of_color(std::int64_t /*timestamp_ns*/) const override {
    return numbered("frame-%06" PRId64 ".color.jpg", count_);
  }
};

class RedwoodWriter final : public FolderWriter {
 public:
  using FolderWriter::FolderWriter;

 private:
  [[nodiscard]] std::string name_of_depth(std::int64_t /*timestamp_ns*/) const override {
    return numbered("depth/%06" PRId64 ".png", count_);
  }
  [[nodiscard]] std::string name_of_color(std::int64_t /*timestamp_ns*/) const override {
    return numbered("image/%06" PRId64 ".jpg", count_);
  }
};

/// Numbers from 1, microseconds behind them, depth bits rotated left by three.
class Sun3dWriter final : public FolderWriter {
 public:
  Sun3dWriter(std::string folder, const PinholeCamera& camera)
      : FolderWriter(std::move(folder)), camera_(camera) {}
  Status finish() override {
    std::ostringstream K;
    K.precision(9);
    K << camera_.fx << " 0 " << camera_.cx << "\n0 " << camera_.fy << " " << camera_.cy << "\n0 0 1\n";
    return write_text(folder_ + "/intrinsics.txt", K.str());
  }

 private:
  [[nodiscard]] std::string name(const char* folder, std::int64_t timestamp_ns, const char* ending) const {
    return folder + numbered("%07" PRId64 "-", count_ + 1) + numbered("%012" PRId64, timestamp_ns / 1000) +
           ending;
  }
  [[nodiscard]] std::string name_of_depth(std::int64_t timestamp_ns) const override {
    return name("depth/", timestamp_ns, ".png");
  }
  [[nodiscard]] std::string name_of_color(std::int64_t timestamp_ns) const override {
    return name("image/", timestamp_ns, ".jpg");
  }
  ImageView<const std::uint16_t> stored(const ImageView<const std::uint16_t>& depth) override {
    rotated_.clear();
    for (int y = 0; y < depth.height; ++y)
      for (int x = 0; x < depth.width; ++x) {
        const unsigned d = depth(x, y);
        rotated_.push_back(static_cast<std::uint16_t>((d << 3U) | (d >> 13U)));
      }
    return {rotated_.data(), depth.width, depth.height};
  }

  PinholeCamera camera_;
  std::vector<std::uint16_t> rotated_;
};

/// drivers/replay/klg_source.hpp has the layout.
class KlgWriter final : public RecordingWriter {
 public:
  explicit KlgWriter(const std::string& path) : path_(path), file_(path, std::ios::binary) { put(count_); }

  Status write(std::int64_t timestamp_ns, const ImageView<const std::uint16_t>& depth,
               const ImageView<const Rgb8>& color) override {
    raw_.clear();
    for (int y = 0; y < depth.height; ++y) raw_.insert(raw_.end(), depth.row(y), depth.row(y) + depth.width);
    const auto raw_bytes = static_cast<uLong>(raw_.size() * sizeof raw_[0]);
    packed_.resize(compressBound(raw_bytes));
    auto size = static_cast<uLongf>(packed_.size());
    if (compress(packed_.data(), &size, reinterpret_cast<const Bytef*>(raw_.data()), raw_bytes) != Z_OK)
      return Error{ErrorCode::kIo, path_ + ": zlib could not compress a depth image"};
    std::vector<std::uint8_t> jpeg;
    if (!color.empty()) {
      auto encoded = encode_jpeg(color, kJpegQuality);
      if (!encoded) return encoded.error();
      jpeg = std::move(*encoded);
    }
    put(timestamp_ns / 1000);
    put(static_cast<std::int32_t>(size));
    put(static_cast<std::int32_t>(jpeg.size()));
    file_.write(reinterpret_cast<const char*>(packed_.data()), static_cast<std::streamsize>(size));
    file_.write(reinterpret_cast<const char*>(jpeg.data()), static_cast<std::streamsize>(jpeg.size()));
    ++count_;
    return file_ ? Status() : Status(write_error(path_));
  }
  Status finish() override {
    file_.seekp(0);
    put(count_);
    file_.flush();
    return file_ ? Status() : Status(write_error(path_));
  }

 private:
  template <class T>
  void put(const T& value) {
    file_.write(reinterpret_cast<const char*>(&value), sizeof value);
  }

  std::string path_;
  std::ofstream file_;
  std::int32_t count_ = 0;  // frames so far; the file begins with it
  std::vector<std::uint16_t> raw_;
  std::vector<Bytef> packed_;
};

/// Raw units of the source to those of the writer; 0 where invalid or too far for 16 bits.
void rescale(const ImageView<std::uint16_t>& raw, double factor, std::vector<std::uint16_t>* depth) {
  depth->clear();
  for (int y = 0; y < raw.height; ++y)
    for (int x = 0; x < raw.width; ++x) {
      const double value = raw(x, y) == 65535 ? 0.0 : std::round(raw(x, y) * factor);
      depth->push_back(value < 65535 ? static_cast<std::uint16_t>(value) : std::uint16_t{0});
    }
}

}  // namespace

Expected<std::unique_ptr<RecordingWriter>> open_recording_writer(const std::string& format,
                                                                 const std::string& path,
                                                                 const SourceInfo& info) {
  std::vector<std::string> folders;
  if (format == "tum") folders = {"depth", "rgb"};
  if (format == "redwood" || format == "sun3d") folders = {"depth", "image"};
  std::unique_ptr<RecordingWriter> writer;
  if (format == "tum") writer = std::make_unique<TumWriter>(path);
  if (format == "7scenes") writer = std::make_unique<SevenScenesWriter>(path);
  if (format == "redwood") writer = std::make_unique<RedwoodWriter>(path);
  if (format == "sun3d") writer = std::make_unique<Sun3dWriter>(path, info.camera);
  if (format == "oni")
    return Error{ErrorCode::kUnsupported,
                 "oni: only OpenNI2's recorder writes it, which is not part of this build; choose one of " +
                     std::string(kFormats)};
  const bool klg = format == "klg";
  if (!writer && !klg)
    return Error{ErrorCode::kUsage, "'" + format + "' is no format of a recording; known are " + kFormats};
  const std::string folder = klg ? std::filesystem::path(path).parent_path().string() : path;
  if (Status s = make_folders(folder, folders); !s) return s.error();
  if (klg) writer = std::make_unique<KlgWriter>(path);
  if (Status s = write_camera(folder, info.camera, writer->depth_scale()); !s) return s.error();
  return writer;
}

Expected<CopiedFrames> copy_recording(FrameSource& source, RecordingWriter& writer) {
  const SourceInfo& info = source.info();
  const auto pixels = [](int w, int h) { return static_cast<std::size_t>(w) * static_cast<std::size_t>(h); };
  std::vector<std::uint16_t> buffer(pixels(info.camera.width, info.camera.height)), depth;
  std::vector<Rgb8> color(pixels(info.color_width, info.color_height));
  RawFrame frame;
  frame.depth_buffer = buffer;
  frame.color_buffer = color;
  CopiedFrames copied;
  Ticker ticker("writing frame");
  while (true) {
    const ReadStatus status = source.read(frame, 1000);
    if (status == ReadStatus::kEnd) break;
    if (status == ReadStatus::kTimeout) continue;
    if (status == ReadStatus::kLost) return Error{ErrorCode::kIo, "the source was lost: " + source.message()};
    if (status == ReadStatus::kBad) {
      ++copied.unusable;
      std::fprintf(stderr, "loopsift-tool: frame skipped: %s\n", source.message().c_str());
      continue;
    }
    rescale(frame.depth, info.depth_unit_m * writer.depth_scale(), &depth);
    const ImageView<const std::uint16_t> view(depth.data(), frame.depth.width, frame.depth.height);
    const ImageView<const Rgb8> shown(frame.color);
    if (Status s = writer.write(frame.timestamp_ns, view, shown); !s) return s.error();
    ++copied.frames;
    ticker.update(static_cast<std::size_t>(copied.frames),
                  static_cast<std::size_t>(std::max(info.frame_count, copied.frames)));
  }
  if (copied.frames == 0) return Error{ErrorCode::kFormat, info.description + ": holds no usable frame"};
  if (Status s = writer.finish(); !s) return s.error();
  return copied;
}

}  // namespace loopsift::tool
