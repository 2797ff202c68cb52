// SPDX-License-Identifier: MIT
#include "core/posterior/map_likelihood.hpp"

#include <algorithm>
#include <cassert>

#include "core/posterior/residual_rows.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kImages = 3;  // of a view: odometry best trial

bool same_poses(const std::vector<Se3>& a, Span<const Se3> b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const Se3& x, const Se3& y) {
           return x.rotation() == y.rotation() && x.translation() == y.translation();
         });
}

double mean_residual(const ScoredView& view, const ImageView<float>& others) {
  return mean_over_rows(others.height, [&](int y) {
    return absolute_row(view.own.row(y), others.row(y), view.depth.row(y), others.width);
  });
}

double mean_residual(const ScoredView& view, const ImageView<float>& others, const ImageView<float>& kept) {
  return mean_over_rows(others.height, [&](int y) {
    return supported_row(view.own.row(y), others.row(y), view.depth.row(y), kept.row(y), others.width);
  });
}

// Residuals of the pixels that `others` predicts; the rest of kept stays.
void keep_residuals(const ScoredView& view, const ImageView<float>& others, const ImageView<float>& kept) {
  for (int y = 0; y < others.height; ++y)
    keep_row(view.own.row(y), others.row(y), view.depth.row(y), others.width, kept.row(y));
}

void support_nothing(const ImageView<float>& kept) {
  std::fill_n(kept.data, static_cast<std::size_t>(kept.stride) * static_cast<std::size_t>(kept.height),
              -1.0F);
}

}  // namespace

MapLikelihood::MapLikelihood(const MapScorer& scorer, Arena& arena) : scorer_(scorer) {
  const PosteriorOptions& options = scorer.options();
  pixels_ = scorer.image_capacity();
  const std::size_t fragments = static_cast<std::size_t>(options.max_fragments);
  const std::size_t views = fragments * static_cast<std::size_t>(options.max_views_per_fragment);
  store_ = arena.carve<float>("posterior/references", views * kImages * pixels_);
  scratch_ = arena.carve<float>("posterior/reference layers", 2 * pixels_);
  if (arena.measuring()) return;
  kept_.reserve(views);
  T_odometry_.reserve(fragments);
  T_best_.reserve(fragments);
  T_trial_.reserve(fragments);
}

ImageView<float> MapLikelihood::scratch(const ScoredView& view, std::size_t which) const {
  return padded_image(scratch_.data() + which * pixels_, view.camera);
}

Span<const Se3> MapLikelihood::poses(Reference reference) const {
  const bool odometry = reference == Reference::kOdometry || best_is_odometry_;
  return odometry ? T_odometry_ : T_best_;
}

void MapLikelihood::keep_views() {
  for (std::size_t v = kept_.size(); v < static_cast<std::size_t>(scorer_.view_count()); ++v) {
    const PinholeCamera& camera = scorer_.view(v).camera;
    float* images = store_.data() + v * kImages * pixels_;
    kept_.push_back({padded_image(images, camera), padded_image(images + pixels_, camera),
                     padded_image(images + 2 * pixels_, camera)});
  }
}

double MapLikelihood::set_odometry_map(Span<const Se3> T_map_fragment) {
  assert(T_map_fragment.size() == static_cast<std::size_t>(scorer_.fragment_count()));
  std::size_t fragments_known = std::min(T_odometry_.size(), T_map_fragment.size());
  if (!same_poses(T_odometry_, T_map_fragment.first(fragments_known))) fragments_known = 0;
  T_odometry_.assign(T_map_fragment.begin(), T_map_fragment.end());
  best_is_odometry_ = true;
  keep_views();
  double sum = 0;
  for (std::size_t v = 0; v < kept_.size(); ++v) {
    const ScoredView& view = scorer_.view(v);
    KeptView& kept = kept_[v];
    if (view.fragment.index() < fragments_known) {
      scorer_.render_others(view, T_map_fragment, fragments_known, T_map_fragment.size(), kept.odometry);
    } else {
      scorer_.render_others(view, T_map_fragment, kept.odometry);
    }
    kept.odometry_mean = static_cast<float>(mean_residual(view, kept.odometry));
    sum += in_square_metres(static_cast<double>(kept.odometry_mean));
  }
  return sum;
}

void MapLikelihood::set_best_map(Span<const Se3> T_map_fragment) {
  assert(T_map_fragment.size() == T_odometry_.size());
  best_is_odometry_ = same_poses(T_odometry_, T_map_fragment);
  best_trial_ = same_poses(T_trial_, T_map_fragment) ? trial_number_ : 0;
  T_best_.assign(T_map_fragment.begin(), T_map_fragment.end());
  for (KeptView& kept : kept_) kept.best_known = false;
}

// The best map is worth what it explains with the odometry's map as its support; it then supports in turn.
void MapLikelihood::render_best(std::size_t v) {
  KeptView& kept = kept_[v];
  if (kept.best_known) return;
  const ScoredView& view = scorer_.view(v);
  const bool rendered = best_trial_ > 0 && kept.trial_number == best_trial_;
  const ImageView<float> others = rendered ? kept.trial : scratch(view, 0);
  if (!rendered) scorer_.render_others(view, T_best_, others);
  support_nothing(kept.best);
  keep_residuals(view, kept.odometry, kept.best);
  kept.best_mean = static_cast<float>(mean_residual(view, others, kept.best));
  keep_residuals(view, others, kept.best);
  kept.best_known = true;
}

double MapLikelihood::of_reference(Reference reference, std::size_t v) {
  if (reference == Reference::kOdometry || best_is_odometry_)
    return in_square_metres(static_cast<double>(kept_[v].odometry_mean));
  render_best(v);
  return in_square_metres(static_cast<double>(kept_[v].best_mean));
}

void MapLikelihood::begin_trial(Span<const Se3> T_map_fragment) {
  if (same_poses(T_trial_, T_map_fragment)) return;
  T_trial_.assign(T_map_fragment.begin(), T_map_fragment.end());
  ++trial_number_;
}

double MapLikelihood::of_map(Reference reference, std::size_t v, Span<const Se3> T_map_fragment) {
  const ScoredView& view = scorer_.view(v);
  KeptView& kept = kept_[v];
  ImageView<float> support = scratch(view, 1);
  if (reference == Reference::kOdometry || best_is_odometry_) {
    support_nothing(support);
    keep_residuals(view, kept.odometry, support);
  } else {
    render_best(v);
    support = kept.best;
  }
  begin_trial(T_map_fragment);
  scorer_.render_others(view, T_map_fragment, kept.trial);
  kept.trial_number = trial_number_;
  return in_square_metres(mean_residual(view, kept.trial, support));
}

}  // namespace loopsift
