// SPDX-License-Identifier: MIT
// What waits to be sent, the graph on its way between threads, and the covariance of the newest pose.
#include <gtest/gtest.h>

#include <thread>

#include "core/base/triple_buffer.hpp"
#include "firmware_app/publisher_covariance.hpp"
#include "firmware_app/publisher_graph.hpp"
#include "firmware_app/publisher_messages.hpp"
#include "firmware_app/publisher_wanted.hpp"
#include "tests/support/in_arena.hpp"
#include "tests/support/random_graph.hpp"

namespace loopsift {
namespace {

TEST(TripleBuffer, TheNewestValueArrivesAndOvertakenOnesAreSkipped) {
  TripleBuffer<int> buffer;
  EXPECT_FALSE(buffer.update());
  for (const int value : {1, 2, 3}) {
    buffer.writable() = value;
    buffer.publish();
  }
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.readable(), 3);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.readable(), 3);
}

TEST(TripleBuffer, ValuesAreWholeAcrossThreads) {
  struct Pair {
    std::int64_t a = 0, b = 0;
  };
  TripleBuffer<Pair> buffer;
  constexpr std::int64_t kLast = 20'000;
  std::thread writer([&buffer] {
    for (std::int64_t i = 1; i <= kLast; ++i) {
      buffer.writable() = {i, -i};
      buffer.publish();
    }
  });
  std::int64_t newest = 0;
  while (newest < kLast) {
    if (!buffer.update()) continue;
    const Pair pair = buffer.readable();
    ASSERT_EQ(pair.a, -pair.b);
    ASSERT_GT(pair.a, newest);
    newest = pair.a;
  }
  writer.join();
}

TEST(WantedChunks, OldestFirstEachOnce) {
  WantedChunks wanted;
  EXPECT_TRUE(wanted.add_all(7, 3));
  ChunkWindow window;
  window.object = kGraphObject;
  window.first = 256;
  window.set(255);
  EXPECT_TRUE(wanted.add(window));
  EXPECT_TRUE(wanted.add_all(7, 3)) << "what waits already is not sent twice";
  std::vector<std::pair<int, int>> order;
  std::int32_t object = 0, chunk = 0;
  while (wanted.next(&object, &chunk)) order.emplace_back(object, chunk);
  const std::vector<std::pair<int, int>> expected = {{7, 0}, {7, 1}, {7, 2}, {kGraphObject, 511}};
  EXPECT_EQ(order, expected);
  EXPECT_TRUE(wanted.empty());
}

TEST(WantedChunks, LargeObjectsTakeSeveralWindowsAndAFullListRefuses) {
  WantedChunks wanted;
  EXPECT_TRUE(wanted.add_all(0, 600));
  EXPECT_EQ(wanted.size(), 3U);
  int count = 0;
  std::int32_t object = 0, chunk = 0;
  while (wanted.next(&object, &chunk)) EXPECT_EQ(chunk, count++);
  EXPECT_EQ(count, 600);
  for (std::int32_t f = 0; f < static_cast<std::int32_t>(WantedChunks::kEntries); ++f)
    EXPECT_TRUE(wanted.add_all(f, 1));
  EXPECT_FALSE(wanted.add_all(9999, 1));
  EXPECT_TRUE(wanted.remove(0));
  EXPECT_FALSE(wanted.remove(0));
  EXPECT_TRUE(wanted.add_all(9999, 1));
}

GraphLimits limits() { return {8, 200, 300}; }

struct Exchange {
  explicit Exchange(Arena& arena) : graph(limits(), arena) {}
  GraphExchange graph;
};

TEST(GraphExchange, CarriesTheGraphInChunksThatHoldEveryElementOnce) {
  const test::RandomGraph world({});
  const test::InArena<Exchange> exchange;
  std::vector<Fragment> fragments(4);
  std::vector<Se3> poses(4);
  EXPECT_FALSE(exchange->graph.update());
  exchange->graph.put(world.graph, fragments, poses, 5, 2);
  ASSERT_TRUE(exchange->graph.update());
  const GraphSnapshot& newest = exchange->graph.newest();
  EXPECT_EQ(newest.version, 1);
  EXPECT_EQ(newest.epoch, 2);
  ASSERT_EQ(newest.node_count, static_cast<int>(world.graph.nodes.size()));
  int fragments_seen = 0, nodes = 0, edges = 0;
  for (std::int32_t chunk = 0; chunk < newest.chunk_count(); ++chunk) {
    graph_t message;
    fill(&message, newest, chunk);
    fragments_seen += message.n_fragments;
    for (int k = 0; k < message.n_nodes; ++k, ++nodes) {
      const Se3& T = world.graph.T_map_node[static_cast<std::size_t>(nodes)];
      EXPECT_NEAR(message.nodes[k].T_map_node.trans[0], T.translation().z(), 1e-12);
      EXPECT_EQ(message.nodes[k].fragment, world.graph.nodes[static_cast<std::size_t>(nodes)].fragment.value);
    }
    for (int k = 0; k < message.n_edges; ++k) EXPECT_EQ(message.edges[k].a, edges++);
  }
  EXPECT_EQ(fragments_seen, 4);
  EXPECT_EQ(nodes, newest.node_count);
  EXPECT_EQ(edges, static_cast<int>(world.graph.odometry.size()));
}

TEST(GraphExchange, SaysWhichFragmentsNoLoopHasJoinedToTheMapYet) {
  PoseGraph graph;
  graph.nodes.resize(2);
  graph.T_map_node.resize(2);
  graph.first_node = {0, 1, 2};
  std::vector<Fragment> fragments(4);  // the last two are not in the graph yet
  fragments[1].joined_to_previous = false;
  const std::vector<Se3> poses(4);
  const auto anchored = [&] {
    const test::InArena<Exchange> exchange;
    exchange->graph.put(graph, fragments, poses, 0, 0);
    EXPECT_TRUE(exchange->graph.update());
    std::vector<int> all;
    for (std::int32_t chunk = 0; chunk < exchange->graph.newest().chunk_count(); ++chunk) {
      graph_t message;
      fill(&message, exchange->graph.newest(), chunk);
      for (int f = 0; f < message.n_fragments; ++f) all.push_back(message.fragments[f].anchored);
    }
    return all;
  };
  EXPECT_EQ(anchored(), (std::vector<int>{1, 0, 0, 0})) << "what comes next is of the same piece";
  graph.loops.push_back({0, 1, Se3(), Matrix6d::Identity(), LoopId{5}});
  EXPECT_EQ(anchored(), (std::vector<int>{1, 1, 1, 1}));
  fragments[3].joined_to_previous = false;
  EXPECT_EQ(anchored(), (std::vector<int>{1, 1, 1, 0})) << "lost again";
}

TEST(GraphExchange, WhatDoesNotFitIsLeftOutAndCounted) {
  test::RandomGraph world({});
  const Edge odometry = world.graph.odometry[0];
  for (int k = 0; k < 400; ++k) world.graph.loops.push_back(odometry);
  const test::InArena<Exchange> exchange;
  exchange->graph.put(world.graph, {}, {}, 0, 0);
  ASSERT_TRUE(exchange->graph.update());
  EXPECT_EQ(exchange->graph.newest().edge_count, 300);
  EXPECT_EQ(exchange->graph.figures().refused,
            static_cast<std::int64_t>(world.graph.odometry.size()) + 400 - 300);
}

// With the channel's name, LCM's header (8 bytes) and those of UDP and IP (28).
TEST(Messages, OfTheMapFitInOnePacket) {
  constexpr int kPacket = 1500, kHeaders = 36, kName = 64;
  EXPECT_LE(fragment_t().getEncodedSize(), kPacket - kHeaders - kName);
  EXPECT_LE(graph_t().getEncodedSize(), kPacket - kHeaders - kName);
}

TEST(Messages, ExactBodyAxesTurnBackToTheSameBits) {
  const Se3 T(so3_exp({0.3, -1.2, 0.7}), {1.5, -0.0, 3.25});
  const Se3 body = exactly_in_body_axes(T);
  EXPECT_LT((body.matrix() - in_body_axes(T).matrix()).norm(), 1e-15);
  EXPECT_EQ(-body.translation()[1], T.translation()[0]);
  EXPECT_EQ(body.rotation()(0, 0), T.rotation()(2, 2));
  EXPECT_EQ(-body.rotation()(1, 0), T.rotation()(0, 2));
}

// Against the recursion that needs every frame since: Σ ← Ad(T_k_k₋₁) Σ Adᵀ + Σ_motion.
TEST(CovarianceTracker, GrowsAsTheMotionsSay) {
  CovarianceTracker tracker;
  Matrix6d expected = Matrix6d::Zero(), known = Matrix6d::Zero();
  Se3 T_odom_camera;
  constexpr int kFrames = 60, kKnown = 20;
  Vector6d step;
  step << 0.02, 0.01, 0.03, 0.01, 0.05, -0.02;
  Matrix6d information = Matrix6d::Identity() * 1e4;
  information(0, 1) = information(1, 0) = 2e3;
  for (int k = 0; k < kFrames; ++k) {
    const Se3 motion = Se3::exp(step);
    if (k > 0) {
      T_odom_camera = T_odom_camera * motion;
      const Matrix6d back = motion.inverse().adjoint();
      expected = back * expected * back.transpose() + Matrix6d(information.inverse());
      known = back * known * back.transpose() + Matrix6d(information.inverse());
    }
    tracker.add(k * 1000, T_odom_camera, information);
    if (k == kKnown) known = Matrix6d::Identity() * 1e-5;
  }
  EXPECT_LT((tracker.newest() - expected).norm(), 1e-9 * expected.norm());
  tracker.correct(kKnown * 1000 + 500, Matrix6d::Identity() * 1e-5);
  EXPECT_LT((tracker.newest() - known).norm(), 1e-9 * known.norm());
  tracker.correct(0, Matrix6d::Constant(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_LT((tracker.newest() - known).norm(), 1e-9 * known.norm()) << "what is not known changes nothing";
}

TEST(CovarianceTracker, AMotionNothingIsKnownOfAddsNothing) {
  CovarianceTracker tracker;
  tracker.add(0, Se3(), Matrix6d::Identity());
  EXPECT_EQ(tracker.newest().norm(), 0) << "the map begins at the first pose";
  tracker.add(1, Se3(), Matrix6d::Zero());
  EXPECT_EQ(tracker.newest().norm(), 0);
}

}  // namespace
}  // namespace loopsift
