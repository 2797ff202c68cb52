// SPDX-License-Identifier: MIT
#include "core/proposal/point_grid.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace loopsift {
namespace {

std::vector<Eigen::Vector3f> random_points(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  std::vector<Eigen::Vector3f> points;
  for (int k = 0; k < count; ++k)
    points.emplace_back(uniform(random), uniform(random), 0.3F * uniform(random));
  return points;
}

TEST(RadiusIndex, FindsWhatBruteForceFinds) {
  const std::vector<Eigen::Vector3f> points = random_points(500);
  RadiusIndex index;
  index.build(points, 0.25F);
  for (const float radius : {0.25F, 0.1F}) {
    for (const Eigen::Vector3f& p : random_points(60)) {
      std::vector<std::uint32_t> expected, found;
      for (std::uint32_t k = 0; k < points.size(); ++k)
        if ((points[k] - p).squaredNorm() <= radius * radius) expected.push_back(k);
      index.for_each_within(p, radius, [&](std::uint32_t k, float d2) {
        EXPECT_FLOAT_EQ(d2, (points[k] - p).squaredNorm());
        found.push_back(k);
      });
      EXPECT_THAT(found, ::testing::UnorderedElementsAreArray(expected));
    }
  }
}

TEST(RadiusIndex, AnswersOutsideItsBoxAndWhenEmpty) {
  RadiusIndex index;
  const auto count_near = [&](const Eigen::Vector3f& p) {
    int count = 0;
    index.for_each_within(p, 0.25F, [&](std::uint32_t, float) { ++count; });
    return count;
  };
  index.build({}, 0.25F);
  EXPECT_EQ(count_near(Eigen::Vector3f::Zero()), 0);
  std::vector<Eigen::Vector3f> one = {Eigen::Vector3f(1, 2, 3)};
  index.build(one, 0.25F);
  EXPECT_EQ(count_near({1, 2, 3.2F}), 1);
  EXPECT_EQ(count_near({1, 2, 2.8F}), 1);
  EXPECT_EQ(count_near({-40, 70, 3}), 0);
}

TEST(NearestField, IsAsNearAsTheCellAllows) {
  const std::vector<Eigen::Vector3f> points = random_points(400);
  constexpr float kReach = 0.2F, kCell = 0.05F;
  NearestField field;
  field.build(points, kReach, kCell, 1 << 20);
  const float half_diagonal = 0.5F * kCell * std::sqrt(3.0F);
  int answered = 0;
  for (Eigen::Vector3f p : random_points(300)) {
    p += Eigen::Vector3f(0.013F, -0.021F, 0.017F);
    float nearest = std::numeric_limits<float>::max();
    for (const Eigen::Vector3f& q : points) nearest = std::min(nearest, (q - p).norm());
    const std::uint16_t found = field.nearest(p);
    if (found == NearestField::kNone) {
      EXPECT_GT(nearest, kReach - half_diagonal);
      continue;
    }
    ++answered;
    EXPECT_LE((points[found] - p).norm(), nearest + 2 * half_diagonal);
  }
  EXPECT_GT(answered, 200);
}

TEST(NearestField, SaysNoneFarAwayOutsideAndWhenEmpty) {
  NearestField field;
  field.build({}, 0.2F, 0.05F, 1000);
  EXPECT_EQ(field.nearest(Eigen::Vector3f::Zero()), NearestField::kNone);
  std::vector<Eigen::Vector3f> two = {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(2, 0, 0)};
  field.build(two, 0.2F, 0.05F, 1 << 20);
  EXPECT_EQ(field.nearest({0.1F, 0, 0}), 0);
  EXPECT_EQ(field.nearest({1.9F, 0, 0}), 1);
  EXPECT_EQ(field.nearest({1, 0, 0}), NearestField::kNone);
  EXPECT_EQ(field.nearest({0, 0, 9}), NearestField::kNone);
  EXPECT_EQ(field.nearest({std::numeric_limits<float>::quiet_NaN(), 0, 0}), NearestField::kNone);
}

TEST(NearestField, StaysWithinItsCells) {
  std::vector<Eigen::Vector3f> far_apart = {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(50, 50, 50)};
  const CellBox box = CellBox::around(far_apart, 0.2F, 0.05F, 100000);
  EXPECT_LE(box.cell_count(), 100000U);
  EXPECT_GT(box.cell_m, 0.05F);
  EXPECT_TRUE(box.contains(box.cell_of(far_apart[0])) && box.contains(box.cell_of(far_apart[1])));
}

}  // namespace
}  // namespace loopsift
