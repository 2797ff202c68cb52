// SPDX-License-Identifier: MIT
#include "core/fragment/fragment_store.hpp"

#include <algorithm>
#include <new>
#include <string>

namespace loopsift {

Status validate(const StoreOptions& o) {
  const auto too_small = [](const char* key) {
    return Error{ErrorCode::kUsage, std::string("store.") + key + " must be 1 or more"};
  };
  if (o.max_fragments < 1) return too_small("max_fragments");
  if (o.max_surfels < 1) return too_small("max_surfels");
  if (o.max_frames < 1) return too_small("max_frames");
  if (o.max_views < 1) return too_small("max_views");
  if (o.max_view_pixels < 1) return too_small("max_view_pixels");
  return {};
}

FragmentStore::FragmentStore(const StoreOptions& o, Arena& arena)
    : max_view_pixels_(static_cast<std::size_t>(o.max_view_pixels)),
      fragments_(arena.carve<Fragment>("fragment/store", static_cast<std::size_t>(o.max_fragments))),
      surfels_(carve_surfels(arena, "fragment/store surfels", static_cast<std::size_t>(o.max_surfels))),
      frames_(arena.carve<FragmentFrame>("fragment/store frames", static_cast<std::size_t>(o.max_frames))),
      views_(arena.carve<ScoreView>("fragment/store views", static_cast<std::size_t>(o.max_views))),
      view_pixels_(arena.carve<float>("fragment/store view depth",
                                      static_cast<std::size_t>(o.max_views) * max_view_pixels_)) {}

const Fragment* FragmentStore::add(const Fragment& fragment) {
  if (refused_ > 0 || !fits(fragment)) {
    ++refused_;
    return nullptr;
  }
  const std::size_t at = used_fragments_.load(std::memory_order_relaxed);
  auto* stored = new (fragments_.data() + at) Fragment(fragment);
  stored->id = FragmentId{static_cast<std::int32_t>(at)};
  stored->surfels = copy_surfels(fragment.surfels);
  stored->frames = copy_frames(fragment.frames);
  stored->views = copy_views(fragment.views);
  used_fragments_.store(at + 1, std::memory_order_release);  // now it is seen by other threads
  return stored;
}

std::size_t FragmentStore::surfel_allowance() const {
  const std::size_t left = surfels_.size() - used_surfels_;
  const std::size_t to_come = fragments_.size() - used_fragments_.load(std::memory_order_relaxed);
  const bool plenty = left > surfels_.size() / 2 || to_come == 0;
  return std::max(plenty ? left : left / to_come, kLeastSurfels);
}

Span<const Fragment> FragmentStore::fragments() const {
  return {fragments_.data(), used_fragments_.load(std::memory_order_acquire)};
}

bool FragmentStore::fits(const Fragment& f) const {
  for (const ScoreView& view : f.views)
    if (view.depth_m.size() > max_view_pixels_) return false;
  return used_fragments_.load(std::memory_order_relaxed) < fragments_.size() &&
         used_surfels_ + f.surfels.size() <= surfels_.size() &&
         used_frames_ + f.frames.size() <= frames_.size() && used_views_ + f.views.size() <= views_.size();
}

SurfelSpan FragmentStore::copy_surfels(const SurfelSpan& source) {
  const SurfelSpan target = slice(surfels_, used_surfels_, source.size());
  copy_surfel_arrays(source, target);
  used_surfels_ += source.size();
  return target;
}

Span<const FragmentFrame> FragmentStore::copy_frames(Span<const FragmentFrame> source) {
  FragmentFrame* target = frames_.data() + used_frames_;
  std::uninitialized_copy(source.begin(), source.end(), target);
  used_frames_ += source.size();
  return {target, source.size()};
}

Span<const ScoreView> FragmentStore::copy_views(Span<const ScoreView> source) {
  ScoreView* target = views_.data() + used_views_;
  for (std::size_t i = 0; i < source.size(); ++i) {
    auto* view = new (target + i) ScoreView(source[i]);
    float* pixels = view_pixels_.data() + (used_views_ + i) * max_view_pixels_;
    const ImageView<const float>& from = source[i].depth_m;
    for (int y = 0; y < from.height; ++y)
      std::copy_n(from.row(y), from.width, pixels + static_cast<std::ptrdiff_t>(y) * from.width);
    view->depth_m = {pixels, from.width, from.height};
  }
  used_views_ += source.size();
  return {target, source.size()};
}

}  // namespace loopsift
