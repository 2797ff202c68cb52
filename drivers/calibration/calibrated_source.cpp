// SPDX-License-Identifier: MIT
#include "drivers/calibration/calibrated_source.hpp"

#include <cassert>

#include "drivers/calibration/lens.hpp"

namespace loopsift {
namespace {

std::size_t pixels(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

/// Nothing where colour is as it should be, or where there is none.
Expected<std::optional<ColorRegistrar>> make_registrar(const SourceInfo& info,
                                                       const CameraCalibration& calibration,
                                                       const LensCalibration& depth) {
  const bool aligned = calibration.color_is_aligned();
  const bool moves = calibration.color.mirrored || depth.mirrored || !depth.distortion.is_identity();
  if (info.color_width == 0 || (aligned && !moves)) return std::optional<ColorRegistrar>();
  LensCalibration lens = aligned ? depth : calibration.color;
  if (aligned) lens.mirrored = calibration.color.mirrored;
  const std::string what = calibration.file + ": the colour camera";
  const auto color = fit_lens(lens, info.color_width, info.color_height, what);
  if (!color) return color.error();
  const auto radius2 = largest_radius2(*color, what);
  if (!radius2) return radius2.error();
  return std::optional<ColorRegistrar>(std::in_place, depth.camera, *color, *radius2,
                                       aligned ? Se3() : calibration.T_color_depth, info.depth_unit_m);
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> CalibratedSource::create(std::unique_ptr<FrameSource> source,
                                                                const CameraCalibration& calibration,
                                                                const std::vector<std::uint16_t>& factors) {
  const SourceInfo& info = source->info();
  const std::string what = calibration.file + ": the depth camera";
  LensCalibration depth = calibration.depth;
  if (depth.camera.width != 0 &&
      (depth.camera.width != info.camera.width || depth.camera.height != info.camera.height))
    return other_size(depth.camera, info.camera.width, info.camera.height, what);
  depth.camera = info.camera;
  if (const auto radius2 = largest_radius2(depth, what); !radius2) return radius2.error();
  if (!factors.empty() && factors.size() != pixels(info.camera.width, info.camera.height)) {
    return Error{ErrorCode::kFormat, calibration.correction.factor_file + ": must have the depth image's " +
                                         std::to_string(info.camera.width) + "x" +
                                         std::to_string(info.camera.height) + " pixels"};
  }
  auto registrar = make_registrar(info, calibration, depth);
  if (!registrar) return registrar.error();
  DepthRectifier rectifier(depth, calibration.correction, info.depth_unit_m, factors);
  if (rectifier.is_identity() && !registrar->has_value()) return source;
  return std::unique_ptr<FrameSource>(
      std::make_unique<CalibratedSource>(std::move(source), std::move(rectifier), std::move(*registrar)));
}

CalibratedSource::CalibratedSource(std::unique_ptr<FrameSource> source, DepthRectifier rectifier,
                                   std::optional<ColorRegistrar> registrar)
    : source_(std::move(source)),
      info_(source_->info()),
      rectifier_(std::move(rectifier)),
      registrar_(std::move(registrar)) {
  if (!rectifier_.is_identity()) depth_.resize(pixels(info_.camera.width, info_.camera.height));
  if (!registrar_) return;
  color_.resize(pixels(info_.color_width, info_.color_height));
  info_.color_width = info_.camera.width;
  info_.color_height = info_.camera.height;
}

ReadStatus CalibratedSource::read(RawFrame& frame, int timeout_ms) {
  const Span<std::uint16_t> depth_buffer = frame.depth_buffer;
  const Span<Rgb8> color_buffer = frame.color_buffer;
  if (!depth_.empty()) frame.depth_buffer = depth_;
  if (!color_.empty()) frame.color_buffer = color_;
  const ReadStatus status = source_->read(frame, timeout_ms);
  frame.depth_buffer = depth_buffer;
  frame.color_buffer = color_buffer;
  if (status != ReadStatus::kFrame) return status;
  const PinholeCamera& camera = info_.camera;
  if (!rectifier_.is_identity()) {
    const ImageView<std::uint16_t> out(depth_buffer.data(), camera.width, camera.height);
    assert(depth_buffer.size() >= out.size());
    rectifier_.rectify(frame.depth, out);
    frame.depth = out;
  }
  if (registrar_ && !frame.color.empty()) {
    const ImageView<Rgb8> out(color_buffer.data(), camera.width, camera.height);
    assert(color_buffer.size() >= out.size());
    registrar_->register_color(frame.depth, frame.color, out);
    frame.color = out;
  }
  return status;
}

}  // namespace loopsift
