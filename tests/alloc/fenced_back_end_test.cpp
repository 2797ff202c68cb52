// SPDX-License-Identifier: MIT
// What happens to solves and registrations that want more memory than the back thread has.
#include <gtest/gtest.h>

#include "core/base/heap_watch.hpp"
#include "tests/support/random_graph.hpp"
#include "tests/unit/core/pipeline/sifted_world.hpp"
#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kKib = 1024, kMib = 1024 * kKib;

PoseGraph looped_graph() {
  test::RandomGraph random({});
  PoseGraph graph = random.graph;
  for (const Loop& loop : random.true_loops(4)) append_frame_loops(graph, loop, &graph.loops);
  return graph;
}

void expect_same_poses(const PoseGraph& a, const PoseGraph& b) {
  ASSERT_EQ(a.T_map_node.size(), b.T_map_node.size());
  for (std::size_t n = 0; n < a.T_map_node.size(); ++n)
    ASSERT_EQ(a.T_map_node[n].matrix(), b.T_map_node[n].matrix());
}

// From a limit that is used up at once to one that is never reached: wherever memory ends, the solve is
// refused, the poses stay and nothing is left behind.
TEST(FencedSolve, IsRefusedWithItsPosesKeptAndRecovers) {
  const PoseGraph start = looped_graph();
  int refused = 0, solved = 0;
  for (std::int64_t limit = kKib; limit <= 64 * kMib; limit = limit * 3 / 2) {
    PoseGraph graph = start;
    SolveSummary summary;
    HeapFence::Figures figures;
    {
      const HeapFence fence(256 * kMib, limit, &figures);
      summary = solve({}, &graph);
    }
    if (summary.converged) {
      ++solved;
      EXPECT_EQ(figures.refusals, 0);
      continue;
    }
    ++refused;
    EXPECT_EQ(figures.refusals, 1);
    EXPECT_FALSE(summary.message.empty());
    EXPECT_LE(figures.peak_bytes, limit + 64) << "but for what the heap rounds a block up by";
    expect_same_poses(graph, start);
  }
  EXPECT_GT(refused, 5);
  EXPECT_GT(solved, 3);
}

TEST(FencedBackEnd, ARefusedRegistrationLeavesTheMapAndTheNextOneIsTried) {
  const test::FragmentWorld world;
  test::InArena<BackEnd> back_end(test::small_back_end(true));
  HeapFence::Figures figures;
  {
    const HeapFence fence(256 * kMib, 64 * kKib, &figures);
    for (std::size_t f = 0; f < 6; ++f) EXPECT_TRUE(back_end->add_fragment(world.fragments()[f]));
  }
  EXPECT_TRUE(back_end->proposals().empty());
  EXPECT_EQ(back_end->registrations_refused(), 6);
  EXPECT_GE(figures.refusals, 6);
  EXPECT_EQ(back_end->fragment_count(), 6);
  const std::vector<Se3> poses = back_end->T_map_fragment();
  for (std::size_t f = 0; f < poses.size(); ++f)
    EXPECT_LT((poses[f].inverse() * world.odometry()[f]).log().norm(), 1e-9) << f;

  {
    const HeapFence fence(256 * kMib, 200 * kMib, &figures);
    (void)back_end->add_fragment(world.fragments()[6]);
    back_end->finish();
  }
  EXPECT_EQ(back_end->registrations_refused(), 6) << "nothing more was refused";
  EXPECT_EQ(back_end->fragment_count(), 7);
}

/// As many voxels as a cloud may hold, in a space that needs every cell that a field may have.
test::SurfelCloud largest_fragment() {
  test::SurfelCloud surfels;
  test::SurfaceSampler sample(
      Se3(), [](const Eigen::Vector3d&) { return true; }, &surfels);
  for (int floor = 0; floor < 8; ++floor) sample.patch({0, 0, 1.2 * floor}, {3, 0, 0.3}, {0, 1.5, 0.2});
  for (int wall = 0; wall < 4; ++wall) sample.patch({4.0 * wall, 8, 4}, {0, 2, 0}, {0.4, 0, 1.5});
  for (int box = 0; box < 12; ++box)
    sample.box({0.9 * box, 4.0 + 0.3 * (box % 3), 0.5 * box}, {0.4, 0.3, 0.5}, 0.4 * box);
  return surfels;
}

// The default of memory.back_heap_mib is 20, and lists and solves of others have to fit in, too.
TEST(FencedProposer, NeedsNoMoreForTheLargestFragmentsThanTheBackThreadHas) {
  std::vector<test::SurfelCloud> surfels(3, largest_fragment());
  std::vector<Fragment> fragments(surfels.size());
  const std::vector<Se3> estimate(surfels.size());
  const ProposalOptions options;
  RegistrationCloud thinned;
  VoxelThinner(options.cloud).thin(surfels[0].span(), &thinned);
  ASSERT_EQ(thinned.size(), static_cast<std::size_t>(options.cloud.max_points));
  const test::InArena<Proposer> proposer(options);
  std::vector<Loop> loops;
  HeapFence::Figures figures;
  {
    const HeapFence fence(256 * kMib, 8 * kMib, &figures);
    for (std::size_t k = 0; k < surfels.size(); ++k) {
      fragments[k].id.value = static_cast<std::int32_t>(k);
      fragments[k].surfels = surfels[k].span();
      EXPECT_TRUE(within_fence([&] {
        proposer->add_fragment(fragments[k]);
        proposer->propose(fragments[k].id, estimate, {}, &loops);
      })) << k;
    }
  }
  EXPECT_EQ(loops.size(), 1U);
  EXPECT_GT(figures.peak_bytes, 4 * kMib) << "is the fragment as large as meant?";
}

}  // namespace
}  // namespace loopsift
