// SPDX-License-Identifier: MIT
#include "core/base/memory_budget.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

constexpr std::size_t kMib = 1024 * 1024;

TEST(MemoryBudget, CarvesOfOneOwnerAreOneRow) {
  MemoryBudget budget;
  budget.add("fragment/surfels", 10, 640);
  budget.add("frame/depth", 5, 64);
  budget.add("fragment/surfels", 2, 128);
  ASSERT_EQ(budget.rows.size(), 2U);
  EXPECT_EQ(budget.rows[0].owner, "fragment/surfels");
  EXPECT_EQ(budget.rows[0].count, 12U);
  EXPECT_EQ(budget.rows[0].bytes, 768U);
  EXPECT_EQ(budget.total_bytes(), 832U);
}

TEST(MemoryBudget, TextShowsTheLargestRowFirstAndTheCapLast) {
  MemoryBudget budget;
  budget.add("frame/depth", 5, kMib);
  budget.add("fragment/surfels", 7, 3 * kMib);
  const std::string text = budget.to_text(256 * kMib);
  const std::size_t large = text.find("fragment/surfels"), small = text.find("frame/depth"),
                    total = text.find("total");
  ASSERT_NE(large, std::string::npos);
  ASSERT_NE(small, std::string::npos);
  ASSERT_NE(total, std::string::npos);
  EXPECT_LT(large, small);
  EXPECT_LT(small, total);
  EXPECT_NE(text.find("4.00 of 256.00 (memory.cap_mib)", total), std::string::npos) << text;
}

TEST(MemoryBudget, AnEmptyBudgetIsZero) {
  EXPECT_EQ(MemoryBudget{}.total_bytes(), 0U);
  EXPECT_NE(MemoryBudget{}.to_text(kMib).find("0.00 of 1.00"), std::string::npos);
}

}  // namespace
}  // namespace loopsift
