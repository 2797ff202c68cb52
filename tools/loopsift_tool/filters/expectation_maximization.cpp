// SPDX-License-Identifier: MIT
// Classification expectation–maximisation: loops carry latent weights, which the E-step takes from Cauchy's
// function of their errors, w = c² / (c² + χ²), and the M-step uses in least squares over the poses. After
// each EM process, run until it rests, the loop edges of very low weight are removed and the next one starts
// from its poses, until nothing changes any more.
#include <algorithm>

#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {

Expected<FilterResult> run_expectation_maximization(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                    const ExpectationMaximizationOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kEdge);
  if (!graph.ok()) return graph.error();
  const RobustCost cauchy = cauchy_cost(options.scale);
  while (true) {
    Expected<std::vector<double>> weights = alternate(cauchy, options.max_rounds, &*graph);
    if (!weights.ok()) return weights.error();
    std::vector<bool> keep;
    for (const double w : *weights) keep.push_back(w >= options.very_low);
    if (std::all_of(keep.begin(), keep.end(), [](bool k) { return k; }))
      return graph->finish(*weights, options.accept_weight);
    graph->keep_terms(keep);
  }
}

}  // namespace loopsift::tool
