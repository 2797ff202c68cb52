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
#include "core/fragment/fragment.hpp"
#include "core/fragment/fragment_store.hpp"
#include "core/frame/frame.hpp"

namespace loopsift {

struct FragmentOptions {
  int frames_per_fragment = 50;
  int views_per_fragment = 3;    ///< frames kept for scoring, evenly spread
  int view_step = 8;             ///< raw pixels per view pixel in each direction
  int active_capacity = 250000;  ///< surfels of the fragment being built
  int max_surfels = 40000;       ///< of a closed fragment; a larger one is thinned more coarsely
  float thin_cell_m = 0.02F;     ///< closed fragments keep about one surfel per cube of this edge and side
  float merge_distance_sigmas = 3.0F;  ///< a measurement within this many σ(z) of a surfel is of that surfel
  float noise_floor_m = 0.0012F;       ///< σ(z) as in OdometryOptions
  float noise_slope = 0.0019F;         ///< per metre
  float min_normal_cosine = 0.5F;      ///< two sides of a thin thing have normals farther apart: never merged
  float min_view_cosine = 0.2F;        ///< measurements at more grazing angles are not fused
  int min_frames_seen = 3;             ///< surfels seen in fewer frames are dropped at closing
  int max_unconfirmed_frames =
      10;  ///< a surfel seen in fewer frames than that must be confirmed within these
};
[[nodiscard]] Status validate(const FragmentOptions& options);

class FragmentBuilder {
 public:
  /// working is the camera of Frame::levels[0], raw that of Frame::raw_depth.
  FragmentBuilder(const FragmentOptions& options, const PinholeCamera& working, const PinholeCamera& raw,
                  Arena& arena);
  ~FragmentBuilder() = default;
  FragmentBuilder(const FragmentBuilder&) = delete;
  FragmentBuilder& operator=(const FragmentBuilder&) = delete;

  /// Adds a frame at its pose; the first one after construction or close() begins a fragment. information is
  /// of the motion since the frame before; joined says, for a first frame, whether the odometry held since
  /// then.
  void integrate(const Frame& frame, const Se3& T_odom_camera, const Matrix6d& information, bool joined);
  /// frames_per_fragment are in.
  [[nodiscard]] bool full() const { return frame_count_ >= options_.frames_per_fragment; }
  [[nodiscard]] bool empty() const { return frame_count_ == 0; }
  /// Thins the active surfels, moves all into the store and is empty afterwards. Null when empty() or when
  /// the store is full.
  const Fragment* close(FragmentStore* store);

  /// Surfels so far, in the frame of the active fragment.
  [[nodiscard]] SurfelSpan active_surfels() const { return slice(surfels_, 0, surfel_count_); }
  [[nodiscard]] const Se3& T_odom_fragment() const { return T_odom_fragment_; }
  /// Most surfels that were ever active, and surfels that found no room.
  [[nodiscard]] std::size_t high_water() const { return high_water_; }
  [[nodiscard]] std::uint64_t refused_surfels() const { return refused_surfels_; }

 private:
  void keep_view(const Frame& frame, const Se3& T_fragment_camera);
  void render_index_map(const Se3& T_fragment_camera);
  void fuse(const Frame& frame, const Se3& T_fragment_camera);
  void remove_unstable(int frame);
  std::size_t thin();

  FragmentOptions options_;
  PinholeCamera camera_, view_camera_;
  SurfelSpan surfels_;
  Span<std::uint16_t> seen_;  // frames in which each surfel was measured
  std::size_t surfel_count_ = 0, high_water_ = 0;
  std::uint64_t refused_surfels_ = 0;
  Span<std::int32_t> index_;  // surfel behind each working pixel, −1 for none
  Span<float> index_depth_;
  Span<FragmentFrame> frames_;
  Span<ScoreView> views_;
  Span<float> view_pixels_;
  Span<std::int32_t> cells_;  // hash table of the thinning
  Se3 T_odom_fragment_;
  bool joined_ = false;
  int frame_count_ = 0, view_count_ = 0;
};

}  // namespace loopsift
