// SPDX-License-Identifier: MIT
// What the sifter is measured on: walks through scenes of planes and spheres, there and back, with candidate
// loops as a proposer gives them, some true, most false.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <random>
#include <vector>

#include "core/sifter/sifter.hpp"
#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"

namespace loopsift::test {

enum class Building {
  kRoom,     ///< every fragment is of one room of 4 × 5 m: most see most others, the worst case
  kGallery,  ///< along a wall with spheres on it: each sees its neighbours and those of the way back only
};

/// The wall is seen from 2 m; the walk makes 0.8 m per fragment, so that a view of 2.2 m sees few others.
inline AnalyticScene gallery(double length_m) {
  using V = Eigen::Vector3d;
  AnalyticScene scene{{{V(-1, 0, 0), -2.0}, {V(0, -1, 0), -0.7}, {V(0, 1, 0), -1.8}}, {}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (double z = -2.0; z < length_m + 2.0; z += 0.35 + 0.3 * unit(random))
    scene.spheres.push_back(
        {V(1.3 + 0.7 * unit(random), -0.8 + 1.4 * unit(random), z), 0.12 + 0.2 * unit(random)});
  return scene;
}

inline FragmentWorld make_building(Building building, int fragments, int views_per_fragment,
                                   const PinholeCamera& view) {
  FragmentWorldOptions options;
  options.fragments = fragments;
  options.frames_per_fragment = std::max(4, views_per_fragment);
  options.views_per_fragment = views_per_fragment;
  options.view = view;
  options.drift *= 7.0 / fragments;
  if (building == Building::kRoom) return FragmentWorld(options);
  constexpr double kStep_m = 0.8, kQuarterTurn = 1.5707963267949;
  options.path = [fragments](double f) {
    const bool back = 2 * f > fragments;
    return shifted(back ? -0.1 : 0.1, back ? 0.05 : 0.0, kStep_m * (back ? fragments - f : f), kQuarterTurn);
  };
  return FragmentWorld(options, gallery(kStep_m * fragments / 2));
}

/// True ones join the way there and the way back, with a registration's errors (1 cm, 0.5°); false ones join
/// anything and are off by 0.3–1 m and up to a radian. The first `true_count` ids are the true ones'.
inline std::vector<Loop> candidate_loops(const FragmentWorld& world, int count, int true_count) {
  const int fragments = static_cast<int>(world.fragments().size());
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto direction = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
  };
  const auto one_of = [&](int from, int to) { return from + static_cast<int>(unit(random) * (to - from)); };
  std::vector<Loop> loops;
  for (int id = 0; id < count; ++id) {
    Vector6d error;
    if (id < true_count) {
      const int i = one_of(1, fragments / 2 - 1);
      const int j = std::clamp(fragments - i + one_of(-1, 2), i + 2, fragments - 1);
      error << 0.01 * direction(), 0.009 * direction();
      loops.push_back(world.loop(id, i, j, error));
    } else {
      const int i = one_of(0, fragments - 2), j = one_of(i + 2, fragments);
      error << (0.3 + 0.7 * unit(random)) * direction(), unit(random) * direction();
      loops.push_back(world.loop(id, i, j, error));
    }
  }
  return loops;
}

/// A sifter that has all of a world's fragments, with the options of a run.
struct LoadedSifter {
  LoadedSifter(const FragmentWorld& world, const PosteriorOptions& posterior, const SifterOptions& options)
      : scorer(posterior), sifter(options, std::ref(*scorer)) {
    for (const Fragment& fragment : world.fragments())
      if (!scorer->add(fragment)) std::abort();
    sifter->set_graph(world.graph(), 0);
  }
  InArena<MapScorer> scorer;
  InArena<Sifter> sifter;
};

inline PosteriorOptions posterior_for(const FragmentWorld& world) {
  const std::vector<Fragment>& fragments = world.fragments();
  PosteriorOptions options;
  options.max_fragments = static_cast<int>(fragments.size());
  options.max_views_per_fragment = static_cast<int>(fragments[0].views.size());
  options.max_view_width = fragments[0].views[0].camera.width;
  options.max_view_height = fragments[0].views[0].camera.height;
  return options;
}

inline Span<const Loop> all_of(const std::vector<Loop>& loops) { return {loops.data(), loops.size()}; }

/// Of the thread that asks: others may use the machine at the same time.
inline double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Nearest rank; 0 when empty.
inline double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size())));
  return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
}

}  // namespace loopsift::test
