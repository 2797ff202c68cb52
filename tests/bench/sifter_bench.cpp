// SPDX-License-Identifier: MIT
// Many loops through the batch algorithm (Sifter::finish), and how the cost of a loop grows with the map: in
// one room, where a new fragment is one more in everyone's sight, and along a gallery, where it is not.
#include <benchmark/benchmark.h>

#include "tests/bench/sifting_world.hpp"

namespace loopsift {
namespace {

using test::Building;
using test::FragmentWorld;

// Fifteen of a hundred candidates are true. ms_per_loop is everything: alone, tested and retested, new
// reference maps, hindsight; test_p50_ms is one test. Those are processor time, and time by the clock.
void sift(Building building, int fragments, int count, benchmark::State* state) {
  const FragmentWorld world = test::make_building(building, fragments, 2, test::small_view_camera());
  const int true_count = 15 * count / 100;
  const std::vector<Loop> loops = test::candidate_loops(world, count, true_count);
  test::LoadedSifter loaded(world, test::posterior_for(world), {});
  Sifter& sifter = *loaded.sifter;
  sifter.add(test::all_of(loops));
  const double begin = test::cpu_ms();
  for (auto _ : *state)
    if (!sifter.finish()) std::abort();
  const double took = test::cpu_ms() - begin;
  const std::vector<Loop> accepted = sifter.accepted();
  state->counters["fragments"] = fragments;
  state->counters["loops"] = count;
  state->counters["cpu_s"] = 1e-3 * took;
  state->counters["ms_per_loop"] = took / count;
  std::vector<double> views;
  for (const SiftedLoop& record : sifter.records()) views.push_back(record.views);
  state->counters["views_p50"] = test::percentile(views, 0.5);
  state->counters["tested"] = static_cast<double>(sifter.counts().tested);
  state->counters["score_p50_ms"] = sifter.score_times().percentile_ms(0.5);
  state->counters["test_p50_ms"] = sifter.test_times().percentile_ms(0.5);
  state->counters["test_p99_ms"] = sifter.test_times().percentile_ms(0.99);
  state->counters["accepted"] = static_cast<double>(accepted.size());
  state->counters["accepted_false"] = static_cast<double>(std::count_if(
      accepted.begin(), accepted.end(), [&](const Loop& loop) { return loop.id.value >= true_count; }));
  const std::vector<Se3> poses = fragment_poses(sifter.graph(), sifter.T_map_node());
  state->counters["rmse_before_m"] = world.rmse_m(world.odometry());
  state->counters["rmse_m"] = world.rmse_m(poses);
}

void room(benchmark::State& state) {
  sift(Building::kRoom, static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), &state);
}
void gallery(benchmark::State& state) {
  sift(Building::kGallery, static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), &state);
}

// An online run in small: 40 fragments one after the other, each with its loops and at most 256 steps, up to
// the number asked for. Then the same by the batch algorithm. Errors and DMP (the plain, published sum over
// all views) of the published map.
void online(benchmark::State& state) {
  constexpr int kFragments = 40, kCount = 200, kTrue = 30, kStepsPerFragment = 256;
  const int until = static_cast<int>(state.range(0));
  const FragmentWorld world =
      test::make_building(Building::kGallery, kFragments, 2, test::small_view_camera());
  const std::vector<Loop> loops = test::candidate_loops(world, kCount, kTrue);
  const test::InArena<MapScorer> scorer(test::posterior_for(world));
  const test::InArena<Sifter> sifter(SifterOptions{}, std::ref(*scorer));
  const auto count = [&](const char* name) {
    const std::vector<Se3> poses = fragment_poses(sifter->graph(), sifter->T_map_node());
    const std::string prefix(name);
    state.counters[prefix + "_rmse_m"] = world.rmse_m(poses);
    state.counters[prefix + "_dmp"] = scorer->dmp(poses).value;
    state.counters[prefix + "_accepted"] = static_cast<double>(sifter->accepted().size());
  };
  PoseGraph graph;
  for (auto _ : state) {
    for (int f = 0; f < until; ++f) {
      const Fragment& fragment = world.fragments()[static_cast<std::size_t>(f)];
      if (!scorer->add(fragment)) std::abort();
      append_fragment(f == 0 ? nullptr : &fragment - 1, fragment, 2, &graph);
      sifter->set_graph(graph, f);
      for (const Loop& loop : loops)
        if (loop.j.value == f) sifter->add({&loop, 1});
      (void)sifter->work(kStepsPerFragment);
    }
  }
  const std::vector<Se3> odometry(world.odometry().begin(), world.odometry().begin() + until);
  state.counters["fragments"] = until;
  state.counters["odometry_rmse_m"] = world.rmse_m(odometry);
  state.counters["odometry_dmp"] = scorer->dmp(odometry).value;
  count("online");
  if (!sifter->finish()) std::abort();
  count("batch");
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"fragments", "loops"})->Iterations(1)->Unit(benchmark::kSecond);
  for (const int fragments : {20, 50, 100, 200}) benchmark->Args({fragments, 200});
  benchmark->Args({100, 2000});
}

BENCHMARK(room)->Apply(sizes);
BENCHMARK(gallery)->Apply(sizes);
BENCHMARK(online)->ArgName("fragments")->DenseRange(2, 40, 2)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace loopsift
