// SPDX-License-Identifier: MIT
// The line process of Choi et al. (section 5): with f a loop's χ² and l its line variable,
//
//     min over x, l:  Σ_odometry f + Σ_loops ( l f + μ (√l − 1)² ),   l = ( μ / (μ + f) )² at given poses.
//
// There f = ξᵀ Λ ξ is a sum of squared distances over the loop's correspondences, Λ = Σ GᵀG, so that μ = τ²
// κ, κ the mean number of correspondences, is the f of a loop whose correspondences are all τ apart. κ is
// read from the information: the mean of the translation's three diagonal terms, over all loops. With
// information in units of a measurement variance, Λ / σ², f and μ scale alike and l does not change. Loops
// below the bound are pruned and the rest optimised once more with the line process.
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {
namespace {

double mean_correspondences(Span<const Loop> loops) {
  double sum = 0;
  for (const Loop& loop : loops) sum += loop.information.diagonal().head<3>().mean();
  return loops.empty() ? 0.0 : sum / static_cast<double>(loops.size());
}

RobustCost line_cost(double mu) {
  RobustCost robust;
  robust.weight = [mu](double chi2) { return (mu / (mu + chi2)) * (mu / (mu + chi2)); };
  robust.factor = robust.weight;
  robust.cost = [mu](double chi2) { return mu * chi2 / (mu + chi2); };  // both terms at that l
  return robust;
}

}  // namespace

Expected<FilterResult> run_line_process(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                        const LineProcessOptions& options) {
  const double mu = options.distance_m * options.distance_m * mean_correspondences(loops);
  if (!(mu > 0) && !loops.empty())
    return Error{ErrorCode::kUsage,
                 "the loops carry no information, which the line process takes its μ from"};
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kLoop);
  if (!graph.ok()) return graph.error();
  RobustCost robust = line_cost(mu);
  Expected<std::vector<double>> lines = alternate(robust, options.max_rounds, &*graph);
  if (!lines.ok()) return lines.error();
  std::vector<double> factors = *lines;
  for (double& factor : factors) factor = factor < options.accept_line ? 0.0 : factor;
  if (Status status = graph->solve_weighted(factors); !status.ok()) return status.error();
  return graph->finish(*lines, options.accept_line);
}

}  // namespace loopsift::tool
