// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/posegraph/pose_graph.hpp"

namespace loopsift {
namespace {

// A run of fragments along an uneven path, each frame with its own uncertainty.
class Walk {
 public:
  Walk(int fragments, int frames_per_fragment) : stores_(static_cast<std::size_t>(fragments)) {
    for (int f = 0; f < fragments; ++f) {
      std::vector<FragmentFrame>& frames = stores_[static_cast<std::size_t>(f)];
      Fragment fragment;
      fragment.id = FragmentId{f};
      for (int k = 0; k < frames_per_fragment; ++k) {
        const int n = f * frames_per_fragment + k;
        T_odom_camera.push_back(n == 0 ? Se3(so3_exp({0.3, 0, 0}), {1, 2, 3})
                                       : T_odom_camera.back() * step(n));
        if (k == 0) fragment.T_odom_fragment = T_odom_camera.back();
        frames.push_back({FrameId{n}, 1000 + 10 * n,
                          fragment.T_odom_fragment.inverse() * T_odom_camera.back(),
                          covariance(n).inverse()});
      }
      fragment.frames = Span<const FragmentFrame>(frames.data(), frames.size());
      fragments_.push_back(fragment);
    }
  }
  [[nodiscard]] static Se3 step(int n) {
    return {so3_exp({0.05, 0.1 * (n % 3), -0.04}), {0.2 + 0.05 * (n % 2), 0.05, 0.3}};
  }
  [[nodiscard]] static Matrix6d covariance(int n) {
    Vector6d sigma;
    sigma << 0.010, 0.012 + 0.001 * n, 0.004, 0.008, 0.006, 0.012;
    return sigma.array().square().matrix().asDiagonal();
  }
  // Covariance of the motion from frame `from` to frame `to`, by drawing all single motions.
  [[nodiscard]] static Matrix6d drawn_covariance(int from, int to) {
    std::mt19937 random(11);
    std::normal_distribution<double> unit;
    Se3 T;
    for (int n = from + 1; n <= to; ++n) T = T * step(n);
    Matrix6d sum = Matrix6d::Zero();
    constexpr int kDraws = 20000;
    for (int draw = 0; draw < kDraws; ++draw) {
      Se3 noisy;
      for (int n = from + 1; n <= to; ++n) {
        Vector6d xi = covariance(n).diagonal().cwiseSqrt();
        for (int axis = 0; axis < 6; ++axis) xi[axis] *= unit(random);
        noisy = noisy * step(n) * Se3::exp(xi);
      }
      const Vector6d error = (T.inverse() * noisy).log();
      sum += error * error.transpose();
    }
    return sum / kDraws;
  }
  Fragment& fragment(std::size_t f) { return fragments_[f]; }
  PoseGraph graph(int keyframes) {
    PoseGraph made;
    for (std::size_t f = 0; f < fragments_.size(); ++f)
      append_fragment(f == 0 ? nullptr : &fragments_[f - 1], fragments_[f], keyframes, &made);
    return made;
  }
  std::vector<Se3> T_odom_camera;  // by frame

 private:
  std::vector<std::vector<FragmentFrame>> stores_;
  std::vector<Fragment> fragments_;
};

double distance(const Se3& a, const Se3& b) { return (a.inverse() * b).log().norm(); }

void expect_covariance(const Edge& edge, const Matrix6d& expected) {
  const Matrix6d covariance = edge.information.inverse();
  EXPECT_LT((covariance - expected).norm(), 0.05 * expected.norm()) << covariance << "\n\n" << expected;
  for (int axis = 0; axis < 6; ++axis)
    EXPECT_NEAR(covariance(axis, axis) / expected(axis, axis), 1.0, 0.05) << "axis " << axis;
}

TEST(BuildGraph, SpreadsKeyframesEvenlyFromTheFirstFrame) {
  Walk walk(3, 10);
  const PoseGraph graph = walk.graph(3);
  EXPECT_EQ(graph.fragment_count(), 3);
  EXPECT_EQ(graph.first_node, (std::vector<int>{0, 3, 6, 9}));
  ASSERT_EQ(graph.nodes.size(), 9U);
  const int expected[] = {0, 3, 6, 10, 13, 16, 20, 23, 26};
  for (std::size_t n = 0; n < 9; ++n) {
    EXPECT_EQ(graph.nodes[n].timestamp_ns, 1000 + 10 * expected[n]);
    EXPECT_EQ(graph.nodes[n].fragment.index(), n / 3);
    EXPECT_LT(distance(graph.T_map_node[n], walk.T_odom_camera[static_cast<std::size_t>(expected[n])]), 1e-9);
    EXPECT_LT(distance(graph.T_map_fragment(graph.nodes[n].fragment) * graph.nodes[n].T_fragment_node,
                       graph.T_map_node[n]),
              1e-9);
  }
  for (std::size_t f = 0; f < 3; ++f)
    EXPECT_LT(distance(graph.nodes[static_cast<std::size_t>(graph.first_node[f])].T_fragment_node, {}),
              1e-12);
}

TEST(BuildGraph, JoinsNeighboursByWhatTheOdometryMeasured) {
  Walk walk(3, 10);
  const PoseGraph graph = walk.graph(3);
  EXPECT_TRUE(graph.loops.empty());
  ASSERT_EQ(graph.odometry.size(), 8U);
  for (std::size_t e = 0; e < graph.odometry.size(); ++e) {
    const Edge& edge = graph.odometry[e];
    const auto a = static_cast<std::size_t>(edge.a), b = static_cast<std::size_t>(edge.b);
    EXPECT_EQ(b, a + 1);
    EXPECT_FALSE(edge.loop.valid());
    EXPECT_LT(distance(edge.T_a_b, graph.T_map_node[a].inverse() * graph.T_map_node[b]), 1e-9);
    EXPECT_LT(edge_chi2(edge, graph.T_map_node[a], graph.T_map_node[b]), 1e-9);
  }
}

TEST(BuildGraph, TakesEveryFrameOfAShortFragment) {
  Walk walk(2, 3);
  const PoseGraph graph = walk.graph(5);
  EXPECT_EQ(graph.first_node, (std::vector<int>{0, 3, 6}));
  EXPECT_EQ(graph.odometry.size(), 5U);
}

TEST(BuildGraph, CovarianceOfOneMotionIsItsOwn) {
  Walk walk(1, 2);
  const PoseGraph graph = walk.graph(2);
  ASSERT_EQ(graph.odometry.size(), 1U);
  EXPECT_LT((graph.odometry[0].information.inverse() - Walk::covariance(1)).norm(), 1e-12);
}

// Two motions, the second one metre along z without turning: the first one's turn about x or y shows as a
// shift across at its end.
TEST(BuildGraph, EarlierTurnsShiftTheEndOfTheMotion) {
  const Se3 ahead(Eigen::Matrix3d::Identity(), {0, 0, 1});
  Vector6d variance;
  variance << 1e-4, 1e-4, 1e-4, 4e-4, 4e-4, 4e-4;
  const Matrix6d covariance = variance.asDiagonal();
  const std::vector<FragmentFrame> frames = {{FrameId{0}, 0, Se3(), covariance.inverse()},
                                             {FrameId{1}, 1, ahead, covariance.inverse()},
                                             {FrameId{2}, 2, ahead * ahead, covariance.inverse()}};
  Fragment fragment;
  fragment.id = FragmentId{0};
  fragment.frames = Span<const FragmentFrame>(frames.data(), frames.size());
  Fragment next = fragment;
  next.id = FragmentId{1};
  next.T_odom_fragment = ahead * ahead * ahead;
  next.frames = next.frames.first(1);
  PoseGraph graph;
  append_fragment(nullptr, fragment, 1, &graph);
  append_fragment(&fragment, next, 1, &graph);
  ASSERT_EQ(graph.odometry.size(), 1U);  // three motions: lever arms of 2, 1 and 0 m
  Vector6d expected;
  const double across = 3e-4 + (4.0 + 1.0) * 4e-4;
  expected << across, across, 3e-4, 12e-4, 12e-4, 12e-4;
  const Matrix6d summed = graph.odometry[0].information.inverse();
  EXPECT_LT((summed.diagonal() - expected).norm(), 1e-9) << summed.diagonal();
  EXPECT_NEAR(summed(0, 4), 4e-4 * (2.0 + 1.0), 1e-9) << "a turn about y shifts along x";
  EXPECT_NEAR(summed(1, 3), -4e-4 * (2.0 + 1.0), 1e-9) << "a turn about x shifts against y";
}

TEST(BuildGraph, CovarianceInsideAFragmentIsThatOfDrawnMotions) {
  Walk walk(1, 10);
  const PoseGraph graph = walk.graph(2);  // frames 0 and 5
  ASSERT_EQ(graph.odometry.size(), 1U);
  expect_covariance(graph.odometry[0], Walk::drawn_covariance(0, 5));
}

TEST(BuildGraph, CovarianceBetweenFragmentsIsThatOfDrawnMotions) {
  Walk walk(2, 6);
  const PoseGraph graph = walk.graph(2);  // frames 0 and 3, 6 and 9
  ASSERT_EQ(graph.odometry.size(), 3U);
  expect_covariance(graph.odometry[1], Walk::drawn_covariance(3, 6));
}

TEST(BuildGraph, AFragmentAfterLostTrackingHangsOnNoEdge) {
  Walk walk(3, 6);
  walk.fragment(1).joined_to_previous = false;
  const PoseGraph graph = walk.graph(2);
  ASSERT_EQ(graph.odometry.size(), 4U);
  for (const Edge& edge : graph.odometry) EXPECT_FALSE(edge.a < 2 && edge.b >= 2) << edge.a << ' ' << edge.b;
  EXPECT_LT(distance(graph.T_map_fragment(FragmentId{1}), walk.fragment(1).T_odom_fragment), 1e-9)
      << "it starts where the odometry believes it to be";
}

TEST(BuildGraph, ANewFragmentFollowsTheCorrectedMap) {
  for (const bool joined : {true, false}) {
    Walk walk(2, 6);
    walk.fragment(1).joined_to_previous = joined;
    PoseGraph graph;
    append_fragment(nullptr, walk.fragment(0), 2, &graph);
    const Se3 T_map_odom(so3_exp({0, 0.2, 0}), {0.5, 0, 0});
    for (Se3& pose : graph.T_map_node) pose = T_map_odom * pose;
    append_fragment(&walk.fragment(0), walk.fragment(1), 2, &graph);
    EXPECT_LT(distance(graph.T_map_fragment(FragmentId{1}), T_map_odom * walk.fragment(1).T_odom_fragment),
              1e-9);
  }
}

TEST(Joined, FollowsEdgesOfBothKindsEachWay) {
  PoseGraph graph;
  graph.nodes.resize(6);
  graph.T_map_node.resize(6);
  const auto edge = [](int a, int b) { return Edge{a, b, Se3(), Matrix6d::Identity(), LoopId{}}; };
  graph.odometry = {edge(0, 1), edge(1, 2), edge(3, 4), edge(4, 5)};  // lost between 2 and 3
  EXPECT_TRUE(joined(graph, 0, 2));
  EXPECT_TRUE(joined(graph, 5, 3));
  EXPECT_FALSE(joined(graph, 0, 5));
  graph.loops = {edge(1, 4)};
  EXPECT_TRUE(joined(graph, 0, 5));
  EXPECT_TRUE(joined(graph, 3, 2));
}

TEST(AnchoredFragments, AreThoseThatEdgesLeadToFromTheFirst) {
  PoseGraph graph;
  EXPECT_TRUE(anchored_fragments(graph).empty());
  graph.nodes.resize(6);
  graph.T_map_node.resize(6);
  graph.first_node = {0, 2, 4, 6};
  const auto edge = [](int a, int b) { return Edge{a, b, Se3(), Matrix6d::Identity(), LoopId{}}; };
  graph.odometry = {edge(0, 1), edge(2, 3), edge(4, 5)};  // lost after each fragment
  EXPECT_EQ(anchored_fragments(graph), (std::vector<bool>{true, false, false}));
  graph.loops = {edge(1, 4)};
  EXPECT_EQ(anchored_fragments(graph), (std::vector<bool>{true, false, true}));
}

}  // namespace
}  // namespace loopsift
