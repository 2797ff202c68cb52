// SPDX-License-Identifier: MIT
// Public benchmark graphs against the optima that g2o and SE-Sync (Rosen et al., IJRR 2019) report.
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/posegraph/pose_graph.hpp"

namespace loopsift {
namespace {

class PublishedGraphs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::getenv("LOOPSIFT_DATA") == nullptr) GTEST_SKIP() << "LOOPSIFT_DATA is not set";
  }
  static PoseGraph read(const std::string& name) {
    Expected<PoseGraph> graph = read_g2o(std::string(std::getenv("LOOPSIFT_DATA")) + "/posegraphs/" + name);
    EXPECT_TRUE(graph.ok()) << graph.error().message;
    return graph.ok() ? *graph : PoseGraph{};
  }
  static double optimal_chi2(PoseGraph graph) {
    SolveOptions options;
    options.time_limit_s = 120.0;
    const SolveSummary summary = solve(options, &graph);
    EXPECT_TRUE(summary.converged) << summary.message;
    return 2.0 * summary.final_cost;
  }
};

// SE-Sync reads the file's rotational weight as that of the angle, g2o as that of q_xyz, half the angle.
// Read as SE-Sync does, our logarithmic cost and its chordal one have nearly the same minimum.
TEST_F(PublishedGraphs, SmallGridReachesTheCertifiedOptimum) {
  PoseGraph graph = read("smallGrid3D.g2o");
  const Vector6d from_g2o = (Vector6d() << 1, 1, 1, 2, 2, 2).finished();
  for (std::vector<Edge>* edges : {&graph.odometry, &graph.loops})
    for (Edge& edge : *edges)
      edge.information = (from_g2o.asDiagonal() * edge.information * from_g2o.asDiagonal()).eval();
  EXPECT_NEAR(optimal_chi2(graph), 1025.4, 0.02 * 1025.4);
}

// The weights of rotation hardly matter here: all three conventions agree.
TEST_F(PublishedGraphs, ParkingGarageReachesTheOptimum) {
  EXPECT_NEAR(optimal_chi2(read("parking-garage.g2o")), 1.25, 0.02);
}

// g2o's own optimum is 727.15; its translation error is not bent by the logarithm.
TEST_F(PublishedGraphs, SphereReachesTheOptimum) {
  EXPECT_NEAR(optimal_chi2(read("sphere2500.g2o")), 727.15, 0.5);
}

}  // namespace
}  // namespace loopsift
