// SPDX-License-Identifier: MIT
// The score of a map and what it is made of: one fragment into one view, a whole map of 20 and 60 fragments
// with two views each, and a loop test (step 3 of Algorithm 1: solve and score) of a loop that is rejected.
// All fragments are of one room, so that most are in sight of most others: the worst case.
#include <benchmark/benchmark.h>

#include <map>

#include "core/sifter/sifter.hpp"
#include "tests/support/fragment_world.hpp"
#include "tests/support/in_arena.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;

const FragmentWorld& world_of(int fragments) {
  static std::map<int, FragmentWorld> worlds;
  test::FragmentWorldOptions options;
  options.fragments = fragments;
  options.drift *= 7.0 / fragments;
  return worlds.try_emplace(fragments, options).first->second;
}

InArena<MapScorer> scorer_of(const FragmentWorld& world) {
  PosteriorOptions options;
  options.max_fragments = static_cast<int>(world.fragments().size());
  InArena<MapScorer> scorer(options);
  for (const Fragment& fragment : world.fragments())
    if (!scorer->add(fragment)) std::abort();
  return scorer;
}

void score(benchmark::State& state) {
  const FragmentWorld& world = world_of(static_cast<int>(state.range(0)));
  const InArena<MapScorer> scorer = scorer_of(world);
  const auto kind = state.range(1) != 0 ? ScoreKind::kPosterior : ScoreKind::kPlain;
  for (auto _ : state) benchmark::DoNotOptimize(scorer->score(world.odometry(), kind).value);
  state.counters["views"] = scorer->view_count();
}
BENCHMARK(score)
    ->ArgNames({"fragments", "posterior"})
    ->ArgsProduct({{20, 60}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

void render_one_fragment(benchmark::State& state) {
  const Fragment& fragment = world_of(20).fragments()[0];
  std::vector<float> arrays[7];
  for (std::vector<float>& array : arrays) array.resize(fragment.surfels.size());
  std::vector<SurfelChunk> chunks(fragment.surfels.size() / kChunkSize + 1);
  ScoreSurfels discs{arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5], arrays[6], chunks};
  ThinScratch scratch;
  const PosteriorOptions options;
  if (thin(fragment.surfels, options.disc_spacing_m, options.disc_radius_m, &scratch, &discs) > 0)
    std::abort();
  const PinholeCamera camera = test::view_camera();
  const int stride = padded_stride(camera.width);
  std::vector<float> pixels(static_cast<std::size_t>(stride * camera.height));
  const ImageView<float> image(pixels.data(), camera.width, camera.height, stride);
  const Se3 T_camera_fragment = test::shifted(0.3 * static_cast<double>(state.range(0)), 0, 0,
                                              0.8 * static_cast<double>(state.range(0)));
  for (auto _ : state) {
    std::fill(pixels.begin(), pixels.end(), 0.0F);
    if (state.range(1) != 0)
      render_discs_plain(discs, T_camera_fragment, camera, options.min_depth_m, options.max_depth_m, image);
    else
      render_discs(discs, T_camera_fragment, camera, options.min_depth_m, options.max_depth_m, image);
    benchmark::DoNotOptimize(pixels.data());
  }
  state.counters["discs"] = static_cast<double>(discs.size());
}
BENCHMARK(render_one_fragment)
    ->ArgNames({"half_in_sight", "plain"})
    ->Args({0, 0})
    ->Args({1, 0})
    ->Args({0, 1})
    ->Unit(benchmark::kMicrosecond);

// The map has an accepted loop; the one tested is off by half a metre and does not improve it.
void test_a_wrong_loop(benchmark::State& state) {
  const int fragments = static_cast<int>(state.range(0));
  const FragmentWorld& world = world_of(fragments);
  const InArena<MapScorer> scorer = scorer_of(world);
  const PoseGraph graph = world.graph();
  MapTrial trial(graph, *scorer, ScoreKind::kPosterior, {});
  std::vector<Edge> edges;
  append_frame_loops(graph, world.loop(0, 0, fragments - 1), &edges);
  const TrialResult best = trial.run(edges, graph.T_map_node);
  trial.set_reference(best, true);
  Vector6d error = Vector6d::Zero();
  error[0] = 0.5;
  append_frame_loops(graph, world.loop(1, 2, fragments - 3, error), &edges);
  ScoreLimits limits;
  if (state.range(1) != 0) limits.give_up_above = best.score;
  double solve_ms = 0, score_ms = 0;
  for (auto _ : state) {
    const TrialResult result = trial.run(edges, best.T_map_node, limits);
    solve_ms += result.solve_ms, score_ms += result.score_ms;
  }
  state.counters["solve_ms"] = benchmark::Counter(solve_ms, benchmark::Counter::kAvgIterations);
  state.counters["score_ms"] = benchmark::Counter(score_ms, benchmark::Counter::kAvgIterations);
}
BENCHMARK(test_a_wrong_loop)
    ->ArgNames({"fragments", "early_reject"})
    ->ArgsProduct({{20, 60}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace loopsift
