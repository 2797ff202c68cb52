// SPDX-License-Identifier: MIT
// Cauchy's loss by iteratively reweighted least squares:
//
//     min over x:  Σ_odometry χ² + Σ_loop edges c² log(1 + χ² / c²),   weight  w = c² / (c² + χ²)
//
// c = 2.3849 gives 95 % efficiency where the errors are Gaussian after all (Holland & Welsch, table 1).
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {

Expected<FilterResult> run_cauchy_loss(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                       const CauchyLossOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kEdge);
  if (!graph.ok()) return graph.error();
  Expected<std::vector<double>> weights = alternate(cauchy_cost(options.scale), options.max_rounds, &*graph);
  if (!weights.ok()) return weights.error();
  return graph->finish(*weights, options.accept_weight);
}

}  // namespace loopsift::tool
