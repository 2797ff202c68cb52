// SPDX-License-Identifier: MIT
#include "core/frame/frame.hpp"

#include "core/frame/intensity.hpp"
#include "core/frame/kernels.hpp"

namespace loopsift {
namespace {

Error out_of_range(const char* key, const char* range) {
  return {ErrorCode::kUsage, std::string("frame.") + key + " must be " + range};
}

}  // namespace

Status validate(const FrameOptions& o) {
  if (o.reduction != 1 && o.reduction != 2 && o.reduction != 4) return out_of_range("reduction", "1, 2 or 4");
  if (o.levels < 1 || o.levels > kMaxFrameLevels) return out_of_range("levels", "from 1 to 4");
  if (!(o.min_depth_m >= 0)) return out_of_range("min_depth_m", "0 or more");
  if (!(o.max_depth_m > o.min_depth_m)) return out_of_range("max_depth_m", "more than min_depth_m");
  if (!(o.edge_fraction > 0 && o.edge_fraction < 1)) return out_of_range("edge_fraction", "between 0 and 1");
  if (o.smoothing_radius < 0 || o.smoothing_radius > 4)
    return out_of_range("smoothing_radius", "from 0 to 4");
  return {};
}

FramePreprocessor::FramePreprocessor(const PinholeCamera& camera, double depth_unit_m,
                                     const FrameOptions& options, Arena& arena)
    : options_(options) {
  frame_.raw_camera = camera;
  frame_.depth_unit_m = static_cast<float>(depth_unit_m);
  frame_.min_depth_m = options.min_depth_m;
  frame_.max_depth_m = options.max_depth_m;
  frame_.level_count = options.levels;
  PinholeCamera level_camera = options.reduction == 1 ? camera : camera.block_averaged(2);
  if (options.reduction == 4) {
    reduced_ = arena.carve<float>("frame/scratch", static_cast<std::size_t>(level_camera.width) *
                                                       static_cast<std::size_t>(level_camera.height));
    reduced_camera_ = level_camera;
    level_camera = level_camera.block_averaged(2);
  }
  for (std::size_t l = 0; l < static_cast<std::size_t>(options.levels); ++l) {
    const int w = level_camera.width, h = level_camera.height;
    const auto pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    Level& s = storage_[l];
    for (Span<float>* image : {&s.depth, &s.nx, &s.ny, &s.nz, &s.intensity})
      *image = arena.carve<float>("frame/pyramid", pixels);
    frame_.levels[l] = {level_camera,        {s.depth.data(), w, h}, {s.nx.data(), w, h},
                        {s.ny.data(), w, h}, {s.nz.data(), w, h},    {}};
    if (l == 0) {
      smoothed_ = arena.carve<float>("frame/scratch", pixels);
      disparity_ = arena.carve<float>("frame/disparity", pixels);
      frame_.disparity = {disparity_.data(), w, h};
    }
    level_camera = level_camera.block_averaged(2);
  }
}

const Frame& FramePreprocessor::process(const RawFrame& raw) {
  frame_.id = FrameId{next_id_++};
  frame_.timestamp_ns = raw.timestamp_ns;
  frame_.raw_depth = raw.depth;
  frame_.color = raw.color;
  reduce();
  correct();
  for (std::size_t l = 0; l < static_cast<std::size_t>(options_.levels); ++l) {
    if (l > 0) halve_depth(frame_.levels[l - 1].depth_m, options_.edge_fraction, depth_image(l));
    add_normals(l);
  }
  add_intensity();
  const ImageView<const float>& finest = frame_.levels[0].depth_m;
  frame_.valid_fraction = static_cast<float>(count_valid(finest)) / static_cast<float>(finest.size());
  return frame_;
}

ImageView<float> FramePreprocessor::depth_image(std::size_t level) const {
  const PinholeCamera& camera = frame_.levels[level].camera;
  return {storage_[level].depth.data(), camera.width, camera.height};
}

// Raw depth to level 0, by way of an intermediate image where the reduction is 4.
void FramePreprocessor::reduce() {
  const DepthRange range{options_.min_depth_m, options_.max_depth_m, options_.edge_fraction};
  if (options_.reduction < 4) {
    reduce_raw(frame_.raw_depth, options_.reduction, frame_.depth_unit_m, range, depth_image(0));
    return;
  }
  const ImageView<float> half(reduced_.data(), reduced_camera_.width, reduced_camera_.height);
  reduce_raw(frame_.raw_depth, 2, frame_.depth_unit_m, range, half);
  halve_depth(half, options_.edge_fraction, depth_image(0));
}

void FramePreprocessor::set_disparity(const DisparityCoefficients& coefficients, float unknown) {
  next_disparity_ = coefficients;
  next_unknown_ = unknown;
}

void FramePreprocessor::correct() {
  frame_.disparity_unknown = next_unknown_;
  if (next_disparity_ != frame_.disparity_coefficients) {
    frame_.disparity_coefficients = next_disparity_;
    draw_disparity(next_disparity_, {disparity_.data(), frame_.disparity.width, frame_.disparity.height});
  }
  if (!frame_.disparity_coefficients.isZero(0.0)) correct_depth(frame_.disparity, depth_image(0));
}

// A colour image that is smaller than the working one says too little.
void FramePreprocessor::add_intensity() {
  const PinholeCamera& finest = frame_.levels[0].camera;
  const bool usable = frame_.color.width >= finest.width && frame_.color.height >= finest.height &&
                      frame_.color.width < 64 * finest.width && frame_.color.height < 64 * finest.height;
  for (std::size_t l = 0; l < static_cast<std::size_t>(options_.levels); ++l) {
    FrameLevel& level = frame_.levels[l];
    level.intensity = {};
    if (!usable) continue;
    const ImageView<float> image(storage_[l].intensity.data(), level.camera.width, level.camera.height);
    if (l == 0) {
      reduce_color(frame_.color, image);
    } else {
      halve_intensity(frame_.levels[l - 1].intensity, image);
    }
    level.intensity = image;
  }
}

void FramePreprocessor::add_normals(std::size_t level) {
  const PinholeCamera& camera = frame_.levels[level].camera;
  const Level& s = storage_[level];
  const ImageView<float> smoothed(smoothed_.data(), camera.width, camera.height);
  // A coarser pixel already averages four: half the radius there.
  smooth_depth(frame_.levels[level].depth_m, options_.smoothing_radius >> level, options_.edge_fraction,
               smoothed);
  compute_normals(smoothed, camera, options_.edge_fraction, s.nx.data(), s.ny.data(), s.nz.data());
}

}  // namespace loopsift
