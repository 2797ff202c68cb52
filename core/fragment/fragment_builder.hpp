// SPDX-License-Identifier: MIT
// Fuses frames with known poses into the surfels of the active fragment (Keller et al., Point-based fusion,
// 2013: index-map association, weighted update, confidence, free-space removal), and closes it into a store.
// In: Frames and T_odom_camera from any odometry. Out: a closed Fragment of thinned surfels with views for
// scoring. Capacity: FragmentOptions; surfels past active_capacity are not added and counted. Thread: front.
// No allocation after construction.
#pragma once
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/base/result.hpp"
#include "core/fragment/active_surfels.hpp"
#include "core/fragment/fragment.hpp"
#include "core/fragment/fragment_options.hpp"
#include "core/fragment/fragment_store.hpp"
#include "core/fragment/thinner.hpp"
#include "core/frame/frame.hpp"

namespace loopsift {

class FragmentBuilder {
 public:
  /// working is the camera of Frame::levels[0], raw that of Frame::raw_depth.
  FragmentBuilder(const FragmentOptions& options, const PinholeCamera& working, const PinholeCamera& raw,
                  Arena& arena);

  /// Adds a frame at its pose; the first one after construction or close() begins a fragment. information is
  /// of the motion since the frame before; joined says, for a first frame, whether the odometry held since
  /// then.
  void integrate(const Frame& frame, const Se3& T_odom_camera, const Matrix6d& information, bool joined);
  /// Time to close: frames_per_fragment are in, or the camera has gone, turned or may have drifted as far as
  /// the options allow (but never before there is a second frame).
  [[nodiscard]] bool full() const;
  [[nodiscard]] bool empty() const { return frame_count_ == 0; }
  /// Thins the active surfels, moves all into the store and is empty afterwards. Null when empty() or when
  /// the store is full.
  const Fragment* close(FragmentStore* store);

  /// Surfels so far, in the frame of the active fragment; with capacity, high-water mark and refusals.
  [[nodiscard]] const ActiveSurfels& active() const { return surfels_; }
  [[nodiscard]] const Se3& T_odom_fragment() const { return T_odom_fragment_; }
  /// Fragment::disparity_unknown so far.
  [[nodiscard]] float disparity_unknown() const { return disparity_unknown_; }

 private:
  /// What has summed up since the first frame.
  struct Course {
    double travel_m = 0, turn_rad = 0, variance_m2 = 0;  ///< variance of the position, per axis
  };
  void keep_view(const Frame& frame, const Se3& T_fragment_camera);
  void follow_course(const Se3& T_fragment_camera, const Matrix6d& information);

  FragmentOptions options_;
  PinholeCamera view_camera_;
  ActiveSurfels surfels_;
  Thinner thinner_;
  Span<FragmentFrame> frames_;
  Span<ScoreView> views_;
  Span<float> view_pixels_;
  Se3 T_odom_fragment_;
  Course course_;
  bool joined_ = false;
  float disparity_unknown_ = 1.0F;
  int frame_count_ = 0, view_count_ = 0;
};

}  // namespace loopsift
