// SPDX-License-Identifier: MIT
#include "drivers/openni2/pairing.hpp"

#include <gtest/gtest.h>

namespace loopsift::openni2 {
namespace {

constexpr std::int64_t kHalf = 16'666;

TEST(Pairing, ColorWithinHalfAFrameBelongs) {
  for (const std::int64_t offset : {-kHalf, std::int64_t{0}, kHalf}) {
    EXPECT_EQ(pair_step(1'000'000, 1'000'000 + offset, false, kHalf), PairStep::kPair) << offset;
  }
}
TEST(Pairing, EarlierColorIsDropped) {
  EXPECT_EQ(pair_step(1'000'000, 1'000'000 - kHalf - 1, false, kHalf), PairStep::kDropColor);
  EXPECT_EQ(pair_step(1'000'000, 1'000'000 - kHalf - 1, true, kHalf), PairStep::kDropColor);
}
TEST(Pairing, LaterColorLeavesTheDepthAlone) {
  EXPECT_EQ(pair_step(1'000'000, 1'000'000 + kHalf + 1, false, kHalf), PairStep::kAlone);
}
TEST(Pairing, WaitsForColorUntilTheNextDepth) {
  EXPECT_EQ(pair_step(1'000'000, std::nullopt, false, kHalf), PairStep::kWait);
  EXPECT_EQ(pair_step(1'000'000, std::nullopt, true, kHalf), PairStep::kAlone);
}

}  // namespace
}  // namespace loopsift::openni2
