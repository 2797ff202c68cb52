// SPDX-License-Identifier: MIT
// Dynamic covariance scaling: a loop's information is scaled by s², with (eq. 15)
//
//     s = min( 1, 2Φ / (Φ + χ²) )
//
// The paper recomputes s in every iteration of the solver; here the poses come to rest between two values of
// s. Both are iteratively reweighted least squares, with the same fixed points, on the robust cost whose
// derivative by χ² is that s²:  ρ(χ²) = χ² up to Φ, and 3Φ − 4Φ² / (Φ + χ²) beyond.
#include <algorithm>

#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {

Expected<FilterResult> run_dynamic_covariance_scaling(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                      const DynamicCovarianceScalingOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kEdge);
  if (!graph.ok()) return graph.error();
  const double phi = options.phi;
  const auto scale = [phi](double chi2) { return std::min(1.0, 2.0 * phi / (phi + chi2)); };
  RobustCost robust;
  robust.weight = scale;
  robust.factor = [scale](double chi2) { return scale(chi2) * scale(chi2); };
  robust.cost = [phi](double chi2) {
    return chi2 <= phi ? chi2 : 3.0 * phi - 4.0 * phi * phi / (phi + chi2);
  };
  Expected<std::vector<double>> scales = alternate(robust, options.max_rounds, &*graph);
  if (!scales.ok()) return scales.error();
  return graph->finish(*scales, options.accept_scale);
}

}  // namespace loopsift::tool
