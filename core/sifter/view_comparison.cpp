// SPDX-License-Identifier: MIT
#include "core/sifter/view_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace loopsift {
namespace {

constexpr int kFewestViews = 8;            // to say anything about the rest
constexpr double kVisibleResidual = 0.05;  // of the map's own residual: what moves less does not show
constexpr double kGoldenSection = 0.6180339887498949;

}  // namespace

std::size_t spreading_stride(std::size_t n) {
  auto stride = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(kGoldenSection * static_cast<double>(n))));
  while (std::gcd(stride, n) > 1) ++stride;
  return stride;
}

// Of all views, so that it does not depend on which of them are compared.
void ViewComparer::spread_views(std::size_t view_count) {
  is_chosen_.assign(view_count, 0);
  for (const std::size_t view : views_) is_chosen_[view] = 1;
  views_.clear();
  const std::size_t stride = view_count > 0 ? spreading_stride(view_count) : 0;
  for (std::size_t k = 0, view = 0; k < view_count; ++k, view = (view + stride) % view_count)
    if (is_chosen_[view] != 0) views_.push_back(static_cast<std::uint16_t>(view));
}

ViewComparison ViewComparer::compare(MapLikelihood* likelihood, Reference reference, Span<const Se3> T_after,
                                     double prior_gain, const ComparisonLimits& limits) {
  const MapScorer& scorer = likelihood->scorer();
  scorer.affected_views(likelihood->poses(reference), T_after, kVisibleResidual * scorer.own_residual(),
                        &views_);
  spread_views(static_cast<std::size_t>(scorer.view_count()));
  const std::size_t population = views_.size();
  std::size_t most = population;
  if (limits.max_views > 0) most = std::min(most, static_cast<std::size_t>(limits.max_views));

  ViewComparison result;
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < most; ++k) {
    const std::size_t view = views_[k];
    const double d = likelihood->of_reference(reference, view) - likelihood->of_map(reference, view, T_after);
    sum += d, squares += d * d;
    ++result.views;
    const double scale = static_cast<double>(population) / result.views;
    result.gain = scale * sum + prior_gain;
    result.standard_error = scale * std::sqrt(squares);
    // At the end the standard error would be about √(views/most) of what it is now.
    const double at_the_end = result.standard_error * std::sqrt(result.views / static_cast<double>(most));
    if (limits.stop_early && result.views >= kFewestViews && result.gain + result.standard_error < at_the_end)
      break;
  }
  if (population == 0) result.gain = prior_gain;
  return result;
}

}  // namespace loopsift
