// SPDX-License-Identifier: MIT
// The loop filters that others have published, on our pose graph, for comparison. In: the odometry's graph
// and proposed loops. Out: which loops each keeps, and the poses it ends with. Each takes its parameters from
// its paper by default. Desk code: allocates, one thread, deterministic.
//
// All start at the graph's own poses, the odometry's, and alternate between poses at given weights (solve())
// and weights at given poses, in closed form. A loop becomes several edges (append_frame_loops), which share
// its information. Losses, switches, mixtures and pruning work on each edge of the graph, as their papers do;
// the line process, GNC, RRR and PCM, which measure a loop against its correspondences or against a quantile
// of its χ², take the loop as a whole.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/span.hpp"
#include "core/posegraph/pose_graph.hpp"

namespace loopsift::tool {

/// What a filter did with the loops.
struct FilterResult {
  std::vector<double> weights;   ///< of each loop in the order given, in [0, 1]; the mean of its edges'
  std::vector<LoopId> accepted;  ///< of weight at least the filter's bound, in the order given
  PoseGraph graph;               ///< final poses; its loops are the frame loops as last weighted
  int solves = 0;                ///< pose graph solves that it took
};

/// Every weight 0: the odometry.
[[nodiscard]] Expected<FilterResult> run_none(const PoseGraph& odometry_graph, Span<const Loop> loops);
/// Every weight 1: plain least squares.
[[nodiscard]] Expected<FilterResult> run_all(const PoseGraph& odometry_graph, Span<const Loop> loops);

/// Cauchy's loss with the constant of Holland & Welsch, Robust regression using iteratively reweighted least
/// squares, Communications in Statistics 1977.
struct CauchyLossOptions {
  double scale = 2.3849;       ///< c, in standard deviations
  double accept_weight = 0.5;  ///< kept with a weight of at least this
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_cauchy_loss(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                     const CauchyLossOptions& options = {});

/// Endres, Hess, Sturm, Cremers & Burgard, 3-D mapping with an RGB-D camera, T-RO 2014.
struct EdgePruningOptions {
  double max_chi2 = 5.0;      ///< the first bound of the authors' evaluation (rgbdslam_v2)
  double accept_share = 0.5;  ///< kept with at least this share of its edges
};
[[nodiscard]] Expected<FilterResult> run_edge_pruning(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                      const EdgePruningOptions& options = {});

/// Sünderhauf & Protzel, Switchable constraints for robust pose graph SLAM, IROS 2012.
struct SwitchableConstraintsOptions {
  double switch_information = 1.0;  ///< Ξ, of the prior that pulls every switch to 1; the paper's 1
  double accept_switch = 0.5;       ///< kept with a switch of at least this
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_switchable_constraints(
    const PoseGraph& odometry_graph, Span<const Loop> loops,
    const SwitchableConstraintsOptions& options = {});

/// Agarwal et al., Robust map optimization using dynamic covariance scaling, ICRA 2013.
struct DynamicCovarianceScalingOptions {
  double phi = 1.0;           ///< Φ; the paper's 1
  double accept_scale = 0.5;  ///< kept with a scale s of at least this
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_dynamic_covariance_scaling(
    const PoseGraph& odometry_graph, Span<const Loop> loops,
    const DynamicCovarianceScalingOptions& options = {});

/// Olson & Agarwal, Inference on networks of mixtures for robust robot mapping, IJRR 2013. The null
/// hypothesis is that of Sünderhauf & Protzel's comparison (ICRA 2013, in their program vertigo); the paper
/// leaves it to the user.
struct MaxMixturesOptions {
  double null_weight = 0.01;        ///< w
  double null_information = 1e-11;  ///< s, of the loop's
  double accept_share = 0.5;        ///< kept with at least this share of its edges on the loop's hypothesis
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_max_mixtures(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                      const MaxMixturesOptions& options = {});

/// Latif, Cadena & Neira, Robust loop closing over time for pose graph SLAM, IJRR 2013.
struct RrrOptions {
  double cluster_window_s = 10.0;  ///< loops whose ends are that close in time are one cluster; the paper's
};
[[nodiscard]] Expected<FilterResult> run_rrr(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                             const RrrOptions& options = {});

/// Lee, Fraundorfer & Pollefeys, Robust pose-graph loop-closures with expectation-maximization, IROS 2013.
struct ExpectationMaximizationOptions {
  double scale = 1.0;          ///< c of Cauchy's function, in standard deviations
  double very_low = 0.1;       ///< edges of a lower weight are removed; our reading of "very low weights"
  double accept_weight = 0.5;  ///< kept with a weight of at least this
  int max_rounds = 500;        ///< of one EM process
};
[[nodiscard]] Expected<FilterResult> run_expectation_maximization(
    const PoseGraph& odometry_graph, Span<const Loop> loops,
    const ExpectationMaximizationOptions& options = {});

/// Choi, Zhou & Koltun, Robust reconstruction of indoor scenes, CVPR 2015.
struct LineProcessOptions {
  double distance_m = 0.05;   ///< τ: μ = τ² κ, the cost of a loop whose partners are all that far apart
  double accept_line = 0.25;  ///< a loop below it is pruned before the last solve
  int max_rounds = 500;
};
[[nodiscard]] Expected<FilterResult> run_line_process(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                      const LineProcessOptions& options = {});

/// Yang et al., Graduated non-convexity for robust spatial perception, RA-L 2020: truncated least squares.
struct GncOptions {
  double noise_bound_squared = 16.812;  ///< c̄², of χ²; the 0.99 quantile for six degrees of freedom
  double mu_factor = 1.4;               ///< μ grows by it each round; the paper's 1.4
  double accept_weight = 0.5;           ///< weights end near 0 or 1
  int max_rounds = 1000;
};
[[nodiscard]] Expected<FilterResult> run_gnc_tls(const PoseGraph& odometry_graph, Span<const Loop> loops,
                                                 const GncOptions& options = {});

/// Mangelson, Dominic, Eustice & Vasudevan, Pairwise consistent measurement set maximization for robust
/// multi-robot map merging, ICRA 2018.
struct PairwiseConsistencyOptions {
  double max_chi2 = 16.812;               ///< γ; the 0.99 quantile for six degrees of freedom
  std::int64_t clique_budget = 10000000;  ///< branches; past it the clique is the largest found until then
};
[[nodiscard]] Expected<FilterResult> run_pairwise_consistency(const PoseGraph& odometry_graph,
                                                              Span<const Loop> loops,
                                                              const PairwiseConsistencyOptions& options = {});

/// A filter with the parameters of its paper, for tables.
struct NamedFilter {
  const char* name;    ///< as in tables and JSON
  const char* source;  ///< the paper; empty for none and all
  Expected<FilterResult> (*run)(const PoseGraph& odometry_graph, Span<const Loop> loops);
};
/// All of the above, in the order above.
[[nodiscard]] Span<const NamedFilter> published_filters();

}  // namespace loopsift::tool
