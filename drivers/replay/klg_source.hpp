// SPDX-License-Identifier: MIT
// .klg recordings (Kintinuous and ElasticFusion, Whelan et al.): int32 frame count; per frame int64 time
// stamp (µs), int32 depth bytes, int32 image bytes, depth (zlib, or raw 16-bit when the size is w·h·2), image
// (JPEG, or raw RGB when w·h·3). All little-endian. The file does not carry the depth image's size: it is the
// camera's, 640 × 480 unless `camera.txt` in the file's folder or the options say otherwise.
#pragma once
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "drivers/codec/inflater.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/replay/image_file.hpp"

namespace loopsift {

/// One thread; read() makes no heap call after the first frame.
class KlgSource final : public FrameSource {
 public:
  using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

  [[nodiscard]] static Expected<std::unique_ptr<FrameSource>> open(const std::string& path,
                                                                   const SourceOptions& options);

  KlgSource(std::string path, File file, SourceInfo info);
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override { return message_; }

 private:
  // The last frame's message; nothing can be found after it when `at_end`.
  ReadStatus bad(const char* problem, bool at_end);
  [[nodiscard]] const char* decode_depth(Span<const std::uint8_t> bytes,
                                         const ImageView<std::uint16_t>& image);
  [[nodiscard]] const char* decode_image(Span<const std::uint8_t> bytes, const ImageView<Rgb8>& image);

  std::string path_;
  File file_;
  SourceInfo info_;
  std::vector<std::uint8_t> depth_bytes_, image_bytes_;
  Inflater inflater_{true};
  ImageReader reader_;
  std::int64_t next_ = 0;
  std::int64_t last_timestamp_ns_;
  bool ended_ = false;
  std::string message_;
};

}  // namespace loopsift
