// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/full_dmp.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "core/fragment/active_surfels.hpp"
#include "core/posterior/disc_renderer.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/disc_set.hpp"
#include "tools/loopsift_tool/posed_sequence.hpp"
#include "tools/loopsift_tool/residual_image.hpp"
#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {
namespace {

constexpr std::size_t kBatch = 16;  // frames scored at a time

// A fragment's surfels where the odometry has them.
struct FineFragment {
  Se3 T_odom_fragment;
  DiscSet discs;
};

FrameOptions frame_options(const FullDmpOptions& o) {
  FrameOptions options;
  options.reduction = 1;
  options.levels = 1;
  options.min_depth_m = o.min_depth_m;
  options.max_depth_m = o.max_depth_m;
  options.smoothing_radius = 4;  // what normals are taken from, at four times the usual resolution
  return options;
}

FragmentOptions fragment_options(const FullDmpOptions& o) {
  FragmentOptions options;
  options.frames_per_fragment = o.fragment_frames;
  options.active_capacity = 4000000;
  return options;
}

// Frames in, fine fragments out.
class FineFusion {
 public:
  FineFusion(const SourceInfo& info, const FullDmpOptions& options, Arena& arena)
      : options_(fragment_options(options)),
        preprocessor_(info.camera, info.depth_unit_m, frame_options(options), arena),
        active_(options_, preprocessor_.working_camera(), arena) {}

  void add(const PosedFrame& posed) {
    const int fragment = posed.number.value / options_.frames_per_fragment;
    if (fragment != current_) close();
    current_ = fragment;
    if (frames_ == 0) T_odom_fragment_ = posed.pose.T_odom_camera;
    Frame frame = preprocessor_.process(*posed.raw);
    frame.id = posed.number;
    active_.fuse(frame, T_odom_fragment_.inverse() * posed.pose.T_odom_camera);
    ++frames_;
  }
  void close() {
    if (frames_ == 0) return;
    active_.drop_seldom_seen(std::min(options_.min_frames_seen, frames_));
    map_.push_back({T_odom_fragment_, DiscSet::of(active_.surfels())});
    active_.clear();
    frames_ = 0;
  }
  [[nodiscard]] const std::vector<FineFragment>& map() const { return map_; }
  [[nodiscard]] std::uint64_t refused() const { return active_.refused(); }

 private:
  FragmentOptions options_;
  FramePreprocessor preprocessor_;
  ActiveSurfels active_;
  std::vector<FineFragment> map_;
  Se3 T_odom_fragment_;
  int current_ = -1, frames_ = 0;
};

// What both passes over the recording need; made once to measure and once for the work.
struct Parts {
  Parts(FrameSource& to_fuse, FrameSource& to_score, const GivenOdometry& odometry,
        const FullDmpOptions& options, Arena& arena)
      : fused(to_fuse, odometry, arena),
        scored(to_score, odometry, arena),
        fusion(to_fuse.info(), options, arena) {}
  PosedSequence fused, scored;
  FineFusion fusion;
};

// A frame waiting to be scored.
struct Waiting {
  FrameId number;
  double time_s = 0;
  Se3 T_odom_camera;
  std::vector<float> pixels;
  ImageView<const float> depth_m;  // of pixels; 0 invalid
  DmpFigures figures;
  Status picture;  // whether its residual image could be written
};

Waiting keep(const PosedFrame& posed, double depth_unit_m) {
  const ImageView<std::uint16_t>& raw = posed.raw->depth;
  Waiting waiting;
  waiting.number = posed.number;
  waiting.time_s = static_cast<double>(posed.raw->timestamp_ns) * 1e-9;
  waiting.T_odom_camera = posed.pose.T_odom_camera;
  waiting.pixels.reserve(raw.size());
  for (int y = 0; y < raw.height; ++y) {
    for (int x = 0; x < raw.width; ++x)
      waiting.pixels.push_back(raw(x, y) == 65535 ? 0.0F : static_cast<float>(raw(x, y) * depth_unit_m));
  }
  waiting.depth_m = {waiting.pixels.data(), raw.width, raw.height};
  return waiting;
}

bool in_range(double depth_m, const FullDmpOptions& o) {
  return depth_m > static_cast<double>(o.min_depth_m) && depth_m < static_cast<double>(o.max_depth_m);
}

void score(const std::vector<FineFragment>& map, const PinholeCamera& camera, const FullDmpOptions& o,
           Waiting* frame) {
  const int stride = padded_stride(camera.width);
  std::vector<float> pixels(static_cast<std::size_t>(stride) * static_cast<std::size_t>(camera.height));
  const ImageView<float> inverse_depth(pixels.data(), camera.width, camera.height, stride);
  const Se3 T_camera_odom = frame->T_odom_camera.inverse();
  for (const FineFragment& fragment : map)
    render_discs(fragment.discs.discs(), T_camera_odom * fragment.T_odom_fragment, camera, o.min_depth_m,
                 o.max_depth_m, inverse_depth);
  double sum = 0;
  DmpFigures figures;
  figures.views = 1;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto measured = static_cast<double>(frame->depth_m(x, y));
      const auto inverse = static_cast<double>(inverse_depth(x, y));
      const double predicted = inverse > 0 ? 1.0 / inverse : 0.0;
      if (!in_range(measured, o) || !in_range(predicted, o)) continue;
      sum += (predicted - measured) * (predicted - measured);
      ++figures.valid_pixels;
    }
  }
  if (figures.valid_pixels > 0) figures.dmp = sum / static_cast<double>(figures.valid_pixels);
  figures.per_view.push_back(
      {frame->number.value, frame->number.value / o.fragment_frames, frame->time_s, figures.dmp});
  frame->figures = figures;
  if (!o.heatmaps.folder.empty() && frame->number.value % o.heatmaps.every == 0)
    frame->picture =
        write_residual_image(o.heatmaps.folder, frame->number.value, frame->depth_m, inverse_depth);
}

Status score_batch(const std::vector<FineFragment>& map, const SourceInfo& info,
                   const FullDmpOptions& options, std::vector<Waiting>* batch, DmpFigures* total) {
#pragma omp parallel for schedule(dynamic)
  for (std::size_t k = 0; k < batch->size(); ++k) score(map, info.camera, options, &(*batch)[k]);
  for (const Waiting& frame : *batch) {
    if (!frame.picture.ok()) return frame.picture;
    total->per_view.push_back(frame.figures.per_view.front());
    total->dmp += frame.figures.dmp;
    total->views += frame.figures.views;
    total->valid_pixels += frame.figures.valid_pixels;
  }
  batch->clear();
  return {};
}

Status fuse_all(PosedSequence* sequence, std::int64_t frame_count, FineFusion* fusion) {
  Ticker ticker("fusing frame");
  while (true) {
    const Expected<const PosedFrame*> posed = sequence->next();
    if (!posed) return posed.error();
    if (*posed == nullptr) break;
    fusion->add(**posed);
    ticker.update(static_cast<std::size_t>((*posed)->number.value), static_cast<std::size_t>(frame_count));
  }
  fusion->close();
  if (fusion->refused() > 0)
    std::fprintf(stderr, "loopsift-tool: %llu surfels did not fit; take fewer frames per fragment\n",
                 static_cast<unsigned long long>(fusion->refused()));
  return {};
}

Expected<DmpFigures> score_all(PosedSequence* sequence, const SourceInfo& info,
                               const std::vector<FineFragment>& map, const FullDmpOptions& options) {
  Ticker ticker("scoring frame");
  DmpFigures total;
  std::vector<Waiting> batch;
  while (true) {
    const Expected<const PosedFrame*> posed = sequence->next();
    if (!posed) return posed.error();
    if (*posed == nullptr) break;
    batch.push_back(keep(**posed, info.depth_unit_m));
    if (batch.size() == kBatch)
      if (Status scored = score_batch(map, info, options, &batch, &total); !scored) return scored.error();
    ticker.update(static_cast<std::size_t>(total.views), static_cast<std::size_t>(info.frame_count));
  }
  if (Status scored = score_batch(map, info, options, &batch, &total); !scored) return scored.error();
  return total;
}

}  // namespace

Expected<DmpFigures> full_dmp(FrameSource& to_fuse, FrameSource& to_score, const GivenOdometry& odometry,
                              const FullDmpOptions& options) {
  Arena measuring;
  { const Parts parts(to_fuse, to_score, odometry, options, measuring); }
  Arena arena(measuring.used_bytes());
  Parts parts(to_fuse, to_score, odometry, options, arena);
  const SourceInfo& info = to_fuse.info();
  if (Status fused = fuse_all(&parts.fused, info.frame_count, &parts.fusion); !fused) return fused.error();
  if (parts.fusion.map().empty())
    return Error{ErrorCode::kFormat, odometry.extent() + "; no usable frame of '" + info.description +
                                         "' is among them: give the trajectory of this recording"};
  if (!options.heatmaps.folder.empty())
    if (Status made = make_folder(options.heatmaps.folder); !made) return made.error();
  return score_all(&parts.scored, info, parts.fusion.map(), options);
}

}  // namespace loopsift::tool
