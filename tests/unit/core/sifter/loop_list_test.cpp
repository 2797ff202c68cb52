// SPDX-License-Identifier: MIT
#include "core/sifter/loop_list.hpp"

#include <gtest/gtest.h>

#include "tests/support/in_arena.hpp"

namespace loopsift {
namespace {

Loop numbered(int id) {
  Loop loop;
  loop.id.value = id;
  return loop;
}

TEST(LoopList, SaysWhichLoopsItDropped) {
  const test::InArena<LoopList> list(std::size_t{2});
  SiftedLoop dropped;
  EXPECT_TRUE(list->add(numbered(0)));
  EXPECT_TRUE(list->add(numbered(1)));
  EXPECT_FALSE(list->take_dropped(&dropped));
  EXPECT_FALSE(list->add(numbered(2))) << "none is ranked that could give way";
  (*list)[0].improvement = 1;
  (*list)[1].improvement = 2;
  list->rank(0);
  list->rank(1);
  EXPECT_TRUE(list->add(numbered(3)));
  EXPECT_EQ(list->newest().loop.id.value, 3);
  for (const int id : {2, 0}) {
    ASSERT_TRUE(list->take_dropped(&dropped));
    EXPECT_EQ(dropped.loop.id.value, id);
  }
  EXPECT_FALSE(list->take_dropped(&dropped));
  EXPECT_EQ(list->dropped(), 2);
}

TEST(LoopList, OfAFloodOfDroppedLoopsTheLastAreKept) {
  const test::InArena<LoopList> list(std::size_t{1});
  constexpr int kFlood = 10000, kKept = static_cast<int>(LoopList::kDroppedKept);
  for (int id = 0; id <= kFlood; ++id) EXPECT_EQ(list->add(numbered(id)), id == 0);
  EXPECT_EQ(list->dropped(), kFlood);
  SiftedLoop dropped;
  for (int k = 0; k < kKept; ++k) {
    ASSERT_TRUE(list->take_dropped(&dropped));
    EXPECT_EQ(dropped.loop.id.value, kFlood - kKept + 1 + k);
  }
  EXPECT_FALSE(list->take_dropped(&dropped));
}

}  // namespace
}  // namespace loopsift
