// SPDX-License-Identifier: MIT
// The dense map posterior as published: how well the map, moved rigidly by fragments, predicts the depth that
// was measured. (Its form for sifting: map_likelihood.hpp.)
//
// In: closed fragments (their surfels thinned to discs, their views), and a pose for each. Out: DMP in m², a
// sum over views; lower is better. Capacity: PosteriorOptions. Thread: back. Scoring does not allocate.
//
// Zhang & Chen, "A metric for evaluating 3D reconstruction and mapping performance with no ground truthing"
// (2021):
//   DMP(T, Z) = Σ_t 1/|Ω_t| Σ_{p∈Ω_t} (D̂_t(p) − D_t(p))²
// with D̂_t rendered from the map at view t and Ω_t the pixels where D̂_t and D_t are both valid.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/ids.hpp"
#include "core/fragment/fragment.hpp"
#include "core/posterior/disc_renderer.hpp"
#include "core/posterior/score_surfels.hpp"

namespace loopsift {

/// Lengths in metres. Values of DMP compare only within one setting of these.
struct PosteriorOptions {
  float min_depth_m = 0.3F;  ///< measured and predicted depth outside [min, max] does not count
  float max_depth_m = 6.0F;
  float disc_spacing_m = 0.05F;  ///< voxel edge to which a fragment's surfels are thinned for scoring
  float disc_radius_m = 0.05F;   ///< radius of the discs
  int max_fragments = 360;
  int max_discs_per_fragment = 4000;
  int max_views_per_fragment = 2;
  int max_view_width = 40;  ///< pixels; larger views are left out
  int max_view_height = 30;
};

/// A DMP, or the part of it that was enough to know that it is above the limit.
struct MapScore {
  double value = 0;  ///< m², sum over views
  int views_rendered = 0;
  bool complete = true;  ///< false: given up above the limit; value is then a lower bound
};

/// A frame kept for scoring, as the scorer holds it.
struct ScoredView {
  FragmentId fragment;
  Se3 T_camera_fragment;
  PinholeCamera camera;
  ImageView<float> depth;  ///< measured, metres, 0 invalid
  ImageView<float> own;    ///< inverse depth that the view's own fragment predicts, 0 where none
};

class MapScorer {
 public:
  /// Carves its stores; see Arena for when the constructor runs twice.
  MapScorer(const PosteriorOptions& options, Arena& arena);

  /// Adds the next fragment (id must equal fragment_count()). False when the store is full: nothing is added.
  [[nodiscard]] bool add(const Fragment& fragment);
  [[nodiscard]] const PosteriorOptions& options() const { return options_; }
  /// Elements that the image of any view may take, padding included.
  [[nodiscard]] std::size_t image_capacity() const;
  [[nodiscard]] int fragment_count() const { return static_cast<int>(fragments_.size()); }
  [[nodiscard]] int view_count() const { return static_cast<int>(views_.size()); }
  /// Discs that did not fit max_discs_per_fragment, over all fragments.
  [[nodiscard]] std::size_t discs_left_out() const { return discs_left_out_; }

  /// DMP of the map with fragments at T_map_fragment (one pose per fragment). view_values, where not empty,
  /// receives each view's part (size view_count(); all of them only when the score is complete). Ends early,
  /// and exactly, once the sum is above give_up_above.
  [[nodiscard]] MapScore dmp(Span<const Se3> T_map_fragment, Span<float> view_values = {},
                             double give_up_above = std::numeric_limits<double>::infinity()) const;

  /// Σ_t |Ω_t| of the map at these poses: pixels with measured and predicted depth, over all views.
  [[nodiscard]] std::int64_t valid_pixels(Span<const Se3> T_map_fragment) const;

  /// Views, ascending, whose score may differ between two maps: those of fragments to which another one in
  /// reach moves by more than least_motion_m. With 0 the others' scores are the same, but for what shows
  /// through holes in their own fragment's surface.
  void affected_views(Span<const Se3> T_before, Span<const Se3> T_after, double least_motion_m,
                      std::vector<std::uint16_t>* views) const;

  [[nodiscard]] const ScoredView& view(std::size_t v) const { return views_[v]; }
  /// Splats fragments first … last−1, without the view's own, into layer (inverse depth; of the view's size,
  /// with a padded_stride).
  void render_others(const ScoredView& view, Span<const Se3> T_map_fragment, std::size_t first,
                     std::size_t last, const ImageView<float>& layer) const;
  /// The same from nothing, with all fragments.
  void render_others(const ScoredView& view, Span<const Se3> T_map_fragment,
                     const ImageView<float>& layer) const;

  /// b: the scale of a Laplace distribution with the median of the absolute residuals that the views show
  /// against their own fragments, metres (median / ln 2: silhouettes must not count). It is the map's own
  /// statement about its noise, and the unit in which the posterior weighs depth against odometry.
  [[nodiscard]] double own_residual() const { return own_residual_; }

  /// Mean measured depth of the views, metres.
  [[nodiscard]] double typical_depth() const { return depth_count_ > 0 ? depth_sum_ / depth_count_ : 0.0; }

  /// Evidence between two relative poses of a pair of fragments, m²: the pair's views are rendered with both,
  /// and over the pixels that the other fragment predicts under both, Σ_views 1/|Ω| Σ_p (r_first − r_second).
  /// Negative: the first explains the measurements better.
  [[nodiscard]] double compare_pair(FragmentId i, FragmentId j, const Se3& T_i_j_first,
                                    const Se3& T_i_j_second) const;
  /// Whether the first explains them better than each of the others; the first is rendered once.
  [[nodiscard]] bool explains_pair_best(FragmentId i, FragmentId j, const Se3& T_i_j_first,
                                        Span<const Se3> T_i_j_others) const;

  /// Which of the others explains them best, where that is better than the first does; −1: none does.
  [[nodiscard]] int better_for_pair(FragmentId i, FragmentId j, const Se3& T_i_j_first,
                                    Span<const Se3> T_i_j_others) const;

  /// Mean position of a fragment's discs, fragment frame.
  [[nodiscard]] Eigen::Vector3d centroid(FragmentId f) const;

 private:
  struct ScoredFragment {
    ScoreSurfels surfels;
    Eigen::Vector3f center = Eigen::Vector3f::Zero();
    float radius = 0;  // of the discs about the centre
    double reach = 0;  // and of the views' cameras
  };
  void add_views(const Fragment& fragment);
  [[nodiscard]] ImageView<float> layer_for(const ScoredView& view, std::size_t which) const;
  void render_pair(FragmentId i, FragmentId j, const Se3& T_i_j) const;
  void render_pair_view(const ScoredView& view, FragmentId i, FragmentId j, const Se3& T_i_j,
                        const ImageView<float>& layer) const;
  [[nodiscard]] double rendered_pair_against(FragmentId i, FragmentId j, const Se3& T_i_j) const;
  void weigh_own(const ScoredView& view);

  PosteriorOptions options_;
  Span<float> disc_store_;  // 7 arrays of max_discs_per_fragment per fragment
  Span<SurfelChunk> chunk_store_;
  Span<float> view_store_;                 // depth, own of every view
  Span<float> layer_store_;                // a scratch layer, and one for each view of a pair
  std::vector<ScoredFragment> fragments_;  // capacity reserved
  std::vector<ScoredView> views_;
  ThinScratch scratch_;
  mutable std::vector<std::uint8_t> affected_;  // scratch of affected_views(), by fragment
  mutable std::vector<Se3> motion_;
  mutable std::vector<Eigen::Vector3d> center_;
  double depth_sum_ = 0, depth_count_ = 0;           // of measured pixels
  std::array<std::uint32_t, 1024> own_histogram_{};  // own residuals, in millimetres; the last bin is open
  double own_residual_ = 0;
  std::size_t discs_left_out_ = 0;
};

}  // namespace loopsift
