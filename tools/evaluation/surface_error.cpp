// SPDX-License-Identifier: MIT
#include "tools/evaluation/surface_error.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>

namespace loopsift {
namespace {

using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, decltype(&rtcReleaseScene)>;

struct Query {
  Span<const Eigen::Vector3f> vertices;
  Span<const Eigen::Vector3i> triangles;
  Eigen::Vector3f point;
  float distance;
};

const Eigen::Vector3f& corner(const Query& query, unsigned triangle, int k) {
  return query.vertices[static_cast<std::size_t>(query.triangles[triangle][k])];
}

/// Called by Embree for each triangle within the query's radius, which it shrinks.
bool shrink_to_triangle(RTCPointQueryFunctionArguments* arguments) {
  auto& query = *static_cast<Query*>(arguments->userPtr);
  const unsigned t = arguments->primID;
  const Eigen::Vector3f nearest =
      closest_point_on_triangle(query.point, corner(query, t, 0), corner(query, t, 1), corner(query, t, 2));
  const float distance = (nearest - query.point).norm();
  if (!(distance < query.distance)) return false;
  query.distance = distance;
  arguments->query->radius = distance;
  return true;
}

Scene build_scene(RTCDevice device, Span<const Eigen::Vector3f> vertices,
                  Span<const Eigen::Vector3i> triangles) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertex_buffer = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                sizeof(Eigen::Vector3f), vertices.size());
  std::memcpy(vertex_buffer, vertices.data()->data(), vertices.size() * sizeof(Eigen::Vector3f));
  void* index_buffer = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                               sizeof(Eigen::Vector3i), triangles.size());
  std::memcpy(index_buffer, triangles.data()->data(), triangles.size() * sizeof(Eigen::Vector3i));
  rtcCommitGeometry(geometry);
  Scene scene(rtcNewScene(device), &rtcReleaseScene);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  return scene;
}

float distance_to_scene(RTCScene scene, const Eigen::Vector3f& point, Span<const Eigen::Vector3f> vertices,
                        Span<const Eigen::Vector3i> triangles) {
  Query query{vertices, triangles, point, std::numeric_limits<float>::infinity()};
  RTCPointQuery ball{point.x(), point.y(), point.z(), 0.0F, query.distance};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene, &ball, &context, &shrink_to_triangle, &query);
  return query.distance;
}

double percentile(const std::vector<float>& sorted, double fraction) {
  const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(sorted.size())));
  return static_cast<double>(sorted[std::max<std::size_t>(rank, 1) - 1]);
}

}  // namespace

Status check_mesh(Span<const Eigen::Vector3f> vertices, Span<const Eigen::Vector3i> triangles) {
  if (triangles.empty()) return Error{ErrorCode::kUsage, "the ground-truth mesh has no triangle"};
  const auto count = static_cast<int>(vertices.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (triangles[t].minCoeff() < 0 || triangles[t].maxCoeff() >= count)
      return Error{ErrorCode::kFormat, "triangle " + std::to_string(t) +
                                           " of the mesh names a vertex past its " + std::to_string(count)};
  return {};
}

Eigen::Vector3f closest_point_on_triangle(const Eigen::Vector3f& p, const Eigen::Vector3f& a,
                                          const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const float inverse = 1.0F / (va + vb + vc);
  return a + vb * inverse * ab + vc * inverse * ac;
}

Expected<std::vector<float>> distances_to_mesh(Span<const Eigen::Vector3f> points,
                                               Span<const Eigen::Vector3f> vertices,
                                               Span<const Eigen::Vector3i> triangles) {
  if (const Status status = check_mesh(vertices, triangles); !status.ok()) return status.error();
  const Device device(rtcNewDevice(nullptr), &rtcReleaseDevice);
  const Scene scene = build_scene(device.get(), vertices, triangles);
  std::vector<float> distances(points.size());
  const auto count = static_cast<std::ptrdiff_t>(points.size());
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    distances[i] = distance_to_scene(scene.get(), points[i], vertices, triangles);
  }
  return distances;
}

Expected<SurfaceError> summarize_distances(std::vector<float> distances_m) {
  if (distances_m.empty()) return Error{ErrorCode::kUsage, "the map is empty: there is no point to measure"};
  std::sort(distances_m.begin(), distances_m.end());
  double sum = 0;
  for (const float d : distances_m) sum += static_cast<double>(d);
  return SurfaceError{sum / static_cast<double>(distances_m.size()), percentile(distances_m, 0.5),
                      percentile(distances_m, 0.95), static_cast<int>(distances_m.size())};
}

}  // namespace loopsift
