// SPDX-License-Identifier: MIT
// Map scorers over a world of fragments, and over two walls whose score is known by hand.
#pragma once
#include <gtest/gtest.h>

#include <vector>

#include "core/posterior/map_scorer.hpp"
#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"

namespace loopsift::test {

inline PosteriorOptions small_options() {
  PosteriorOptions options;
  options.max_fragments = 8;
  options.max_discs_per_fragment = 10000;
  options.max_view_width = 80, options.max_view_height = 60;
  return options;
}

inline InArena<MapScorer> scorer_of(const FragmentWorld& world,
                                    const PosteriorOptions& options = small_options()) {
  InArena<MapScorer> scorer(options);
  for (const Fragment& fragment : world.fragments()) EXPECT_TRUE(scorer->add(fragment));
  return scorer;
}

// A wall two metres ahead, seen head-on by one view that measured the given depth everywhere; or by none.
class WallFragment {
 public:
  WallFragment(int id, double half_width_m, float measured_m) {
    for (double x = -half_width_m + 0.0125; x < half_width_m; x += 0.025) {
      for (double y = -1.4875; y < 1.5; y += 0.025) {
        x_.push_back(static_cast<float>(x)), y_.push_back(static_cast<float>(y)), z_.push_back(2.0F);
        zero_.push_back(0.0F), minus_.push_back(-1.0F), one_.push_back(1.0F);
      }
    }
    fragment.id = FragmentId{id};
    fragment.surfels.x = x_, fragment.surfels.y = y_, fragment.surfels.z = z_;
    fragment.surfels.nx = zero_, fragment.surfels.ny = zero_, fragment.surfels.nz = minus_;
    fragment.surfels.radius = one_, fragment.surfels.weight = one_;
    if (measured_m <= 0) return;
    depth_.assign(static_cast<std::size_t>(view_camera().width * view_camera().height), measured_m);
    views_.push_back({0, view_camera(), {depth_.data(), view_camera().width, view_camera().height}, Se3()});
    fragment.views = Span<const ScoreView>(views_.data(), views_.size());
  }
  Fragment fragment;

 private:
  std::vector<float> x_, y_, z_, zero_, minus_, one_, depth_;
  std::vector<ScoreView> views_;
};

struct TwoWalls {
  explicit TwoWalls(float measured_m = 2.0F, double half_width_m = 2.5)
      : first(0, 2.5, measured_m), second(1, half_width_m, 0.0F), scorer(small_options()) {
    EXPECT_TRUE(scorer->add(first.fragment));
    EXPECT_TRUE(scorer->add(second.fragment));
  }
  [[nodiscard]] double plain(const Se3& T_first_second) const {
    const std::vector<Se3> poses = {Se3(), T_first_second};
    return scorer->dmp(poses).value;
  }
  WallFragment first, second;
  InArena<MapScorer> scorer;
};

}  // namespace loopsift::test
