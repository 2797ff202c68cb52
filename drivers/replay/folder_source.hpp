// SPDX-License-Identifier: MIT
#pragma once
#include <memory>
#include <string>

#include "drivers/frame_source.hpp"
#include "drivers/replay/image_file.hpp"
#include "drivers/replay/recording.hpp"

namespace loopsift {

/// A listed folder, read frame by frame. One thread; read() makes no heap call after the first frame.
class FolderSource final : public FrameSource {
 public:
  /// Finds the images' sizes from the first readable ones and checks them against the calibration.
  [[nodiscard]] static Expected<std::unique_ptr<FrameSource>> open(const std::string& format,
                                                                   const std::string& folder,
                                                                   Recording recording,
                                                                   const ListOptions& list_options,
                                                                   const SourceOptions& options);

  FolderSource(SourceInfo info, Recording recording);
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override { return message_; }

 private:
  void explain(const std::string& path, const char* problem);

  SourceInfo info_;
  Recording recording_;
  ImageReader reader_;
  std::size_t next_ = 0;
  std::string message_;
};

}  // namespace loopsift
