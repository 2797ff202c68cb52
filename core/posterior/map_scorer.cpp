// SPDX-License-Identifier: MIT
#include "core/posterior/map_scorer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/posterior/residual_rows.hpp"

namespace loopsift {
namespace {

constexpr int kDiscArrays = 7;  // x y z nx ny nz radius
constexpr int kViewImages = 2;  // depth own

std::size_t chunks_for(int discs) { return (static_cast<std::size_t>(discs) + kChunkSize - 1) / kChunkSize; }

void fill(const ImageView<float>& image, float value) {
  std::fill_n(image.data, static_cast<std::size_t>(image.stride) * static_cast<std::size_t>(image.height),
              value);
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
  layer_store_ = arena.carve<float>(
      "posterior/layers", (1 + 2 * static_cast<std::size_t>(options.max_views_per_fragment)) * pixels);
  if (arena.measuring()) return;
  fragments_.reserve(fragments);
  views_.reserve(views);
  affected_.reserve(fragments);
  motion_.reserve(fragments);
  center_.reserve(2 * fragments);
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
  scored.reach = static_cast<double>(scored.radius);
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
    ScoredView view{fragment.id, v.T_fragment_camera.inverse(), v.camera, padded_image(store, v.camera),
                    padded_image(store + pixels, v.camera)};
    for (int y = 0; y < v.camera.height; ++y) {
      for (int x = 0; x < v.camera.width; ++x) {
        const float d = v.depth_m(x, y);
        view.depth(x, y) = d > options_.min_depth_m && d < options_.max_depth_m ? d : 0.0F;
      }
    }
    fill(view.own, 0.0F);
    render_discs(fragments_.back().surfels, view.T_camera_fragment, view.camera, options_.min_depth_m,
                 options_.max_depth_m, view.own);
    weigh_own(view);
    views_.push_back(view);
    ScoredFragment& own = fragments_.back();
    const Eigen::Vector3d eye = v.T_fragment_camera.translation() - own.center.cast<double>();
    own.reach = std::max(own.reach, eye.norm());
    ++added;
  }
  own_residual_ = laplace_scale(own_histogram_);
}

// The view against its own fragment: its part of own_residual() and of typical_depth().
void MapScorer::weigh_own(const ScoredView& view) {
  for (int y = 0; y < view.depth.height; ++y) {
    for (int x = 0; x < view.depth.width; ++x) {
      const float depth = view.depth(x, y);
      depth_count_ += depth > 0.0F ? 1.0 : 0.0;
      depth_sum_ += static_cast<double>(depth);
      float counts = 0;
      const float e = residual(view.own(x, y), depth, &counts);
      if (counts == 0.0F) continue;
      ++own_histogram_[std::min(own_histogram_.size() - 1, static_cast<std::size_t>(e * kPerMillimetre))];
    }
  }
}

ImageView<float> MapScorer::layer_for(const ScoredView& view, std::size_t which) const {
  return padded_image(layer_store_.data() + which * image_capacity(), view.camera);
}

void MapScorer::render_others(const ScoredView& view, Span<const Se3> T_map_fragment, std::size_t first,
                              std::size_t last, const ImageView<float>& layer) const {
  const Se3 T_camera_map = view.T_camera_fragment * T_map_fragment[view.fragment.index()].inverse();
  const Frustum frustum(view.camera, options_.min_depth_m, options_.max_depth_m);
  for (std::size_t f = first; f < last; ++f) {
    if (f == view.fragment.index()) continue;
    const ScoredFragment& fragment = fragments_[f];
    const Se3 T_camera_fragment = T_camera_map * T_map_fragment[f];
    const Eigen::Vector3f center = (T_camera_fragment * fragment.center.cast<double>()).cast<float>();
    if (!frustum.meets(center, fragment.radius)) continue;
    render_discs(fragment.surfels, T_camera_fragment, view.camera, options_.min_depth_m, options_.max_depth_m,
                 layer);
  }
}

void MapScorer::render_others(const ScoredView& view, Span<const Se3> T_map_fragment,
                              const ImageView<float>& layer) const {
  fill(layer, 0.0F);
  render_others(view, T_map_fragment, 0, fragments_.size(), layer);
}

MapScore MapScorer::dmp(Span<const Se3> T_map_fragment, Span<float> view_values, double give_up_above) const {
  assert(T_map_fragment.size() == fragments_.size());
  MapScore result;
  for (std::size_t v = 0; v < views_.size() && result.complete; ++v) {
    const ScoredView& view = views_[v];
    const ImageView<float> others = layer_for(view, 0);
    render_others(view, T_map_fragment, others);
    const double value = mean_over_rows(others.height, [&](int y) {
      return squared_row(view.own.row(y), others.row(y), view.depth.row(y), others.width);
    });
    result.value += value;
    ++result.views_rendered;
    if (!view_values.empty()) view_values[v] = static_cast<float>(value);
    result.complete = result.value <= give_up_above;
  }
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

// Every point x of fragment f, at T_f x in the first map, goes along with D_f = T'_f T_f⁻¹. Against fragment
// a it moves by |D_f y − D_a y| at y = T_f x: at the centre exactly, elsewhere by at most the radius times
// the angle more.
void MapScorer::affected_views(Span<const Se3> T_before, Span<const Se3> T_after, double least_motion_m,
                               std::vector<std::uint16_t>* views) const {
  const std::size_t count = fragments_.size();
  affected_.assign(count, 0);
  motion_.resize(count);
  center_.resize(2 * count);
  for (std::size_t f = 0; f < count; ++f) {
    motion_[f] = T_after[f] * T_before[f].inverse();
    const Eigen::Vector3d center = fragments_[f].center.cast<double>();
    center_[2 * f] = T_before[f] * center;
    center_[2 * f + 1] = T_after[f] * center;
  }
  const auto near = [this](std::size_t a, std::size_t f, std::size_t map) {
    const double reach = fragments_[a].reach + static_cast<double>(fragments_[f].radius);
    return (center_[2 * a + map] - center_[2 * f + map]).squaredNorm() < reach * reach;
  };
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t f = 0; f < count && affected_[a] == 0; ++f) {
      if (f == a || !(near(a, f, 0) || near(a, f, 1))) continue;
      const Eigen::Vector3d& y = center_[2 * f];
      const double angle = (motion_[f].rotation() - motion_[a].rotation()).norm() / std::sqrt(2.0);
      const double moved = (motion_[f] * y - motion_[a] * y).norm();
      affected_[a] = moved + angle * static_cast<double>(fragments_[f].radius) > least_motion_m ? 1 : 0;
    }
  }
  views->clear();
  for (std::size_t v = 0; v < views_.size(); ++v)
    if (affected_[views_[v].fragment.index()] != 0) views->push_back(static_cast<std::uint16_t>(v));
}

void MapScorer::render_pair_view(const ScoredView& view, FragmentId i, FragmentId j, const Se3& T_i_j,
                                 const ImageView<float>& layer) const {
  const bool in_i = view.fragment == i;
  fill(layer, 0.0F);
  render_discs(fragments_[in_i ? j.index() : i.index()].surfels,
               view.T_camera_fragment * (in_i ? T_i_j : T_i_j.inverse()), view.camera, options_.min_depth_m,
               options_.max_depth_m, layer);
}

// Into the layers from 1, in the order of the views.
void MapScorer::render_pair(FragmentId i, FragmentId j, const Se3& T_i_j) const {
  std::size_t layer = 1;
  for (const ScoredView& view : views_)
    if (view.fragment == i || view.fragment == j)
      render_pair_view(view, i, j, T_i_j, layer_for(view, layer++));
}

double MapScorer::rendered_pair_against(FragmentId i, FragmentId j, const Se3& T_i_j) const {
  double sum = 0;
  std::size_t layer = 1;
  for (const ScoredView& view : views_) {
    if (view.fragment != i && view.fragment != j) continue;
    const ImageView<float> first = layer_for(view, layer++), second = layer_for(view, 0);
    render_pair_view(view, i, j, T_i_j, second);
    sum += mean_over_rows(first.height, [&](int y) {
      return compare_row(view.own.row(y), first.row(y), second.row(y), view.depth.row(y), first.width);
    });
  }
  return sum;
}

double MapScorer::compare_pair(FragmentId i, FragmentId j, const Se3& T_i_j_first,
                               const Se3& T_i_j_second) const {
  render_pair(i, j, T_i_j_first);
  return rendered_pair_against(i, j, T_i_j_second);
}

bool MapScorer::explains_pair_best(FragmentId i, FragmentId j, const Se3& T_i_j_first,
                                   Span<const Se3> T_i_j_others) const {
  render_pair(i, j, T_i_j_first);
  return std::all_of(T_i_j_others.begin(), T_i_j_others.end(),
                     [&](const Se3& other) { return rendered_pair_against(i, j, other) < 0; });
}

int MapScorer::better_for_pair(FragmentId i, FragmentId j, const Se3& T_i_j_first,
                               Span<const Se3> T_i_j_others) const {
  render_pair(i, j, T_i_j_first);
  int best = -1;
  double most = 0;
  for (std::size_t k = 0; k < T_i_j_others.size(); ++k) {
    const double better_by = rendered_pair_against(i, j, T_i_j_others[k]);
    if (better_by > most) most = better_by, best = static_cast<int>(k);
  }
  return best;
}

Eigen::Vector3d MapScorer::centroid(FragmentId f) const {
  return fragments_[f.index()].center.cast<double>();
}

}  // namespace loopsift
