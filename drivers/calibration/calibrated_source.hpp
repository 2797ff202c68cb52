// SPDX-License-Identifier: MIT
// A source with what is known of its sensor applied: depth without distortion, mirroring and systematic
// error, colour brought to the depth camera's place. In: a source and a calibration. Out: its frames; colour,
// where it is brought over, has the depth image's size. Thread: the source's reader. Tables and one device
// frame are taken in create(); read() takes nothing and goes over each image once.
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/camera_calibration.hpp"
#include "drivers/calibration/color_registrar.hpp"
#include "drivers/calibration/depth_rectifier.hpp"
#include "drivers/frame_source.hpp"

namespace loopsift {

class CalibratedSource final : public FrameSource {
 public:
  /// `source` itself where the calibration changes nothing about its images. The depth intrinsics are the
  /// source's (SourceOptions::camera has brought the calibration's there). factors: 16-bit fixed point, one
  /// per pixel of the depth image as delivered, or empty. Errors name the calibration's file: a size that
  /// does not fit the device's, a distortion that folds the image over.
  [[nodiscard]] static Expected<std::unique_ptr<FrameSource>> create(
      std::unique_ptr<FrameSource> source, const CameraCalibration& calibration,
      const std::vector<std::uint16_t>& factors);

  CalibratedSource(std::unique_ptr<FrameSource> source, DepthRectifier rectifier,
                   std::optional<ColorRegistrar> registrar);
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override { return source_->message(); }

 private:
  std::unique_ptr<FrameSource> source_;
  SourceInfo info_;
  DepthRectifier rectifier_;
  std::optional<ColorRegistrar> registrar_;
  std::vector<std::uint16_t> depth_;  // as delivered; empty where depth is not changed
  std::vector<Rgb8> color_;           // the same
};

}  // namespace loopsift
