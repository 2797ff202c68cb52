// SPDX-License-Identifier: MIT
// Max-mixtures: each loop edge is the better of two Gaussians with the same mean, the measurement and a null
// hypothesis that claims next to nothing (section 4: max instead of sum, so that least squares still holds):
//
//     p(z | x) = max( N(μ, Λ⁻¹),  w N(μ, (sΛ)⁻¹) )
//
// With −2 log of it, constants left out, χ² stands against s χ² − 2 log w − 6 log s: six dimensions, so that
// |sΛ|^½ = s³ |Λ|^½. The better one is chosen anew between two solves; in the paper between two steps of one.
#include <algorithm>
#include <cmath>

#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {

Expected<FilterResult> run_max_mixtures(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                        const MaxMixturesOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kEdge);
  if (!graph.ok()) return graph.error();
  const double s = options.null_information,
               offset = -2.0 * std::log(options.null_weight) - 6.0 * std::log(s);
  RobustCost robust;
  robust.weight = [s, offset](double chi2) { return chi2 <= s * chi2 + offset ? 1.0 : 0.0; };
  robust.factor = [s, offset](double chi2) { return chi2 <= s * chi2 + offset ? 1.0 : s; };
  robust.cost = [s, offset](double chi2) { return std::min(chi2, s * chi2 + offset); };
  Expected<std::vector<double>> chosen = alternate(robust, options.max_rounds, &*graph);
  if (!chosen.ok()) return chosen.error();
  return graph->finish(*chosen, options.accept_share);
}

}  // namespace loopsift::tool
