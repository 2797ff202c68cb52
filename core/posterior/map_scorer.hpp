// SPDX-License-Identifier: MIT
// The dense map posterior's data term: how well the map, moved rigidly by fragments, predicts the depth that
// was measured.
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

/// Which sum over the pixels, and what happens to pixels that lose the prediction of other fragments.
enum class ScoreKind {
  /// The paper's: squared residuals, DMP in m².
  kPlain,
  /// The likelihood of the posterior: residuals of a Laplace distribution (silhouettes make their tails
  /// heavy; the
  /// squared sum is decided by a few per cent of the pixels), Σ_t 2b · mean |D̂_t − D_t| in m², with b the
  /// mean residual that
  /// the map shows about itself. A pixel that another fragment predicted in the reference map and none
  /// predicts now keeps
  /// its residual: no credit for what a torn map no longer explains.
  kPosterior,
};

/// A score, or the part of it that was enough to know that it is above the limit.
struct MapScore {
  double value = 0;  ///< m², sum over views
  int views_rendered = 0;
  bool complete = true;  ///< false: given up above the limit; value is then a lower bound
};

/// How score() may save work. All exact.
struct ScoreLimits {
  /// Give up once the sum, with the least that the views not yet rendered can add, is above this.
  double give_up_above = std::numeric_limits<double>::infinity();
  /// Views to look at first (indices below view_count(), each at most once): those most likely to tell.
  Span<const std::uint16_t> first_views;
};

class MapScorer {
 public:
  /// Carves its stores; see Arena for when the constructor runs twice.
  MapScorer(const PosteriorOptions& options, Arena& arena);

  /// Adds the next fragment (id must equal fragment_count()). False when the store is full: nothing is added.
  [[nodiscard]] bool add(const Fragment& fragment);
  [[nodiscard]] int fragment_count() const { return static_cast<int>(fragments_.size()); }
  [[nodiscard]] int view_count() const { return static_cast<int>(views_.size()); }
  /// Discs that did not fit max_discs_per_fragment, over all fragments.
  [[nodiscard]] std::size_t discs_left_out() const { return discs_left_out_; }

  /// The score of the map with fragments at T_map_fragment (one pose per fragment). view_values, where not
  /// empty, receives each view's part (size view_count(); all of them only when
  /// the score is complete).
  [[nodiscard]] MapScore score(Span<const Se3> T_map_fragment, ScoreKind kind, const ScoreLimits& limits = {},
                               Span<float> view_values = {}) const;

  /// Σ_t |Ω_t| of the map at these poses: pixels with measured and predicted depth, over all views.
  [[nodiscard]] std::int64_t valid_pixels(Span<const Se3> T_map_fragment) const;

  /// Forgets the reference map: no pixel is supported.
  void clear_reference();
  /// Makes the map at these poses the reference for support. Support is sticky: a pixel that kept its
  /// residual stays supported with it, else tearing a map apart in two steps would pay where one step does
  /// not. Returns the map's score as it was against the reference before; view_values as in score().
  double set_reference(Span<const Se3> T_map_fragment, ScoreKind kind = ScoreKind::kPosterior,
                       Span<float> view_values = {});
  /// There is a second reference, put aside: exchanges the two, and makes the one put aside the same as the
  /// one in use.
  void swap_references();
  void copy_reference();

  /// One view's part of the score.
  [[nodiscard]] double view_score(std::size_t view, Span<const Se3> T_map_fragment, ScoreKind kind) const;
  /// Views, ascending, whose score may differ between two maps: those of fragments to which another one in
  /// reach moves by more than least_motion_m. With 0 the others' scores are the same, but for what shows
  /// through holes in their own fragment's surface.
  void affected_views(Span<const Se3> T_before, Span<const Se3> T_after, double least_motion_m,
                      std::vector<std::uint16_t>* views) const;

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

  /// Mean position of a fragment's discs, fragment frame.
  [[nodiscard]] Eigen::Vector3d centroid(FragmentId f) const;

 private:
  struct ScoredFragment {
    ScoreSurfels surfels;
    Eigen::Vector3f center = Eigen::Vector3f::Zero();
    float radius = 0;  // of the discs about the centre
    double reach = 0;  // and of the views' cameras
  };
  struct ScoredView {
    FragmentId fragment;
    Se3 T_camera_fragment;
    PinholeCamera camera;
    ImageView<float> depth;  // measured, metres, 0 invalid
    ImageView<float> own;    // inverse depth that the view's own fragment predicts
    ImageView<float> kept;   // |residual| of supported pixels in the reference map; negative: not supported
    ImageView<float> aside;  // kept of the reference put aside
    double least = 0;  // no map brings the mean residual below it: own surface in front of the measurement
  };

  void add_views(const Fragment& fragment);
  // Inverse depth of all fragments but the view's own.
  void render_others(const ScoredView& view, Span<const Se3> T_map_fragment,
                     const ImageView<float>& layer) const;
  [[nodiscard]] double value_of(const ScoredView& view, const ImageView<float>& others, ScoreKind kind) const;
  [[nodiscard]] std::size_t image_capacity() const;
  [[nodiscard]] ImageView<float> layer_for(const ScoredView& view, std::size_t which) const;
  void weigh_own(ScoredView* view);

  PosteriorOptions options_;
  Span<float> disc_store_;  // 7 arrays of max_discs_per_fragment per fragment
  Span<SurfelChunk> chunk_store_;
  Span<float> view_store_;                 // depth, own, kept, aside of every view
  Span<float> layer_store_;                // two scratch layers
  std::vector<ScoredFragment> fragments_;  // capacity reserved
  std::vector<ScoredView> views_;
  ThinScratch scratch_;
  mutable std::vector<std::uint8_t> affected_;  // scratch of affected_views(), by fragment
  mutable std::vector<Se3> motion_;
  mutable std::vector<Eigen::Vector3d> center_;
  Span<std::uint8_t> visited_;                       // scratch of score(): views already looked at
  double depth_sum_ = 0, depth_count_ = 0;           // of measured pixels
  std::array<std::uint32_t, 1024> own_histogram_{};  // own residuals, in millimetres; the last bin is open
  double own_residual_ = 0;
  std::size_t discs_left_out_ = 0;
};

}  // namespace loopsift
