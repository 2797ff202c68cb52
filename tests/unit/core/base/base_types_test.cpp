// SPDX-License-Identifier: MIT
// The small types of core/base: results, spans, ids.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <type_traits>
#include <vector>

#include "core/base/ids.hpp"
#include "core/base/result.hpp"
#include "core/base/span.hpp"

namespace loopsift {
namespace {

TEST(Status, IsSuccessUntilItHoldsAnError) {
  const Status success;
  EXPECT_TRUE(success.ok());
  const Status failure = Error{ErrorCode::kIo, "disk full"};
  EXPECT_FALSE(failure);
  EXPECT_EQ(failure.error().code, ErrorCode::kIo);
  EXPECT_EQ(failure.error().message, "disk full");
}

TEST(Expected, HoldsAValueOrAnError) {
  Expected<int> value = 7;
  ASSERT_TRUE(value.ok());
  *value += 1;
  EXPECT_EQ(value.value(), 8);
  const Expected<int> error = Error{ErrorCode::kFormat, "line 3"};
  ASSERT_FALSE(error);
  EXPECT_EQ(error.error().message, "line 3");
}

TEST(Expected, MovesWhatCannotBeCopied) {
  Expected<std::unique_ptr<int>> made = std::make_unique<int>(5);
  const std::unique_ptr<int> taken = std::move(*made);
  EXPECT_EQ(*taken, 5);
}

TEST(Span, ViewsContainersWithoutCopying) {
  std::vector<int> numbers = {1, 2, 3};
  const Span<int> view(numbers);
  view[1] = 20;
  EXPECT_EQ(numbers[1], 20);
  const Span<const int> read_only = numbers;
  EXPECT_EQ(read_only.data(), numbers.data());
  EXPECT_EQ(read_only.first(2).size(), 2U);
  int sum = 0;
  for (const int n : read_only) sum += n;
  EXPECT_EQ(sum, 24);
}

TEST(Span, ConstCannotBecomeMutable) {
  EXPECT_TRUE((std::is_convertible_v<Span<int>&, Span<const int>>));
  EXPECT_FALSE((std::is_convertible_v<Span<const int>, Span<int>>));
  EXPECT_FALSE((std::is_convertible_v<const std::vector<int>&, Span<int>>));
}

TEST(Span, DefaultIsEmpty) {
  EXPECT_TRUE(Span<int>().empty());
  EXPECT_EQ(Span<int>().begin(), Span<int>().end());
}

TEST(Id, IsInvalidUntilSetAndOrdersByValue) {
  EXPECT_FALSE(FragmentId{}.valid());
  EXPECT_TRUE(FragmentId{0}.valid());
  EXPECT_EQ(FragmentId{4}.index(), 4U);
  EXPECT_LT(FragmentId{1}, FragmentId{2});
  EXPECT_NE(FragmentId{1}, FragmentId{2});
  EXPECT_FALSE((std::is_convertible_v<FragmentId, FrameId>)) << "a fragment's number is no frame's";
}

}  // namespace
}  // namespace loopsift
