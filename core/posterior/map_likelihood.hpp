// SPDX-License-Identifier: MIT
// The data term of the posterior: what a map explains of the measured depth, against a reference map.
//
// In: a scorer's views and fragments, and poses. Out: for each view its part of
//
//   Σ_t 2b · mean_p |D̂_t(p) − D_t(p)|   [m²; lower is better]
//
// −2b² times the log-likelihood of Laplace-distributed residuals, with b the residual that the map shows
// about itself (MapScorer::own_residual()). Silhouettes make the tails heavy; the squared sum of the
// published DMP is decided by a few per cent of the pixels. A map is compared with one of two references: the
// odometry's map, on which single loops are scored, or the best one so far, on which loops are tested.
// Support: a pixel that another fragment predicts in the reference (or, for the best map, in the odometry's)
// and none in the map keeps the reference's residual. There is no credit for what a torn map no longer
// explains.
//
// The odometry's map is kept rendered, and a new fragment is only drawn on top of it: depth buffers are
// maxima. The best map's views are rendered when they are first asked for, because a comparison looks at few
// of them.
//
// Capacity: that of the scorer. Thread: back. Does not allocate after construction.
#pragma once
#include <cstdint>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/span.hpp"
#include "core/posterior/map_scorer.hpp"

namespace loopsift {

/// Which map another one is compared with.
enum class Reference { kOdometry, kBest };

class MapLikelihood {
 public:
  /// scorer must outlive this.
  MapLikelihood(const MapScorer& scorer, Arena& arena);

  /// The odometry's map, of all fragments that the scorer holds; also becomes the best map. Returns its
  /// score. Fragments added since the last call are drawn into the old views; everything is drawn anew when
  /// old poses changed.
  double set_odometry_map(Span<const Se3> T_map_fragment);
  /// The best map. Nothing is rendered yet.
  void set_best_map(Span<const Se3> T_map_fragment);

  [[nodiscard]] Span<const Se3> poses(Reference reference) const;
  /// The view's part of the reference's own score.
  [[nodiscard]] double of_reference(Reference reference, std::size_t view);
  /// The view's part of the score of the map at these poses, supported by the reference.
  [[nodiscard]] double of_map(Reference reference, std::size_t view, Span<const Se3> T_map_fragment);

  [[nodiscard]] const MapScorer& scorer() const { return scorer_; }

 private:
  // What is kept of a view.
  struct KeptView {
    ImageView<float> odometry;  // inverse depth that other fragments predict in the odometry's map
    ImageView<float> best;      // |residual| of supported pixels in the best map; negative: not supported
    ImageView<float> trial;     // inverse depth of others in the newest trial that saw this view
    int trial_number = 0;
    float odometry_mean = 0, best_mean = 0;  // residuals, metres
    bool best_known = false;
  };
  [[nodiscard]] ImageView<float> scratch(const ScoredView& view, std::size_t which) const;
  [[nodiscard]] double in_square_metres(double mean) const { return 2.0 * scorer_.own_residual() * mean; }
  void keep_views();
  void render_best(std::size_t view);
  void begin_trial(Span<const Se3> T_map_fragment);

  const MapScorer& scorer_;
  std::size_t pixels_ = 0;  // of an image
  Span<float> store_;       // three images of every view
  Span<float> scratch_;     // two more
  std::vector<KeptView> kept_;
  std::vector<Se3> T_odometry_, T_best_, T_trial_;
  int trial_number_ = 0;  // of T_trial_
  int best_trial_ = 0;    // number of the trial that the best map was; 0: none
  bool best_is_odometry_ = true;
};

}  // namespace loopsift
