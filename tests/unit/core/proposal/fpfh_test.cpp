// SPDX-License-Identifier: MIT
#include "core/proposal/fpfh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

RegistrationCloud corner_cloud() {
  test::SurfelCloud surfels = test::furnished_corner(Se3());
  RegistrationCloud cloud;
  VoxelThinner(RegistrationCloudOptions()).thin(surfels.span(), &cloud);
  return cloud;
}

RegistrationCloud moved(const RegistrationCloud& cloud, const Se3& T) {
  const Se3f Tf(T);
  RegistrationCloud result = cloud;
  for (Eigen::Vector3f& p : result.points) p = Tf * p;
  for (Eigen::Vector3f& n : result.normals) n = Tf.R * n;
  return result;
}

float distance(const Fpfh& a, const Fpfh& b) {
  float sum = 0;
  for (std::size_t d = 0; d < a.size(); ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return std::sqrt(sum);
}

FpfhOptions all_points() {
  FpfhOptions options;
  options.max_keypoints = 60000;
  return options;
}

TEST(Fpfh, DoesNotChangeUnderRigidMotion) {
  const RegistrationCloud cloud = corner_cloud();
  const RegistrationCloud turned = moved(cloud, test::motion(2, -1, 0.5, 0.4, -1.9, 0.8));
  FpfhExtractor extractor(all_points());
  Keypoints before, after;
  extractor.extract(cloud, &before);
  extractor.extract(turned, &after);
  ASSERT_EQ(before.points, after.points);
  ASSERT_GT(before.size(), 1000U);
  std::vector<float> distances;
  for (std::size_t k = 0; k < before.size(); ++k)
    distances.push_back(distance(before.features[k], after.features[k]));
  std::sort(distances.begin(), distances.end());
  // Angles on the border of two bins, as all on a perfect plane are, may fall to either side by rounding.
  EXPECT_LT(distances[distances.size() / 2], 0.3F);
  EXPECT_LT(distance(before.mean, after.mean), 0.3F);
}

TEST(Fpfh, HistogramsSumToOne) {
  FpfhExtractor extractor(all_points());
  Keypoints keypoints;
  extractor.extract(corner_cloud(), &keypoints);
  for (const Fpfh& f : keypoints.features) {
    for (std::size_t h = 0; h < 3; ++h) {
      float sum = 0;
      for (std::size_t b = 0; b < kFpfhBins; ++b) sum += f[h * kFpfhBins + b] * f[h * kFpfhBins + b];
      EXPECT_NEAR(sum, 1.0F, 1e-4F);
    }
  }
}

TEST(Fpfh, TellsAPlaneFromABall) {
  test::SurfelCloud plane = test::flat_floor(), ball;
  test::SurfaceSampler(
      Se3(), [](const Eigen::Vector3d&) { return true; }, &ball)
      .sphere({0, 0, 0}, 0.3);
  VoxelThinner thinner{RegistrationCloudOptions()};
  FpfhExtractor extractor(all_points());
  RegistrationCloud cloud;
  Keypoints of_plane, of_ball;
  thinner.thin(plane.span(), &cloud);
  extractor.extract(cloud, &of_plane);
  thinner.thin(ball.span(), &cloud);
  extractor.extract(cloud, &of_ball);
  ASSERT_GT(of_plane.size(), 0U);
  ASSERT_GT(of_ball.size(), 0U);
  EXPECT_GT(distance(of_plane.mean, of_ball.mean), 0.5F);
}

TEST(Fpfh, KeepsTheMostDistinctiveInOrder) {
  const RegistrationCloud cloud = corner_cloud();
  FpfhOptions options;
  options.max_keypoints = 100;
  Keypoints some, all;
  FpfhExtractor(options).extract(cloud, &some);
  FpfhExtractor(all_points()).extract(cloud, &all);
  ASSERT_EQ(some.size(), 100U);
  EXPECT_TRUE(std::is_sorted(some.points.begin(), some.points.end()));
  float least_kept = std::numeric_limits<float>::max();
  for (const Fpfh& f : some.features) least_kept = std::min(least_kept, distance(f, all.mean));
  const auto better = std::count_if(all.features.begin(), all.features.end(), [&](const Fpfh& f) {
    return distance(f, all.mean) > least_kept + 1e-5F;
  });
  EXPECT_LT(better, 100);
}

TEST(Fpfh, SaysNothingAboutLonelyPoints) {
  RegistrationCloud cloud;
  for (int k = 0; k < 20; ++k) {
    cloud.points.emplace_back(static_cast<float>(k), 0.0F, 0.0F);
    cloud.normals.emplace_back(0.0F, 0.0F, 1.0F);
  }
  Keypoints keypoints;
  FpfhExtractor extractor{FpfhOptions()};
  extractor.extract(cloud, &keypoints);
  EXPECT_EQ(keypoints.size(), 0U);
  extractor.extract(RegistrationCloud(), &keypoints);
  EXPECT_EQ(keypoints.size(), 0U);
}

std::vector<Fpfh> random_features(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  std::vector<Fpfh> features(static_cast<std::size_t>(count));
  for (Fpfh& f : features)
    for (float& v : f) v = uniform(random);
  return features;
}

std::size_t nearest(const Fpfh& f, const std::vector<Fpfh>& others) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < others.size(); ++k)
    if (distance(f, others[k]) < distance(f, others[best])) best = k;
  return best;
}

TEST(FeatureMatcher, FindsTheMutualNearest) {
  const std::vector<Fpfh> target = random_features(77, 1), source = random_features(50, 2);
  FeatureMatcher matcher;
  matcher.set_target(target);
  std::vector<Match> matches;
  matcher.match(source, 1000, &matches);
  std::size_t expected = 0;
  for (std::size_t s = 0; s < source.size(); ++s)
    if (nearest(target[nearest(source[s], target)], source) == s) ++expected;
  ASSERT_EQ(matches.size(), expected);
  ASSERT_GT(expected, 3U);
  for (const Match& m : matches) {
    EXPECT_EQ(nearest(source[m.source], target), m.target);
    EXPECT_NEAR(std::sqrt(m.squared_distance), distance(source[m.source], target[m.target]), 1e-3F);
  }
  EXPECT_TRUE(std::is_sorted(matches.begin(), matches.end(), [](const Match& a, const Match& b) {
    return a.squared_distance < b.squared_distance;
  }));
  const Match best = matches.front();
  matcher.match(source, 3, &matches);
  ASSERT_EQ(matches.size(), 3U);
  EXPECT_EQ(matches.front().source, best.source);
}

TEST(FeatureMatcher, HasNothingForEmptyLists) {
  FeatureMatcher matcher;
  std::vector<Match> matches(1);
  matcher.set_target({});
  const std::vector<Fpfh> source = random_features(5, 1), target = random_features(5, 2);
  matcher.match(source, 10, &matches);
  EXPECT_TRUE(matches.empty());
  matcher.set_target(target);
  matcher.match({}, 10, &matches);
  EXPECT_TRUE(matches.empty());
}

}  // namespace
}  // namespace loopsift
