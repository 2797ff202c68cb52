// SPDX-License-Identifier: MIT
// Owner of all closed fragments, in memory that is fixed from the start.
// In: fragments as the builder (or a test) has them. Out: const Fragment at addresses that never change.
// Capacity: StoreOptions; when any pool is full the store refuses this and every later fragment (tracking
// goes on against those that are there) and counts the refusals. Threads: one adds; others read what
// fragments() returned to them.
#pragma once
#include <atomic>
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/base/result.hpp"
#include "core/fragment/fragment.hpp"
#include "core/fragment/surfel_arrays.hpp"

namespace loopsift {

struct StoreOptions {
  int max_fragments = 360;
  int max_surfels = 2000000;   ///< of all fragments
  int max_frames = 18000;      ///< of all fragments
  int max_views = 720;         ///< of all fragments
  int max_view_pixels = 4800;  ///< of one view
};
[[nodiscard]] Status validate(const StoreOptions& options);

class FragmentStore {
 public:
  static constexpr std::size_t kLeastSurfels = 2000;  ///< of a fragment that can still be tracked against
  struct Pool {
    std::size_t capacity = 0;
    std::size_t used = 0;  ///< also the high-water mark: nothing is ever freed
  };

  FragmentStore(const StoreOptions& options, Arena& arena);
  /// Copies the fragment with everything that it points to and gives it the next id. Null when there is no
  /// room.
  const Fragment* add(const Fragment& fragment);
  /// Surfels that the next fragment may have: all there are while more than half of them are free; then an
  /// equal share for each fragment that may still come, but never below kLeastSurfels. So the map gets
  /// coarser before it ends.
  [[nodiscard]] std::size_t surfel_allowance() const;
  /// All fragments so far, in order of id.
  [[nodiscard]] Span<const Fragment> fragments() const;
  [[nodiscard]] int refused() const { return refused_; }
  [[nodiscard]] Pool fragment_pool() const { return {fragments_.size(), used_fragments_.load()}; }
  [[nodiscard]] Pool surfel_pool() const { return {surfels_.size(), used_surfels_}; }
  [[nodiscard]] Pool frame_pool() const { return {frames_.size(), used_frames_}; }
  [[nodiscard]] Pool view_pool() const { return {views_.size(), used_views_}; }

 private:
  [[nodiscard]] bool fits(const Fragment& fragment) const;
  [[nodiscard]] SurfelSpan copy_surfels(const SurfelSpan& source);
  [[nodiscard]] Span<const FragmentFrame> copy_frames(Span<const FragmentFrame> source);
  [[nodiscard]] Span<const ScoreView> copy_views(Span<const ScoreView> source);

  std::size_t max_view_pixels_;
  Span<Fragment> fragments_;
  SurfelSpan surfels_;
  Span<FragmentFrame> frames_;
  Span<ScoreView> views_;
  Span<float> view_pixels_;
  std::atomic<std::size_t> used_fragments_{0};
  std::atomic<std::size_t> used_surfels_{0}, used_frames_{0}, used_views_{0};  // any thread may read them
  std::atomic<int> refused_{0};
};

}  // namespace loopsift
