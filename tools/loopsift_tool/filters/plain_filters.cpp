// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {
namespace {

Expected<FilterResult> run_constant(const PoseGraph& odometry_graph, Span<const Loop> loops, double weight) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kLoop);
  if (!graph.ok()) return graph.error();
  const std::vector<double> weights(loops.size(), weight);
  if (Status status = graph->solve_weighted(weights); !status.ok()) return status.error();
  return graph->finish(weights, 0.5);
}

}  // namespace

Expected<FilterResult> run_none(const PoseGraph& odometry_graph, Span<const Loop> loops) {
  return run_constant(odometry_graph, loops, 0.0);
}

Expected<FilterResult> run_all(const PoseGraph& odometry_graph, Span<const Loop> loops) {
  return run_constant(odometry_graph, loops, 1.0);
}

}  // namespace loopsift::tool
