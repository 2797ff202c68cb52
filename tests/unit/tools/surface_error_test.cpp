// SPDX-License-Identifier: MIT
#include "tools/evaluation/surface_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <random>

#include "tools/evaluation/point_ply.hpp"

namespace loopsift {
namespace {

using testing::HasSubstr;
using Points = std::vector<Eigen::Vector3f>;
using Triangles = std::vector<Eigen::Vector3i>;

TEST(ClosestPointOnTriangle, IsNearerThanAnySample) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> coordinate(-1, 1);
  const auto point = [&] {
    return Eigen::Vector3f(coordinate(random), coordinate(random), coordinate(random));
  };
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3f a = point(), b = point(), c = point(), p = 2 * point();
    const float distance = (closest_point_on_triangle(p, a, b, c) - p).norm();
    float sampled = 1e9F;
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const float u = static_cast<float>(i) / kSteps, v = static_cast<float>(j) / kSteps;
        sampled = std::min(sampled, (a + u * (b - a) + v * (c - a) - p).norm());
      }
    EXPECT_LE(distance, sampled + 1e-5F);
    EXPECT_GE(distance, sampled - 0.06F) << "the result is not on the triangle";
  }
}

/// The unit square at z = 0, as two triangles.
const Points kSquare = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
const Triangles kSquareTriangles = {{0, 1, 2}, {0, 2, 3}};

TEST(DistancesToMesh, AreToFacesEdgesAndCorners) {
  const Points points = {
      {0.5F, 0.25F, 0.1F}, {0.3F, 0.3F, -0.2F}, {2, 0.5F, 0}, {-3, -4, 0}, {0.5F, 0.5F, 0}};
  const auto distances = distances_to_mesh(points, kSquare, kSquareTriangles);
  ASSERT_TRUE(distances.ok());
  EXPECT_THAT(*distances, testing::Pointwise(testing::FloatNear(1e-6F), {0.1F, 0.2F, 1.0F, 5.0F, 0.0F}));
}

TEST(DistancesToMesh, AreTheLeastOverAllTriangles) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> coordinate(-1, 1);
  Points vertices, points;
  Triangles triangles;
  for (int k = 0; k < 300; ++k)
    vertices.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  for (int k = 0; k + 2 < 300; k += 3) triangles.emplace_back(k, k + 1, k + 2);
  for (int k = 0; k < 100; ++k)
    points.emplace_back(coordinate(random), coordinate(random), 3 * coordinate(random));
  const auto distances = distances_to_mesh(points, vertices, triangles);
  ASSERT_TRUE(distances.ok());
  for (std::size_t i = 0; i < points.size(); ++i) {
    float least = 1e9F;
    for (const Eigen::Vector3i& t : triangles) {
      const auto corner = [&](int k) { return vertices[static_cast<std::size_t>(t[k])]; };
      least = std::min(
          least, (closest_point_on_triangle(points[i], corner(0), corner(1), corner(2)) - points[i]).norm());
    }
    EXPECT_NEAR((*distances)[i], least, 1e-5F);
  }
}

TEST(DistancesToMesh, AMeshWithoutTrianglesOrWithABadIndexIsAnError) {
  const Points points = {{0, 0, 0}};
  const Triangles none, bad = {{0, 1, 4}};
  EXPECT_THAT(distances_to_mesh(points, kSquare, none).error().message, HasSubstr("no triangle"));
  EXPECT_THAT(distances_to_mesh(points, kSquare, bad).error().message, HasSubstr("triangle 0"));
}

TEST(SummarizeDistances, MeanAndNearestRankPercentiles) {
  std::vector<float> distances;
  for (int k = 100; k >= 1; --k) distances.push_back(static_cast<float>(k));
  const auto error = summarize_distances(distances);
  ASSERT_TRUE(error.ok());
  EXPECT_DOUBLE_EQ(error->mean_m, 50.5);
  EXPECT_DOUBLE_EQ(error->median_m, 50);
  EXPECT_DOUBLE_EQ(error->p95_m, 95);
  EXPECT_EQ(error->points, 100);
}

TEST(SummarizeDistances, AnEmptyMapIsAnError) {
  const auto error = summarize_distances({});
  ASSERT_FALSE(error.ok());
  EXPECT_EQ(error.error().code, ErrorCode::kUsage);
  EXPECT_THAT(error.error().message, HasSubstr("map is empty"));
}

class PlyPointsTest : public testing::Test {
 protected:
  std::string write(const std::string& content) const {
    const std::string path = testing::TempDir() + "points_" +
                             testing::UnitTest::GetInstance()->current_test_info()->name() + ".ply";
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  std::string error_of(const std::string& content) const {
    const auto points = read_ply_points(write(content));
    return points.ok() ? "" : points.error().message;
  }
};

TEST_F(PlyPointsTest, ReadsBinaryAmongOtherProperties) {
  std::string content =
      "ply\nformat binary_little_endian 1.0\ncomment made by a test\nelement vertex 2\n"
      "property uchar red\nproperty float x\nproperty double y\nproperty float z\nproperty float radius\n"
      "element face 0\nproperty list uchar int vertex_indices\nend_header\n";
  for (int k = 0; k < 2; ++k) {
    const float x = 1.5F + static_cast<float>(k), z = -3.0F, radius = 0.01F;
    const double y = 2.25;
    content += '\x7f';
    const auto append = [&](const void* value, std::size_t size) {
      content.append(static_cast<const char*>(value), size);
    };
    append(&x, sizeof x);
    append(&y, sizeof y);
    append(&z, sizeof z);
    append(&radius, sizeof radius);
  }
  const auto points = read_ply_points(write(content));
  ASSERT_TRUE(points.ok()) << points.error().message;
  EXPECT_EQ(*points, (Points{{1.5F, 2.25F, -3.0F}, {2.5F, 2.25F, -3.0F}}));

  content.pop_back();
  EXPECT_THAT(error_of(content), HasSubstr("1 of the 2 vertices"));
}

const std::string kAsciiHeader =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
    "z\nend_header\n";

TEST_F(PlyPointsTest, ReadsAscii) {
  const auto points = read_ply_points(write(kAsciiHeader + "1 2 3\n4 5 6\n"));
  ASSERT_TRUE(points.ok()) << points.error().message;
  EXPECT_EQ(*points, (Points{{1, 2, 3}, {4, 5, 6}}));
}

TEST_F(PlyPointsTest, BadFilesAreNamedWithTheirFault) {
  EXPECT_THAT(read_ply_points("/nowhere/map.ply").error().message,
              HasSubstr("/nowhere/map.ply: cannot be opened"));
  EXPECT_THAT(error_of("OFF\n"), HasSubstr("is not a PLY file"));
  EXPECT_THAT(error_of("ply\nformat binary_big_endian 1.0\n"), HasSubstr("binary_big_endian"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"),
              HasSubstr("within its header"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("no property 'y'"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int i\nend_header\n"),
              HasSubstr("does not begin with its vertices"));
  EXPECT_THAT(error_of(kAsciiHeader + "1 2 3\n4 5\n"), HasSubstr("1 of the 2 vertices"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int x\nend_header\n"),
              HasSubstr("type 'list'"));
}

TEST_F(PlyPointsTest, APositionThatIsNotFiniteIsAnError) {
  const float bad[3] = {1, std::numeric_limits<float>::quiet_NaN(), 3};
  std::string content = kAsciiHeader;
  content.replace(content.find("ascii"), 5, "binary_little_endian");
  content.replace(content.find("vertex 2"), 8, "vertex 1");
  content.append(reinterpret_cast<const char*>(bad), sizeof bad);
  EXPECT_THAT(error_of(content), HasSubstr("vertex 0 is not finite"));
}

}  // namespace
}  // namespace loopsift
