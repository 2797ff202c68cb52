// SPDX-License-Identifier: MIT
#include "loopsift/client/map.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "loopsift/client/map_ply.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/subscriber/messages.hpp"

namespace loopsift::client {
namespace {

using test::fragment_message;
using test::graph_message;

TEST(Map, ComesTogetherInAnyOrder) {
  Map map;
  EXPECT_FALSE(map.complete());
  EXPECT_TRUE(map.add(fragment_message(1, 90, 2)));
  EXPECT_TRUE(map.add(graph_message(3, 2, 90, 0)));
  EXPECT_FALSE(map.complete());
  for (const int chunk : {1, 0, 2}) EXPECT_TRUE(map.add(fragment_message(0, 90, chunk)));
  for (const int chunk : {1, 0, 1}) EXPECT_TRUE(map.add(fragment_message(1, 90, chunk)));
  EXPECT_TRUE(map.complete());
  int count = 0;
  map.for_each_surfel([&count](const Surfel& s, std::int32_t fragment) {
    EXPECT_EQ(s.x, static_cast<float>(fragment));
    EXPECT_EQ(s.y, static_cast<float>(count % 90));  // the fragment's x, turned
    EXPECT_EQ(s.ny, 1);
    ++count;
  });
  EXPECT_EQ(count, 180);
}

TEST(Map, LeavesOutPiecesThatNoLoopHasJoinedToItYet) {
  Map map;
  for (std::int32_t f = 0; f < 2; ++f) ASSERT_TRUE(map.add(fragment_message(f, 10, 0)));
  graph_t graph = graph_message(1, 2, 10, 0);
  graph.fragments[1].anchored = false;
  ASSERT_TRUE(map.add(graph));
  EXPECT_TRUE(map.complete());
  std::vector<int> joined(2), all(2);
  map.for_each_surfel(
      [&](const Surfel&, std::int32_t fragment) { ++joined[static_cast<std::size_t>(fragment)]; });
  map.for_each_surfel_of_all_pieces(
      [&](const Surfel&, std::int32_t fragment) { ++all[static_cast<std::size_t>(fragment)]; });
  EXPECT_EQ(joined, (std::vector<int>{10, 0}));
  EXPECT_EQ(all, (std::vector<int>{10, 10}));
}

TEST(Map, ANewerGraphMovesTheFragmentsOnceItIsWhole) {
  Map map;
  for (std::int32_t f = 0; f < 3; ++f) ASSERT_TRUE(map.add(fragment_message(f, 1, 0)));
  ASSERT_TRUE(map.add(graph_message(1, 3, 1, 0)));
  EXPECT_EQ(map.graph().version, 0);
  ASSERT_TRUE(map.add(graph_message(1, 3, 1, 1)));
  EXPECT_EQ(map.graph().version, 1);
  EXPECT_TRUE(map.complete());
  ASSERT_TRUE(map.add(graph_message(2, 3, 1, 1)));
  EXPECT_EQ(map.graph().version, 1) << "half of a graph is none";
  EXPECT_FALSE(map.add(graph_message(1, 3, 1, 0))) << "an older one is out of date";
  ASSERT_TRUE(map.add(graph_message(2, 3, 1, 0)));
  EXPECT_EQ(map.graph().version, 2);
}

TEST(Map, AsksForWhatIsMissing) {
  Map map;
  command_t command{};
  EXPECT_EQ(map.add_missing(0, &command), 1);
  EXPECT_EQ(command.object[0], command_t::GRAPH);
  EXPECT_EQ(command.chunks[0][31], 0xFF) << "however many chunks it has";

  for (const int chunk : {0, 1}) ASSERT_TRUE(map.add(graph_message(1, 3, 10'800, chunk)));
  for (std::int32_t chunk = 0; chunk < 300; ++chunk)
    ASSERT_TRUE(chunk == 10 || chunk == 299 || map.add(fragment_message(1, 10'800, chunk)));
  command = {};
  EXPECT_EQ(map.add_missing(1, &command), 6);
  EXPECT_EQ(command.object[0], 0);
  EXPECT_EQ(command.first_chunk[1], 256);
  EXPECT_EQ(command.object[2], 1);
  EXPECT_EQ(command.chunks[2][1], 1 << 2);
  EXPECT_EQ(command.first_chunk[3], 256);
  EXPECT_EQ(command.chunks[3][5], 1 << 3);
  EXPECT_EQ(command.chunks[3][4], 0);

  for (std::int32_t chunk = 0; chunk < 50; ++chunk) ASSERT_TRUE(map.add(graph_message(2, 100, 10, chunk)));
  command = {};
  EXPECT_EQ(map.add_missing(2, &command), 32) << "as many as a command has room for";
}

TEST(Map, RefusesNonsense) {
  Map map;
  const auto refuses = [&map](auto message, auto spoil) {
    spoil(&message);
    EXPECT_FALSE(map.add(message));
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  refuses(fragment_message(0, 90, 1), [nan](fragment_t* m) { m->y[7] = nan; });
  refuses(fragment_message(0, 90, 1), [](fragment_t* m) { m->n = 35; });
  refuses(fragment_message(0, 90, 1), [](fragment_t* m) { m->n = -1; });
  refuses(fragment_message(0, 90, 1), [](fragment_t* m) { m->chunk = 3; });
  refuses(fragment_message(0, 90, 1), [](fragment_t* m) { m->chunk = -1; });
  refuses(fragment_message(0, 90, 1), [](fragment_t* m) { m->chunk_count = INT32_MAX; });
  refuses(fragment_message(0, 90, 1), [](fragment_t* m) { m->surfel_count = INT32_MAX; });
  refuses(fragment_message(0, 90, 1), [](fragment_t* m) { m->fragment = -1; });
  refuses(graph_message(1, 3, 10, 0), [nan](graph_t* m) { m->fragments[1].t[2] = static_cast<double>(nan); });
  refuses(graph_message(1, 3, 10, 0), [](graph_t* m) { m->version = 0; });
  refuses(graph_message(1, 3, 10, 0), [](graph_t* m) { m->edge_count = INT32_MAX; });
  refuses(graph_message(1, 3, 10, 0), [](graph_t* m) { m->n_nodes = 1; });
  refuses(graph_message(1, 3, 10, 0), [](graph_t* m) { m->chunk = 1; });
  refuses(graph_message(1, 3, 10, 0), [](graph_t* m) {
    m->edge_count = m->n_edges = 1;
    m->edges[0].T_a_b = test::at(0);  // its ends are not among the nodes
  });
  EXPECT_EQ(map.chunks_received(), 0);
  ASSERT_TRUE(map.add(fragment_message(0, 90, 1)));
  EXPECT_FALSE(map.add(fragment_message(0, 91, 1))) << "fragments never change";
}

TEST(Map, AFragmentWithoutSurfelsIsComplete) {
  Map map;
  ASSERT_TRUE(map.add(graph_message(1, 1, 0, 0)));
  EXPECT_FALSE(map.complete());
  ASSERT_TRUE(map.add(fragment_message(0, 0, 0)));
  EXPECT_TRUE(map.complete());
}

TEST(MapPly, HoldsEverySurfel) {
  Map map;
  ASSERT_TRUE(map.add(graph_message(1, 1, 3, 0)));
  ASSERT_TRUE(map.add(fragment_message(0, 3, 0)));
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/map.ply";
  ASSERT_TRUE(write_ply(path, map));
  const std::string text = test::read_file(path);
  EXPECT_NE(text.find("element vertex 3\n"), std::string::npos);
  EXPECT_EQ(text.size(), text.find("end_header\n") + 11 + 3 * 35);
  EXPECT_FALSE(write_ply(folder.path() + "/none/map.ply", map));
}

}  // namespace
}  // namespace loopsift::client
