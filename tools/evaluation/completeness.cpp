// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>
#include <random>
#include <string>

#include "tools/evaluation/surface_error.hpp"

namespace loopsift {
namespace {

/// Points as nanoflann wants to see them.
struct PointSet {
  Span<const Eigen::Vector3f> points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] float kdtree_get_pt(std::size_t k, std::size_t axis) const {
    return points[k][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointSet>, PointSet, 3,
                                                   std::size_t>;

const Eigen::Vector3f& corner(Span<const Eigen::Vector3f> vertices, const Eigen::Vector3i& triangle, int k) {
  return vertices[static_cast<std::size_t>(triangle[k])];
}

double area(Span<const Eigen::Vector3f> vertices, const Eigen::Vector3i& triangle) {
  const Eigen::Vector3f &a = corner(vertices, triangle, 0), &b = corner(vertices, triangle, 1),
                        &c = corner(vertices, triangle, 2);
  return 0.5 * static_cast<double>((b - a).cross(c - a).norm());
}

}  // namespace

Expected<std::vector<Eigen::Vector3f>> sample_mesh(Span<const Eigen::Vector3f> vertices,
                                                   Span<const Eigen::Vector3i> triangles, float spacing_m,
                                                   std::size_t max_points) {
  if (const Status status = check_mesh(vertices, triangles); !status.ok()) return status.error();
  double total = 0;
  for (const Eigen::Vector3i& t : triangles) total += area(vertices, t);
  if (!(total > 0)) return Error{ErrorCode::kFormat, "the triangles of the ground-truth mesh have no area"};
  const double spacing = static_cast<double>(spacing_m);
  const double per_m2 = std::min(1.0 / (spacing * spacing), static_cast<double>(max_points) / total);
  std::mt19937 random(1);
  const auto unit = [&random] { return static_cast<float>(random()) / 4294967296.0F; };
  std::vector<Eigen::Vector3f> samples;
  double due = 0.5;  // points that the area walked over so far still asks for
  for (const Eigen::Vector3i& t : triangles) {
    for (due += area(vertices, t) * per_m2; due >= 1; --due) {
      // Uniform in the triangle (Osada et al., Shape distributions, 2002, eq. 1).
      const float root = std::sqrt(unit()), share = unit();
      samples.push_back((1 - root) * corner(vertices, t, 0) + root * (1 - share) * corner(vertices, t, 1) +
                        root * share * corner(vertices, t, 2));
    }
  }
  return samples;
}

Expected<double> completeness(Span<const Eigen::Vector3f> samples, Span<const Eigen::Vector3f> map_points,
                              float within_m) {
  if (map_points.empty()) return Error{ErrorCode::kUsage, "the map is empty: there is no point to measure"};
  const PointSet set{map_points};
  const KdTree tree(3, set, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  const auto count = static_cast<std::ptrdiff_t>(samples.size());
  std::ptrdiff_t found = 0;
#pragma omp parallel for schedule(static) reduction(+ : found)
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    std::size_t nearest = 0;
    float squared = 0;
    const auto got = tree.knnSearch(samples[static_cast<std::size_t>(k)].data(), 1, &nearest, &squared);
    found += got > 0 && squared <= within_m * within_m ? 1 : 0;
  }
  return count > 0 ? static_cast<double>(found) / static_cast<double>(count) : 0.0;
}

}  // namespace loopsift
