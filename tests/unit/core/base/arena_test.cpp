// SPDX-License-Identifier: MIT
#include "core/base/arena.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace loopsift {
namespace {

/// A part as parts are: its constructor carves and touches nothing.
struct Part {
  explicit Part(Arena* arena)
      : bytes(arena->carve<std::uint8_t>("part/bytes", 3)),
        doubles(arena->carve<double>("part/doubles", 9)) {}
  Span<std::uint8_t> bytes;
  Span<double> doubles;
};

TEST(Arena, MeasuringRecordsTheBudgetAndReservesNothing) {
  Arena measuring;
  const Part part(&measuring);
  EXPECT_TRUE(measuring.measuring());
  EXPECT_EQ(part.bytes.data(), nullptr);
  EXPECT_EQ(part.doubles.size(), 9U);
  EXPECT_EQ(measuring.used_bytes(), 64U + 128U) << "each carve is rounded up to 64 bytes";
  EXPECT_EQ(measuring.budget().total_bytes(), measuring.used_bytes());
}

TEST(Arena, TheMeasuredSizeIsExactlyWhatIsCarved) {
  Arena measuring;
  { const Part part(&measuring); }
  Arena arena(measuring.used_bytes());
  const Part part(&arena);
  EXPECT_FALSE(arena.measuring());
  EXPECT_EQ(arena.used_bytes(), arena.capacity_bytes());
  EXPECT_EQ(arena.budget().total_bytes(), measuring.budget().total_bytes());
}

TEST(Arena, StoresAreZeroedAlignedAndApart) {
  Arena arena(64 + 128);
  const Part part(&arena);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(part.bytes.data()) % 64, 0U);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(part.doubles.data()) % 64, 0U);
  for (const double value : part.doubles) EXPECT_EQ(value, 0.0);
  for (std::uint8_t& value : part.bytes) value = 0xff;
  for (const double value : part.doubles) EXPECT_EQ(value, 0.0);
}

TEST(Arena, AnEmptyCarveTakesNoSpace) {
  Arena arena(64);
  EXPECT_TRUE(arena.carve<int>("part/none", 0).empty());
  EXPECT_EQ(arena.used_bytes(), 0U);
  EXPECT_EQ(arena.carve<int>("part/some", 16).size(), 16U);
}

TEST(ArenaDeathTest, CarvingPastTheMeasuredSizeIsOurBug) {
#ifdef NDEBUG
  Arena arena(64);
  EXPECT_THROW((void)arena.carve<char>("part/large", 65), std::bad_alloc);
#else
  EXPECT_DEATH(
      {
        Arena arena(64);
        (void)arena.carve<char>("part/large", 65);
      },
      "measuring arena");
#endif
}

}  // namespace
}  // namespace loopsift
