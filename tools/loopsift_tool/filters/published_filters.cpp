// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/filters/filter.hpp"

namespace loopsift::tool {
namespace {

template <class Options>
using Run = Expected<FilterResult> (*)(const PoseGraph&, Span<const Loop>, const Options&);

// A filter with its default options.
template <class Options, Run<Options> kRun>
Expected<FilterResult> with_defaults(const PoseGraph& odometry_graph, Span<const Loop> loops) {
  return kRun(odometry_graph, loops, Options{});
}

}  // namespace

Span<const NamedFilter> published_filters() {
  static const NamedFilter kFilters[] = {
      {"none", "", run_none},
      {"all", "", run_all},
      {"Cauchy loss", "Holland & Welsch, 1977", with_defaults<CauchyLossOptions, run_cauchy_loss>},
      {"edge pruning", "Endres et al., T-RO 2014", with_defaults<EdgePruningOptions, run_edge_pruning>},
      {"switchable constraints", "Sünderhauf & Protzel, IROS 2012",
       with_defaults<SwitchableConstraintsOptions, run_switchable_constraints>},
      {"max-mixtures", "Olson & Agarwal, IJRR 2013", with_defaults<MaxMixturesOptions, run_max_mixtures>},
      {"RRR", "Latif et al., IJRR 2013", with_defaults<RrrOptions, run_rrr>},
      {"expectation-maximisation", "Lee et al., IROS 2013",
       with_defaults<ExpectationMaximizationOptions, run_expectation_maximization>},
      {"dynamic covariance scaling", "Agarwal et al., ICRA 2013",
       with_defaults<DynamicCovarianceScalingOptions, run_dynamic_covariance_scaling>},
      {"line process", "Choi, Zhou & Koltun, CVPR 2015", with_defaults<LineProcessOptions, run_line_process>},
      {"GNC-TLS", "Yang et al., RA-L 2020", with_defaults<GncOptions, run_gnc_tls>},
      {"PCM", "Mangelson et al., ICRA 2018",
       with_defaults<PairwiseConsistencyOptions, run_pairwise_consistency>},
  };
  return {kFilters, sizeof kFilters / sizeof kFilters[0]};
}

}  // namespace loopsift::tool
