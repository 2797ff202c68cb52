// SPDX-License-Identifier: MIT
// How far a map is from the true surface. In: map points in the frame of the mesh, and the mesh. Out:
// distances from each point to the nearest place on a triangle. Embree's point query finds the triangles.
// Desk code: allocates, uses all cores, the same result on any number of them.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/base/result.hpp"
#include "core/base/span.hpp"

namespace loopsift {

struct SurfaceError {
  double mean_m = 0, median_m = 0, p95_m = 0;
  int points = 0;
};

/// The point of triangle a b c nearest to p (Ericson, Real-Time Collision Detection, 2005, sec. 5.1.5).
[[nodiscard]] Eigen::Vector3f closest_point_on_triangle(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                                                        const Eigen::Vector3f& b, const Eigen::Vector3f& c);

/// That there are triangles and that they hold indices of vertices.
[[nodiscard]] Status check_mesh(Span<const Eigen::Vector3f> vertices, Span<const Eigen::Vector3i> triangles);

/// Distance from each point to the mesh, metres. Triangles hold vertex indices. Errors: no triangle, an index
/// past the vertices.
[[nodiscard]] Expected<std::vector<float>> distances_to_mesh(Span<const Eigen::Vector3f> points,
                                                             Span<const Eigen::Vector3f> vertices,
                                                             Span<const Eigen::Vector3i> triangles);

/// Mean and nearest-rank percentiles. Error: no distance at all (an empty map).
[[nodiscard]] Expected<SurfaceError> summarize_distances(std::vector<float> distances_m);

/// Points spread evenly over the triangles' area, one per `spacing_m`² (but at most `max_points` in all, then
/// farther apart); where they fall in a triangle is drawn from a fixed seed. Errors as distances_to_mesh.
[[nodiscard]] Expected<std::vector<Eigen::Vector3f>> sample_mesh(Span<const Eigen::Vector3f> vertices,
                                                                 Span<const Eigen::Vector3i> triangles,
                                                                 float spacing_m, std::size_t max_points);

/// Share of `samples` of the true surface that have a map point within `within_m`. What the camera never saw
/// counts as missing. Error: an empty map.
[[nodiscard]] Expected<double> completeness(Span<const Eigen::Vector3f> samples,
                                            Span<const Eigen::Vector3f> map_points, float within_m);

}  // namespace loopsift
