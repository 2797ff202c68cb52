// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/offline_map.hpp"

#include <algorithm>
#include <string>

#include "core/base/steady_time.hpp"
#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {
namespace {

constexpr int kLeastFrames = 3;  // fewer poses are no trajectory

FrameOptions frame_options(const OfflineMapOptions& o, const PinholeCamera& camera) {
  FrameOptions options;
  const int ratio = camera.width / o.map_width;
  options.reduction = ratio >= 4 ? 4 : std::max(1, ratio / 2 * 2);
  options.levels = 1;  // poses are given: nothing is tracked
  return options;
}

FragmentOptions fragment_options(const OfflineMapOptions& o, const PinholeCamera& camera) {
  FragmentOptions options;
  options.frames_per_fragment = o.fragment_frames;
  options.views_per_fragment = o.views;
  options.view_step = std::max(1, camera.width / o.view_width);
  return options;
}

PinholeCamera view_camera(const OfflineMapOptions& o, const PinholeCamera& camera) {
  const int step = fragment_options(o, camera).view_step;
  return camera.subsampled(step, step / 2);
}

StoreOptions store_options(const OfflineMapOptions& o, const SourceInfo& info) {
  const FragmentOptions fragment = fragment_options(o, info.camera);
  StoreOptions options;
  options.max_fragments = fragments_in(info.frame_count, o.fragment_frames);
  options.max_surfels = options.max_fragments * fragment.max_surfels;
  options.max_frames = static_cast<int>(info.frame_count);
  options.max_views = options.max_fragments * o.views;
  const PinholeCamera view = view_camera(o, info.camera);
  options.max_view_pixels = view.width * view.height;
  return options;
}

BackEndOptions back_end_options(const OfflineMapOptions& o, const SourceInfo& info, ScoreKind score) {
  BackEndOptions options;
  options.propose = false;
  options.proposal.max_fragments = 1;  // nothing is proposed
  options.posterior.max_fragments = fragments_in(info.frame_count, o.fragment_frames);
  options.posterior.max_views_per_fragment = o.views;
  options.posterior.max_view_width = view_camera(o, info.camera).width;
  options.posterior.max_view_height = view_camera(o, info.camera).height;
  options.finish_limit_s = 1e9;
  options.sifter.max_loops = static_cast<int>(o.max_loops);
  options.sifter.max_nodes = options.keyframes_per_fragment * options.posterior.max_fragments;
  options.sifter.score = score;
  options.sifter.hindsight = score == ScoreKind::kPosterior;
  return options;
}

}  // namespace

Status validate(const OfflineMapOptions& o) {
  if (o.fragment_frames < 2 || o.fragment_frames > 10000)
    return Error{ErrorCode::kUsage, "--fragment-frames must be from 2 to 10000"};
  if (o.views < 1 || o.views > o.fragment_frames)
    return Error{ErrorCode::kUsage, "--views must be from 1 to the frames per fragment"};
  if (o.view_width < 16 || o.view_width > 4096)
    return Error{ErrorCode::kUsage, "--view-width must be from 16 to 4096 pixels"};
  if (o.map_width < 16 || o.map_width > 4096)
    return Error{ErrorCode::kUsage, "--map-width must be from 16 to 4096 pixels"};
  return {};
}

int fragments_in(std::int64_t frame_count, int fragment_frames) {
  return static_cast<int>((frame_count + fragment_frames - 1) / fragment_frames);
}

DetachedBackEnd::DetachedBackEnd(const BackEndOptions& options, Span<const Fragment> fragments,
                                 double odometry_factor)
    : arena_([&options] {
        Arena measuring;
        const BackEnd measured(options, measuring);
        return measuring.used_bytes();
      }()),
      fragments_(fragments.begin(), fragments.end()) {
  back_end_.emplace(options, arena_);
  frames_.reserve(fragments_.size());
  for (Fragment& fragment : fragments_) {
    frames_.emplace_back(fragment.frames.begin(), fragment.frames.end());
    for (FragmentFrame& frame : frames_.back()) frame.information *= odometry_factor;
    fragment.frames = Span<const FragmentFrame>(frames_.back());
  }
  for (const Fragment& fragment : fragments_) (void)back_end_->insert_fragment(fragment);
  back_end_->update_sifter();
}

OfflineMap::Parts::Parts(FrameSource& source, const GivenOdometry& odometry, const OfflineMapOptions& options,
                         Arena& arena)
    : sequence(source, odometry, arena),
      store(store_options(options, source.info()), arena),
      preprocessor(source.info().camera, source.info().depth_unit_m,
                   frame_options(options, source.info().camera), arena),
      builder(fragment_options(options, source.info().camera), preprocessor.working_camera(),
              source.info().camera, arena) {
  for (const ScoreKind score : options.back_ends)
    back_ends.emplace_back(back_end_options(options, source.info(), score), arena);
}

OfflineMap::OfflineMap(FrameSource& source, const GivenOdometry& odometry, const OfflineMapOptions& options,
                       std::size_t arena_bytes)
    : options_(options),
      info_(source.info()),
      arena_(arena_bytes),
      parts_(source, odometry, options, arena_) {
  figures_.source = source.info().description;
  figures_.memory.budget_bytes = static_cast<std::int64_t>(arena_bytes);
}

Expected<std::unique_ptr<OfflineMap>> OfflineMap::build(FrameSource& source, const GivenOdometry& odometry,
                                                        const OfflineMapOptions& options) {
  if (Status valid = validate(options); !valid) return valid.error();
  const SourceInfo& info = source.info();
  if (info.live || info.frame_count < 1)
    return Error{ErrorCode::kUsage, info.description + ": its length is not known; give a recording"};
  Arena measuring;
  { const Parts parts(source, odometry, options, measuring); }
  std::unique_ptr<OfflineMap> map(new OfflineMap(source, odometry, options, measuring.used_bytes()));
  if (Status read = map->read_all(odometry, info.frame_count); !read) return read.error();
  return map;
}

Status OfflineMap::read_all(const GivenOdometry& odometry, std::int64_t frame_count) {
  Ticker ticker("reading and fusing frame");
  while (true) {
    const Expected<const PosedFrame*> posed = parts_.sequence.next();
    if (!posed) return posed.error();
    if (*posed == nullptr) break;
    const int fragment = (*posed)->number.value / options_.fragment_frames;
    if (Status started = start_fragment(fragment); !started) return started;
    fuse(**posed);
    ticker.update(frames_.size(), static_cast<std::size_t>(frame_count));
  }
  if (static_cast<int>(frames_.size()) < kLeastFrames)
    return Error{ErrorCode::kFormat, odometry.extent() + "; " +
                                         (frames_.empty() ? "no" : "only " + std::to_string(frames_.size())) +
                                         " usable frame of '" + figures_.source + "' is among them, and " +
                                         std::to_string(kLeastFrames) +
                                         " are needed: give the trajectory of this recording"};
  if (Status closed = close_fragment(); !closed) return closed;
  if (Status checked = check_content(); !checked) return checked;
  const PosedFrameCounts& counts = parts_.sequence.counts();
  figures_.frames = {counts.received, counts.unusable, static_cast<std::int64_t>(frames_.size()),
                     counts.without_pose};
  figures_.sequence_duration_s =
      static_cast<double>(frames_.back().timestamp_ns - frames_.front().timestamp_ns) * 1e-9;
  for (BackEnd& back_end : parts_.back_ends) back_end.update_sifter();
  return {};
}

Status OfflineMap::check_content() const {
  for (const Fragment& fragment : fragments())
    if (fragment.surfels.size() > 0) return {};
  return Error{ErrorCode::kFormat,
               "the map of '" + figures_.source +
                   "' is empty: no depth of it lies within the range that is fused; check "
                   "the depth images and their depth_scale"};
}

std::unique_ptr<DetachedBackEnd> OfflineMap::make_back_end(ScoreKind score, double odometry_factor) const {
  return std::make_unique<DetachedBackEnd>(back_end_options(options_, info_, score), fragments(),
                                           odometry_factor);
}

// Closes the fragment before, where `fragment` is a new one. None may be empty: ids count those in the store.
Status OfflineMap::start_fragment(int fragment) {
  const int open = static_cast<int>(fragments().size());
  if (fragment == open) return {};
  int empty = open;
  if (!parts_.builder.empty()) {
    if (Status closed = close_fragment(); !closed) return closed;
    empty = open + 1;
  }
  if (fragment == empty) return {};
  const int first = empty * options_.fragment_frames;
  return Error{ErrorCode::kFormat,
               "frames " + std::to_string(first) + " to " +
                   std::to_string(first + options_.fragment_frames - 1) +
                   " have no usable depth with a pose: fragment " + std::to_string(empty) +
                   " would be empty and the numbers of all later ones would not hold; give poses for them"};
}

Status OfflineMap::close_fragment() {
  const Fragment* closed = parts_.builder.close(&parts_.store);
  bool taken = closed != nullptr;
  for (BackEnd& back_end : parts_.back_ends) taken = taken && back_end.insert_fragment(*closed);
  if (taken) return {};
  return Error{ErrorCode::kCapacity, "fragment " + std::to_string(fragments().size()) +
                                         " does not fit: the recording is longer than it said"};
}

void OfflineMap::fuse(const PosedFrame& posed) {
  const std::int64_t begin = steady_now_ns();
  Frame frame = parts_.preprocessor.process(*posed.raw);
  frame.id = posed.number;
  const std::int64_t preprocessed = steady_now_ns();
  parts_.builder.integrate(frame, posed.pose.T_odom_camera, posed.pose.information, !frames_.empty());
  frames_.push_back({posed.raw->timestamp_ns, posed.pose.T_odom_camera});
  const std::int64_t end = steady_now_ns();
  figures_[Stage::kFusion].record_ns(end - preprocessed);
  figures_[Stage::kFrame].record_ns(end - begin);
}

}  // namespace loopsift::tool
