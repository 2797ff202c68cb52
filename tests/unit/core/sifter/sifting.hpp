// SPDX-License-Identifier: MIT
// A sifter over a world of fragments, all at once or fragment by fragment.
#pragma once
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <vector>

#include "core/sifter/sifter.hpp"
#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"

namespace loopsift::test {

inline PosteriorOptions small_posterior() {
  PosteriorOptions options;
  options.max_fragments = 8;
  options.max_discs_per_fragment = 10000;
  options.max_view_width = 80, options.max_view_height = 60;
  return options;
}

class Sifting {
 public:
  explicit Sifting(const SifterOptions& options = {})
      : scorer(small_posterior()), sifter_(options, std::ref(*scorer)) {}
  explicit Sifting(const FragmentWorld& world, const SifterOptions& options = {}) : Sifting(options) {
    for (const Fragment& fragment : world.fragments()) (void)scorer->add(fragment);
    graph_ = world.graph();
    set_graph(world.fragments().back());
  }
  /// As the map grows in a run: the fragment, and what was proposed with it.
  void grow(const Fragment* previous, const Fragment& fragment, const std::vector<Loop>& loops) {
    (void)scorer->add(fragment);
    append_fragment(previous, fragment, 2, &graph_);
    set_graph(fragment);
    add(loops);
    work();
  }
  void add(const std::vector<Loop>& loops) { sifter.add(Span<const Loop>(loops.data(), loops.size())); }
  /// All that there is to do on the graph as it is.
  void work() {
    while (sifter.step()) {
    }
  }
  /// Algorithm 1 on these loops; ids of those accepted.
  std::vector<int> sift(const std::vector<Loop>& loops) {
    add(loops);
    EXPECT_TRUE(sifter.finish());
    return accepted();
  }
  /// By id of the loop.
  [[nodiscard]] const SiftedLoop& of(int id) const {
    for (const SiftedLoop& record : sifter.records())
      if (record.loop.id.value == id) return record;
    throw std::out_of_range("no such loop");
  }
  [[nodiscard]] std::vector<int> accepted() const {
    std::vector<int> ids;
    for (const Loop& loop : sifter.accepted()) ids.push_back(loop.id.value);
    return ids;
  }
  [[nodiscard]] std::vector<Se3> poses() const { return fragment_poses(graph_, sifter.T_map_node()); }
  [[nodiscard]] const SiftedLoop& record(std::size_t k) const { return sifter.records()[k]; }

  InArena<MapScorer> scorer;

 private:
  InArena<Sifter> sifter_;

 public:
  Sifter& sifter = *sifter_;

 private:
  void set_graph(const Fragment& newest) {
    sifter.set_graph(graph_, newest.frames[newest.frames.size() - 1].frame.value);
  }
  PoseGraph graph_;
};

inline Vector6d error(double x, double y, double z, double yaw) {
  return (Vector6d() << x, y, z, 0, yaw, 0).finished();
}

/// Loops whose errors are like a registration's: a centimetre, half a degree.
inline std::vector<Loop> true_loops(const FragmentWorld& world) {
  return {world.loop(0, 0, 6, error(0.008, -0.004, 0.006, 0.006)),
          world.loop(1, 1, 5, error(-0.006, 0.005, 0.009, -0.008)),
          world.loop(2, 1, 6, error(0.004, 0.006, -0.008, 0.005))};
}

/// Loops as a proposer gets them wrong, ids from 10 on.
inline std::vector<Loop> wrong_loops(const FragmentWorld& world) {
  return {world.loop(10, 0, 6, error(0.5, 0, 0.2, 0.3)), world.loop(11, 0, 3, error(-0.4, 0.1, 0.6, -0.5)),
          world.loop(12, 1, 5, error(0, 0.3, -0.5, 0.35)), world.loop(13, 2, 5, error(0.7, 0, 0, 1.5))};
}

inline std::vector<Loop> together(std::vector<Loop> a, const std::vector<Loop>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace loopsift::test
