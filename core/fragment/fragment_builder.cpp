// SPDX-License-Identifier: MIT
#include "core/fragment/fragment_builder.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>

namespace loopsift {

Status validate(const FragmentOptions& o) {
  const auto out_of_range = [](const char* key, const char* range) {
    return Error{ErrorCode::kUsage, std::string("fragment.") + key + " must be " + range};
  };
  if (o.frames_per_fragment < 2 || o.frames_per_fragment > 10000)
    return out_of_range("frames_per_fragment", "from 2 to 10000");
  if (!(o.max_travel_m >= 0)) return out_of_range("max_travel_m", "0 or more");
  if (!(o.max_turn_rad >= 0)) return out_of_range("max_turn_rad", "0 or more");
  if (!(o.max_drift_m >= 0)) return out_of_range("max_drift_m", "0 or more");
  if (o.views_per_fragment < 1 || o.views_per_fragment > o.frames_per_fragment)
    return out_of_range("views_per_fragment", "from 1 to frames_per_fragment");
  if (o.view_step < 1) return out_of_range("view_step", "1 or more");
  if (o.active_capacity < 1) return out_of_range("active_capacity", "1 or more");
  if (o.max_surfels < 1) return out_of_range("max_surfels", "1 or more");
  if (!(o.thin_cell_m > 0)) return out_of_range("thin_cell_m", "more than 0");
  if (!(o.merge_distance_sigmas > 0)) return out_of_range("merge_distance_sigmas", "more than 0");
  if (!(o.noise_floor_m > 0)) return out_of_range("noise_floor_m", "more than 0");
  if (!(o.noise_slope >= 0)) return out_of_range("noise_slope", "0 or more");
  if (!(o.min_normal_cosine > -1 && o.min_normal_cosine < 1))
    return out_of_range("min_normal_cosine", "between -1 and 1");
  if (!(o.min_view_cosine >= 0 && o.min_view_cosine < 1))
    return out_of_range("min_view_cosine", "from 0 to below 1");
  if (o.min_frames_seen < 1) return out_of_range("min_frames_seen", "1 or more");
  if (o.max_unconfirmed_frames < 1) return out_of_range("max_unconfirmed_frames", "1 or more");
  return {};
}

FragmentBuilder::FragmentBuilder(const FragmentOptions& options, const PinholeCamera& working,
                                 const PinholeCamera& raw, Arena& arena)
    : options_(options),
      view_camera_(raw.subsampled(options.view_step, options.view_step / 2)),
      surfels_(options, working, arena),
      thinner_(static_cast<std::size_t>(options.active_capacity), arena),
      frames_(arena.carve<FragmentFrame>("fragment/active frames",
                                         static_cast<std::size_t>(options.frames_per_fragment))),
      views_(arena.carve<ScoreView>("fragment/active views",
                                    static_cast<std::size_t>(options.views_per_fragment))),
      view_pixels_(arena.carve<float>("fragment/active view depth",
                                      static_cast<std::size_t>(options.views_per_fragment) *
                                          static_cast<std::size_t>(view_camera_.width) *
                                          static_cast<std::size_t>(view_camera_.height))) {}

bool FragmentBuilder::full() const {
  const auto beyond = [](double value, float limit) {
    return limit > 0 && value > static_cast<double>(limit);
  };
  if (frame_count_ >= options_.frames_per_fragment) return true;
  return beyond(course_.travel_m, options_.max_travel_m) || beyond(course_.turn_rad, options_.max_turn_rad) ||
         beyond(std::sqrt(course_.variance_m2), options_.max_drift_m);
}

// First order: the variances of the motions add up.
void FragmentBuilder::follow_course(const Se3& T_fragment_camera, const Matrix6d& information) {
  const Se3& T_fragment_before = frames_[static_cast<std::size_t>(frame_count_ - 1)].T_fragment_camera;
  const Se3 motion = T_fragment_before.inverse() * T_fragment_camera;
  course_.travel_m += motion.translation().norm();
  course_.turn_rad += motion.angle();
  if (options_.max_drift_m > 0)
    course_.variance_m2 += information.inverse().topLeftCorner<3, 3>().trace() / 3;
}

void FragmentBuilder::integrate(const Frame& frame, const Se3& T_odom_camera, const Matrix6d& information,
                                bool joined) {
  if (full()) return;  // the caller did not close; a frame too many is left out
  if (empty()) {
    T_odom_fragment_ = T_odom_camera;
    joined_ = joined;
  }
  const Se3 T_fragment_camera = T_odom_fragment_.inverse() * T_odom_camera;
  if (!empty()) follow_course(T_fragment_camera, information);
  new (&frames_[static_cast<std::size_t>(frame_count_)])
      FragmentFrame{frame.id, frame.timestamp_ns, T_fragment_camera, information};
  // View k is frame ⌊k · frames / views⌋: evenly spread, the first frame always among them.
  if (view_count_ < options_.views_per_fragment &&
      frame_count_ == view_count_ * options_.frames_per_fragment / options_.views_per_fragment) {
    keep_view(frame, T_fragment_camera);
  }
  surfels_.fuse(frame, T_fragment_camera);
  if (empty()) disparity_unknown_ = 0.0F;
  ++frame_count_;
  disparity_unknown_ += (frame.disparity_unknown - disparity_unknown_) / static_cast<float>(frame_count_);
}

void FragmentBuilder::keep_view(const Frame& frame, const Se3& T_fragment_camera) {
  const int width = view_camera_.width, height = view_camera_.height, step = options_.view_step;
  float* pixels = view_pixels_.data() + static_cast<std::ptrdiff_t>(view_count_) * width * height;
  for (int y = 0; y < height; ++y) {
    const std::uint16_t* row = frame.raw_depth.row(y * step + step / 2);
    const int working_row = y * frame.disparity.height / height;
    for (int x = 0; x < width; ++x) {
      const std::uint16_t raw = row[x * step + step / 2];
      const float z = static_cast<float>(raw) * frame.depth_unit_m;
      const bool valid = raw != 65535 && z >= frame.min_depth_m && z <= frame.max_depth_m;
      const float error = frame.disparity(x * frame.disparity.width / width, working_row);
      pixels[y * width + x] = valid ? z / (1.0F + z * error) : 0.0F;
    }
  }
  new (&views_[static_cast<std::size_t>(view_count_)])
      ScoreView{frame_count_, view_camera_, {pixels, width, height}, T_fragment_camera};
  ++view_count_;
}

const Fragment* FragmentBuilder::close(FragmentStore* store) {
  if (empty()) return nullptr;
  surfels_.drop_seldom_seen(std::min(options_.min_frames_seen, frame_count_));
  Fragment fragment;
  fragment.T_odom_fragment = T_odom_fragment_;
  fragment.joined_to_previous = joined_;
  fragment.frames = {frames_.data(), static_cast<std::size_t>(frame_count_)};
  fragment.views = {views_.data(), static_cast<std::size_t>(view_count_)};
  fragment.disparity_unknown = disparity_unknown_;
  const std::size_t at_most =
      std::min(static_cast<std::size_t>(options_.max_surfels), store->surfel_allowance());
  fragment.surfels = thinner_.thin(surfels_.surfels(), options_.thin_cell_m, at_most);
  const Fragment* closed = store->add(fragment);
  surfels_.clear();
  frame_count_ = view_count_ = 0;
  course_ = {};
  return closed;
}

}  // namespace loopsift
