// SPDX-License-Identifier: MIT
// The test solve of the sifter: 60 fragments of 3 nodes, 10 accepted loops, one more to test. Cold: from the
// odometry. Warm: from the poses with the accepted loops, as the sifter starts it.
#include <benchmark/benchmark.h>

#include "core/posegraph/fast_solver.hpp"
#include "tests/support/random_graph.hpp"

namespace loopsift {
namespace {

struct World {
  PoseGraph cold, warm;
};

World make_world(int fragments, int loops) {
  test::RandomGraphOptions options;
  options.fragments = fragments;
  test::RandomGraph world(options);
  const std::vector<Loop> all = world.true_loops(loops + 1);
  for (int k = 0; k < loops; ++k)
    append_frame_loops(world.graph, all[static_cast<std::size_t>(k)], &world.graph.loops);
  World made{world.graph, world.graph};
  if (!solve(SolveOptions{}, &made.warm).converged) std::abort();
  for (PoseGraph* graph : {&made.cold, &made.warm}) append_frame_loops(*graph, all.back(), &graph->loops);
  return made;
}

void report(const SolveSummary& summary, benchmark::State* state) {
  state->counters["iterations"] = summary.iterations;
  state->counters["chi2"] = 2.0 * summary.final_cost;
}

void solve_with_ceres(benchmark::State& state) {
  const World world = make_world(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  SolveSummary summary;
  for (auto _ : state) {
    PoseGraph graph = state.range(2) != 0 ? world.warm : world.cold;
    summary = solve(SolveOptions{}, &graph);
    if (!summary.converged) state.SkipWithError(summary.message.c_str());
  }
  report(summary, &state);
}

void solve_in_fixed_memory(benchmark::State& state) {
  const World world = make_world(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  SolverLimits limits;
  limits.max_nodes = 1200;
  Arena measuring;
  SolverWorkspace on_nothing(&measuring, limits);
  Arena arena(measuring.used_bytes());
  SolverWorkspace workspace(&arena, limits);
  SolveSummary summary;
  PoseGraph graph = world.cold;
  for (auto _ : state) {
    graph.T_map_node = state.range(2) != 0 ? world.warm.T_map_node : world.cold.T_map_node;
    summary = solve_fast(SolveOptions{}, &workspace, &graph);
    if (!summary.converged) state.SkipWithError(summary.message.c_str());
  }
  report(summary, &state);
  state.counters["blocks"] = workspace.block_count();
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"fragments", "loops", "warm"})->Unit(benchmark::kMillisecond);
  for (const int warm : {0, 1})
    for (const auto& [fragments, loops] : {std::pair{20, 5}, {60, 10}, {60, 40}, {200, 30}})
      benchmark->Args({fragments, loops, warm});
}

BENCHMARK(solve_with_ceres)->Apply(sizes);
BENCHMARK(solve_in_fixed_memory)->Apply(sizes);

}  // namespace
}  // namespace loopsift
