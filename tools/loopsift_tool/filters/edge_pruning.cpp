// SPDX-License-Identifier: MIT
// Pruning after optimisation (of the section on graph optimisation): all loops are optimised, those edges
// that then disagree too much with the result (a squared Mahalanobis distance above the bound) are removed,
// and the rest is optimised once more, from where the first ended.
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {

Expected<FilterResult> run_edge_pruning(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                        const EdgePruningOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kEdge);
  if (!graph.ok()) return graph.error();
  const std::vector<double> all(graph->term_count(), 1.0);
  if (Status status = graph->solve_weighted(all); !status.ok()) return status.error();
  std::vector<bool> keep;
  for (const double chi2 : graph->term_chi2()) keep.push_back(chi2 <= options.max_chi2);
  graph->keep_terms(keep);
  const std::vector<double> rest(graph->term_count(), 1.0);
  if (Status status = graph->solve_weighted(rest); !status.ok()) return status.error();
  return graph->finish(rest, options.accept_share);
}

}  // namespace loopsift::tool
