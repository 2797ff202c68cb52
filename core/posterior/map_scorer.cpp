// SPDX-License-Identifier: MIT
#include "core/posterior/map_scorer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/simd.hpp"

namespace loopsift {
namespace {

constexpr int kDiscArrays = 7;  // x y z nx ny nz radius
constexpr int kViewImages = 3;  // depth own kept

std::size_t chunks_for(int discs) { return (static_cast<std::size_t>(discs) + kChunkSize - 1) / kChunkSize; }

void fill(const ImageView<float>& image, float value) {
  std::fill_n(image.data, static_cast<std::size_t>(image.stride) * static_cast<std::size_t>(image.height),
              value);
}

ImageView<float> padded_image(float* data, const PinholeCamera& camera) {
  return {data, camera.width, camera.height, padded_stride(camera.width)};
}

// |1/inverse − measured|, 0 where one of the two is missing; *counts says whether the pixel is in Ω.
inline __attribute__((always_inline)) float residual(float inverse, float measured, float* counts) {
  const bool valid = (inverse > 0.0F) & (measured > 0.0F);
  const float e = std::abs(1.0F / (inverse > 0.0F ? inverse : 1.0F) - measured);
  *counts = valid ? 1.0F : 0.0F;
  return valid ? e : 0.0F;
}

struct PixelSum {
  double residuals = 0;
  double pixels = 0;
  [[nodiscard]] double mean() const { return pixels > 0 ? residuals / pixels : 0.0; }
};

// Row by row, so that single-precision lanes sum only a row and the order is fixed.
LOOPSIFT_SIMD PixelSum squared_row(const float* own, const float* other, const float* depth, int n) {
  float residuals = 0, pixels = 0;
#pragma omp simd reduction(+ : residuals, pixels)
  for (int x = 0; x < n; ++x) {
    float counts = 0;
    const float e = residual(std::max(own[x], other[x]), depth[x], &counts);
    residuals += e * e;
    pixels += counts;
  }
  return {static_cast<double>(residuals), static_cast<double>(pixels)};
}

LOOPSIFT_SIMD PixelSum supported_row(const float* own, const float* other, const float* depth,
                                     const float* kept, int n) {
  float residuals = 0, pixels = 0;
#pragma omp simd reduction(+ : residuals, pixels)
  for (int x = 0; x < n; ++x) {
    float counts = 0;
    const float e = residual(std::max(own[x], other[x]), depth[x], &counts);
    const bool keeps = (kept[x] >= 0.0F) & (other[x] <= 0.0F);
    residuals += keeps ? kept[x] : e;
    pixels += (keeps & (depth[x] > 0.0F)) ? 1.0F : counts;
  }
  return {static_cast<double>(residuals), static_cast<double>(pixels)};
}

LOOPSIFT_SIMD PixelSum compare_row(const float* own, const float* first, const float* second,
                                   const float* depth, int n) {
  float difference = 0, pixels = 0;
#pragma omp simd reduction(+ : difference, pixels)
  for (int x = 0; x < n; ++x) {
    float counts = 0, ignored = 0;
    const float a = residual(std::max(own[x], first[x]), depth[x], &counts);
    const float b = residual(std::max(own[x], second[x]), depth[x], &ignored);
    const bool both = (first[x] > 0.0F) & (second[x] > 0.0F);
    difference += both ? a - b : 0.0F;
    pixels += counts;
  }
  return {static_cast<double>(difference), static_cast<double>(pixels)};
}

constexpr float kPerMillimetre = 1e3F;

// Scale of the Laplace distribution with the histogram's median (in millimetre bins), metres.
double laplace_scale(const std::array<std::uint32_t, 1024>& histogram) {
  std::uint64_t total = 0, below = 0;
  for (const std::uint32_t count : histogram) total += count;
  for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
    const std::uint32_t count = histogram[bin];
    if (2 * (below + count) > total) {
      const double inside =
          (0.5 * static_cast<double>(total) - static_cast<double>(below)) / static_cast<double>(count);
      return (static_cast<double>(bin) + inside) * 1e-3 / std::log(2.0);
    }
    below += count;
  }
  return 0.0;
}

template <class Row>
double mean_over_rows(int height, const Row& row) {
  PixelSum sum;
  for (int y = 0; y < height; ++y) {
    const PixelSum r = row(y);
    sum.residuals += r.residuals;
    sum.pixels += r.pixels;
  }
  return sum.mean();
}

}  // namespace

std::size_t MapScorer::image_capacity() const {
  return static_cast<std::size_t>(padded_stride(options_.max_view_width)) *
         static_cast<std::size_t>(options_.max_view_height);
}

MapScorer::MapScorer(const PosteriorOptions& options, Arena& arena) : options_(options) {
  const auto fragments = static_cast<std::size_t>(options.max_fragments);
  const std::size_t views = fragments * static_cast<std::size_t>(options.max_views_per_fragment);
  const std::size_t pixels = image_capacity();
  disc_store_ = arena.carve<float>(
      "posterior/discs", fragments * kDiscArrays * static_cast<std::size_t>(options.max_discs_per_fragment));
  chunk_store_ =
      arena.carve<SurfelChunk>("posterior/chunks", fragments * chunks_for(options.max_discs_per_fragment));
  view_store_ = arena.carve<float>("posterior/views", views * kViewImages * pixels);
  layer_store_ = arena.carve<float>("posterior/layers", 2 * pixels);
  visited_ = arena.carve<std::uint8_t>("posterior/visited", views);
  if (arena.measuring()) return;
  fragments_.reserve(fragments);
  views_.reserve(views);
}

bool MapScorer::add(const Fragment& fragment) {
  assert(fragment.id.value == fragment_count());
  if (fragment_count() >= options_.max_fragments) return false;
  ScoredFragment scored;
  const auto discs = static_cast<std::size_t>(options_.max_discs_per_fragment);
  float* store = &disc_store_[fragments_.size() * kDiscArrays * discs];
  ScoreSurfels& s = scored.surfels;
  for (Span<float>* array : {&s.x, &s.y, &s.z, &s.nx, &s.ny, &s.nz, &s.radius}) {
    *array = Span<float>(store, discs);
    store += discs;
  }
  const std::size_t chunks = chunks_for(options_.max_discs_per_fragment);
  s.chunks = Span<SurfelChunk>(&chunk_store_[fragments_.size() * chunks], chunks);
  discs_left_out_ += thin(fragment.surfels, options_.disc_spacing_m, options_.disc_radius_m, &scratch_, &s);

  for (const SurfelChunk& c : s.chunks) scored.center += c.center;
  if (!s.chunks.empty()) scored.center /= static_cast<float>(s.chunks.size());
  for (const SurfelChunk& c : s.chunks) {
    scored.radius = std::max(scored.radius, (c.center - scored.center).norm() + c.radius);
  }
  fragments_.push_back(scored);
  add_views(fragment);
  return true;
}

void MapScorer::add_views(const Fragment& fragment) {
  const std::size_t pixels = image_capacity();
  int added = 0;
  for (const ScoreView& v : fragment.views) {
    if (added == options_.max_views_per_fragment) break;
    if (v.camera.width > options_.max_view_width || v.camera.height > options_.max_view_height) continue;
    float* store = &view_store_[views_.size() * kViewImages * pixels];
    ScoredView view{fragment.id,
                    v.T_fragment_camera.inverse(),
                    v.camera,
                    padded_image(store, v.camera),
                    padded_image(store + pixels, v.camera),
                    padded_image(store + 2 * pixels, v.camera),
                    0.0};
    for (int y = 0; y < v.camera.height; ++y) {
      for (int x = 0; x < v.camera.width; ++x) {
        const float d = v.depth_m(x, y);
        view.depth(x, y) = d > options_.min_depth_m && d < options_.max_depth_m ? d : 0.0F;
      }
    }
    fill(view.own, 0.0F);
    fill(view.kept, -1.0F);
    render_discs(fragments_.back().surfels, view.T_camera_fragment, view.camera, options_.min_depth_m,
                 options_.max_depth_m, view.own);
    weigh_own(&view);
    views_.push_back(view);
    ++added;
  }
  own_residual_ = laplace_scale(own_histogram_);
}

// The view against its own fragment: its part of own_residual(), and the least that it can come to. Where the
// own surface lies in front of the measurement no other fragment can make the prediction better, only nearer.
void MapScorer::weigh_own(ScoredView* view) {
  double in_front = 0, measured = 0;
  for (int y = 0; y < view->depth.height; ++y) {
    for (int x = 0; x < view->depth.width; ++x) {
      const float depth = view->depth(x, y), own = view->own(x, y);
      measured += depth > 0.0F ? 1.0 : 0.0;
      depth_sum_ += static_cast<double>(depth);
      float counts = 0;
      const float e = residual(own, depth, &counts);
      if (counts == 0.0F) continue;
      ++own_histogram_[std::min(own_histogram_.size() - 1, static_cast<std::size_t>(e * kPerMillimetre))];
      if (own * depth > 1.0F) in_front += static_cast<double>(e);
    }
  }
  depth_count_ += measured;
  view->least = measured > 0 ? in_front / measured : 0.0;
}

ImageView<float> MapScorer::layer_for(const ScoredView& view, std::size_t which) const {
  return padded_image(layer_store_.data() + which * image_capacity(), view.camera);
}

void MapScorer::render_others(const ScoredView& view, Span<const Se3> T_map_fragment,
                              const ImageView<float>& layer) const {
  fill(layer, 0.0F);
  const Se3 T_camera_map = view.T_camera_fragment * T_map_fragment[view.fragment.index()].inverse();
  for (std::size_t f = 0; f < fragments_.size(); ++f) {
    if (f == view.fragment.index()) continue;
    render_discs(fragments_[f].surfels, T_camera_map * T_map_fragment[f], view.camera, options_.min_depth_m,
                 options_.max_depth_m, layer);
  }
}

double MapScorer::view_value(const ScoredView& view, Span<const Se3> T_map_fragment, ScoreKind kind) const {
  const ImageView<float> layer = layer_for(view, 0);
  render_others(view, T_map_fragment, layer);
  if (kind == ScoreKind::kPlain) {
    return mean_over_rows(layer.height, [&](int y) {
      return squared_row(view.own.row(y), layer.row(y), view.depth.row(y), layer.width);
    });
  }
  const double mean = mean_over_rows(layer.height, [&](int y) {
    return supported_row(view.own.row(y), layer.row(y), view.depth.row(y), view.kept.row(y), layer.width);
  });
  return 2.0 * own_residual_ * mean;
}

MapScore MapScorer::score(Span<const Se3> T_map_fragment, ScoreKind kind, const ScoreLimits& limits,
                          Span<float> view_values) const {
  assert(T_map_fragment.size() == fragments_.size());
  const auto least = [&](const ScoredView& v) {
    return kind == ScoreKind::kPosterior ? 2.0 * own_residual_ * v.least : 0.0;
  };
  double still_to_come = 0;
  for (const ScoredView& view : views_) still_to_come += least(view);
  std::fill_n(visited_.data(), views_.size(), std::uint8_t{0});

  MapScore result;
  const auto look_at = [&](std::size_t v) {  // false: given up
    if (visited_[v] != 0) return true;
    visited_[v] = 1;
    const double value = view_value(views_[v], T_map_fragment, kind);
    result.value += value;
    still_to_come -= least(views_[v]);
    ++result.views_rendered;
    if (!view_values.empty()) view_values[v] = static_cast<float>(value);
    return result.value + still_to_come <= limits.give_up_above;
  };
  for (const std::uint16_t v : limits.first_views) result.complete = result.complete && look_at(v);
  for (std::size_t v = 0; v < views_.size(); ++v) result.complete = result.complete && look_at(v);
  if (!result.complete) result.value += still_to_come;
  return result;
}

std::int64_t MapScorer::valid_pixels(Span<const Se3> T_map_fragment) const {
  std::int64_t count = 0;
  for (const ScoredView& view : views_) {
    const ImageView<float> layer = layer_for(view, 0);
    render_others(view, T_map_fragment, layer);
    for (int y = 0; y < layer.height; ++y) {
      for (int x = 0; x < layer.width; ++x)
        count += view.depth(x, y) > 0.0F && std::max(view.own(x, y), layer(x, y)) > 0.0F ? 1 : 0;
    }
  }
  return count;
}

void MapScorer::clear_reference() {
  for (const ScoredView& view : views_) fill(view.kept, -1.0F);
}

void MapScorer::set_reference(Span<const Se3> T_map_fragment) {
  for (const ScoredView& view : views_) {
    const ImageView<float> layer = layer_for(view, 0);
    render_others(view, T_map_fragment, layer);
    for (int y = 0; y < layer.height; ++y) {
      for (int x = 0; x < layer.width; ++x) {
        if (layer(x, y) <= 0.0F) continue;
        float counts = 0;
        view.kept(x, y) = residual(std::max(view.own(x, y), layer(x, y)), view.depth(x, y), &counts);
      }
    }
  }
}

double MapScorer::compare_pair(FragmentId i, FragmentId j, const Se3& T_i_j_first,
                               const Se3& T_i_j_second) const {
  double sum = 0;
  for (const ScoredView& view : views_) {
    if (view.fragment != i && view.fragment != j) continue;
    const bool in_i = view.fragment == i;
    const auto render = [&](const Se3& T_i_j, const ImageView<float>& layer) {
      fill(layer, 0.0F);
      const Se3 T_own_other = in_i ? T_i_j : T_i_j.inverse();
      render_discs(fragments_[in_i ? j.index() : i.index()].surfels, view.T_camera_fragment * T_own_other,
                   view.camera, options_.min_depth_m, options_.max_depth_m, layer);
    };
    const ImageView<float> first = layer_for(view, 0), second = layer_for(view, 1);
    render(T_i_j_first, first);
    render(T_i_j_second, second);
    sum += mean_over_rows(first.height, [&](int y) {
      return compare_row(view.own.row(y), first.row(y), second.row(y), view.depth.row(y), first.width);
    });
  }
  return sum;
}

Eigen::Vector3d MapScorer::centroid(FragmentId f) const {
  return fragments_[f.index()].center.cast<double>();
}

}  // namespace loopsift
