// SPDX-License-Identifier: MIT
#include "core/posterior/score_surfels.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace loopsift {
namespace {

// Surfels to thin, and room for the discs that come out.
struct Thinning {
  std::vector<float> x, y, z, nx, ny, nz, radius, weight;
  std::vector<float> discs[7];
  std::vector<SurfelChunk> chunks;
  ThinScratch scratch;

  void add(const Eigen::Vector3f& p, const Eigen::Vector3f& n, float w = 1.0F) {
    x.push_back(p.x()), y.push_back(p.y()), z.push_back(p.z());
    nx.push_back(n.x()), ny.push_back(n.y()), nz.push_back(n.z());
    radius.push_back(0.01F), weight.push_back(w);
  }
  void add_random(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    for (std::size_t k = 0; k < count; ++k) {
      const Eigen::Vector3f p(normal(random), normal(random), normal(random));
      add(p, Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized(),
          1.0F + p.x() * p.x());
    }
  }
  ScoreSurfels run(std::size_t capacity, std::size_t* left_out, float spacing = 0.05F) {
    for (std::vector<float>& array : discs) array.assign(capacity, 0.0F);
    chunks.assign((capacity + kChunkSize - 1) / kChunkSize, {});
    ScoreSurfels out{discs[0], discs[1], discs[2], discs[3], discs[4], discs[5], discs[6], chunks};
    SurfelSpan in;
    in.x = x, in.y = y, in.z = z, in.nx = nx, in.ny = ny, in.nz = nz, in.radius = radius, in.weight = weight;
    *left_out = thin(in, spacing, 0.06F, &scratch, &out);
    return out;
  }
};

Eigen::Vector3f position(const ScoreSurfels& s, std::size_t k) { return {s.x[k], s.y[k], s.z[k]}; }

TEST(Thin, TakesTheWeightedMeanOfAVoxel) {
  Thinning t;
  t.add({0.01F, 0.01F, 1.01F}, {0, 0, -1}, 1.0F);
  t.add({0.04F, 0.02F, 1.02F}, Eigen::Vector3f(0.6F, 0, -0.8F), 3.0F);
  std::size_t left_out = 9;
  const ScoreSurfels s = t.run(10, &left_out);
  ASSERT_EQ(s.size(), 1U);
  EXPECT_EQ(left_out, 0U);
  EXPECT_NEAR((position(s, 0) - Eigen::Vector3f(0.0325F, 0.0175F, 1.0175F)).norm(), 0, 1e-6);
  const Eigen::Vector3f mean = Eigen::Vector3f(1.8F, 0, -3.4F).normalized();
  EXPECT_NEAR((Eigen::Vector3f(s.nx[0], s.ny[0], s.nz[0]) - mean).norm(), 0, 1e-6);
  EXPECT_EQ(s.radius[0], 0.06F);
  ASSERT_EQ(s.chunks.size(), 1U);
}

TEST(Thin, KeepsTheTwoSidesOfAThinThingApart) {
  Thinning t;
  t.add({0.01F, 0.01F, 1.01F}, {0, 0, -1});
  t.add({0.01F, 0.01F, 1.02F}, {0, 0, 1});
  std::size_t left_out = 0;
  const ScoreSurfels s = t.run(10, &left_out);
  ASSERT_EQ(s.size(), 2U);
  EXPECT_EQ(s.nz[0] * s.nz[1], -1.0F);
  EXPECT_NEAR(std::abs(s.z[0] - s.z[1]), 0.01F, 1e-6);
}

TEST(Thin, TellsVoxelsOnBothSidesOfTheOriginApart) {
  Thinning t;
  for (const float a : {-0.01F, 0.01F})
    for (const float b : {-0.01F, 0.01F})
      for (const float c : {-0.01F, 0.01F}) t.add({a, b, c}, {0, 0, -1});
  std::size_t left_out = 0;
  EXPECT_EQ(t.run(10, &left_out).size(), 8U);
}

TEST(Thin, LeavesOutWhatHasNoWeightOrNoNormal) {
  Thinning t;
  t.add({0, 0, 1}, {0, 0, -1}, 0.0F);
  t.add({1, 0, 1}, {0, 0, 0});
  t.add({2, 0, 1}, {0, 0, -1});
  std::size_t left_out = 0;
  const ScoreSurfels s = t.run(10, &left_out);
  ASSERT_EQ(s.size(), 1U);
  EXPECT_EQ(s.x[0], 2.0F);
}

TEST(Thin, OfNothingGivesNothing) {
  Thinning t;
  std::size_t left_out = 9;
  const ScoreSurfels s = t.run(10, &left_out);
  EXPECT_EQ(s.size(), 0U);
  EXPECT_EQ(s.chunks.size(), 0U);
  EXPECT_EQ(left_out, 0U);
}

TEST(Thin, CountsWhatDoesNotFit) {
  Thinning t;
  t.add_random(2000, 1);
  std::size_t left_out = 0;
  const std::size_t all = t.run(2000, &left_out).size();
  EXPECT_EQ(left_out, 0U);
  ASSERT_GT(all, 300U);
  const ScoreSurfels s = t.run(300, &left_out);
  EXPECT_EQ(s.size(), 300U);
  EXPECT_EQ(left_out, all - 300U);
  EXPECT_EQ(s.chunks.size(), (300U + kChunkSize - 1) / kChunkSize);
}

TEST(Thin, GivesTheSameBitsTwice) {
  Thinning first, second;
  first.add_random(2000, 2), second.add_random(2000, 2);
  std::size_t left_out = 0;
  const ScoreSurfels a = first.run(2000, &left_out), b = second.run(2000, &left_out);
  ASSERT_EQ(a.size(), b.size());
  for (int array = 0; array < 7; ++array)
    EXPECT_EQ(std::memcmp(first.discs[array].data(), second.discs[array].data(), a.size() * sizeof(float)),
              0);
}

TEST(Thin, ChunksHoldTheirDiscsInBoundingSpheres) {
  Thinning t;
  t.add_random(3000, 3);
  std::size_t left_out = 0;
  const ScoreSurfels s = t.run(3000, &left_out, 0.2F);
  ASSERT_GT(s.size(), 5 * kChunkSize);
  std::size_t next = 0;
  for (const SurfelChunk& chunk : s.chunks) {
    EXPECT_EQ(chunk.begin, next);
    EXPECT_LE(chunk.size, kChunkSize);
    for (std::size_t k = next; k < next + chunk.size; ++k)
      EXPECT_LE((position(s, k) - chunk.center).norm() + s.radius[k], chunk.radius + 1e-5F);
    next += chunk.size;
  }
  EXPECT_EQ(next, s.size());
}

// Sorted along a space-filling curve: without it a chunk of a large room would span all of it.
TEST(Thin, ChunksAreCompact) {
  Thinning t;
  for (int u = 0; u < 100; ++u)
    for (int v = 0; v < 100; ++v)
      t.add({0.05F * static_cast<float>(u) + 0.025F, 0.05F * static_cast<float>(v) + 0.025F, 1.02F},
            {0, 0, -1});
  std::size_t left_out = 0;
  const ScoreSurfels s = t.run(10000, &left_out);
  ASSERT_EQ(s.size(), 10000U);
  double mean_radius = 0;
  for (const SurfelChunk& chunk : s.chunks) mean_radius += static_cast<double>(chunk.radius);
  mean_radius /= static_cast<double>(s.chunks.size());
  EXPECT_LT(mean_radius, 0.8);  // 64 discs at best fill a square of 0.4 m; the wall is 5 m wide
}

}  // namespace
}  // namespace loopsift
