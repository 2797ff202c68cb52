// SPDX-License-Identifier: MIT
#include "core/base/latency_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace loopsift {
namespace {

TEST(LatencyHistogram, EmptyIsZero) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0);
  EXPECT_EQ(histogram.max_ms(), 0);
  EXPECT_EQ(histogram.percentile_ms(0.5), 0);
}

TEST(LatencyHistogram, OneRecordIsEveryPercentile) {
  LatencyHistogram histogram;
  histogram.record_ns(12'345'678);
  EXPECT_EQ(histogram.count(), 1);
  EXPECT_DOUBLE_EQ(histogram.max_ms(), 12.345678);
  EXPECT_DOUBLE_EQ(histogram.percentile_ms(0), 12.345678);  // the edge above is clipped to the maximum
  EXPECT_DOUBLE_EQ(histogram.percentile_ms(1), 12.345678);
}

TEST(LatencyHistogram, PercentilesAreWithinTwoPercentOverTheWholeRange) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(3.0, 10.9);  // 1 µs to 79 s, in ns
  LatencyHistogram histogram;
  std::vector<double> durations_ms;
  for (int i = 0; i < 20000; ++i) {
    const auto ns = static_cast<std::int64_t>(std::pow(10.0, exponent(random)));
    histogram.record_ns(ns);
    durations_ms.push_back(static_cast<double>(ns) * 1e-6);
  }
  std::sort(durations_ms.begin(), durations_ms.end());
  for (const double fraction : {0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(fraction * 20000.0));
    const double exact = durations_ms[rank - 1];
    EXPECT_GE(histogram.percentile_ms(fraction), exact * (1 - 1e-9)) << fraction;
    EXPECT_LE(histogram.percentile_ms(fraction), exact * 1.0201) << fraction;
  }
  EXPECT_DOUBLE_EQ(histogram.max_ms(), durations_ms.back());
}

TEST(LatencyHistogram, WhatLiesOutsideIsCountedAtTheEnds) {
  LatencyHistogram histogram;
  histogram.record_ns(-5);
  histogram.record_ns(0);
  histogram.record_ns(300'000'000'000);
  EXPECT_EQ(histogram.count(), 3);
  EXPECT_LE(histogram.percentile_ms(0.5), 1e-3);
  EXPECT_DOUBLE_EQ(histogram.percentile_ms(1), 300'000.0);
}

TEST(LatencyHistogram, MergeAddsCountsAndKeepsTheMaximum) {
  LatencyHistogram fast, slow;
  for (int i = 0; i < 99; ++i) fast.record_ns(1'000'000);
  slow.record_ns(50'000'000);
  fast.merge(slow);
  EXPECT_EQ(fast.count(), 100);
  EXPECT_NEAR(fast.percentile_ms(0.99), 1.0, 0.02);
  EXPECT_DOUBLE_EQ(fast.max_ms(), 50.0);
}

}  // namespace
}  // namespace loopsift
