// SPDX-License-Identifier: MIT
#include "drivers/synth/scene.hpp"

#include <cmath>

namespace loopsift {
namespace {

constexpr float kPi = 3.14159265F;
constexpr int kSides = 20;  // of round primitives
constexpr int kRings = 8;   // of ellipsoids

}  // namespace

void Scene::remove_texture() {
  const Material grey{{0.62F, 0.62F, 0.62F}, {0.62F, 0.62F, 0.62F}, Pattern::kPlain, 1.0F};
  for (Material& material : materials) material = grey;
  mesh.colors.clear();
}

Scene make_scene(TriangleMesh mesh) {
  Scene scene;
  scene.material_of.assign(mesh.triangles.size(), 0);
  scene.materials = {{{0.75F, 0.7F, 0.62F}, {0.4F, 0.42F, 0.46F}, Pattern::kMottled, 0.8F}};
  scene.mesh = std::move(mesh);
  return scene;
}

void SceneBuilder::place(const Placement& placement) {
  placement_ = placement;
  cos_yaw_ = std::cos(placement.yaw_deg * kPi / 180.0F);
  sin_yaw_ = std::sin(placement.yaw_deg * kPi / 180.0F);
}

int SceneBuilder::vertex(const Eigen::Vector3f& local, float u, float v) {
  scene_.mesh.vertices.emplace_back(placement_.x + cos_yaw_ * local.x() - sin_yaw_ * local.y(),
                                    placement_.y + sin_yaw_ * local.x() + cos_yaw_ * local.y(),
                                    placement_.z + local.z());
  scene_.uv.emplace_back(u, v);
  return static_cast<int>(scene_.mesh.vertices.size()) - 1;
}

void SceneBuilder::start(const Material& material) { scene_.materials.push_back(material); }

void SceneBuilder::triangle(int a, int b, int c) {
  scene_.mesh.triangles.emplace_back(a, b, c);
  scene_.material_of.push_back(static_cast<std::uint16_t>(scene_.materials.size() - 1));
}

void SceneBuilder::quad(const Eigen::Vector3f& corner, const Eigen::Vector3f& along_u,
                        const Eigen::Vector3f& along_v) {
  const float u = along_u.norm(), v = along_v.norm();
  const int a = vertex(corner, 0, 0), b = vertex(corner + along_u, u, 0);
  const int c = vertex(corner + along_u + along_v, u, v), d = vertex(corner + along_v, 0, v);
  triangle(a, b, c);
  triangle(a, c, d);
}

void SceneBuilder::box(const Eigen::Vector3f& low, const Eigen::Vector3f& high, const Material& material) {
  start(material);
  const Eigen::Vector3f d = high - low;
  const Eigen::Vector3f x(d.x(), 0, 0), y(0, d.y(), 0), z(0, 0, d.z());
  quad(low, x, z);           // back of the object's front: y = low
  quad(low + x + y, -x, z);  // y = high
  quad(low + y, -y, z);      // x = low
  quad(low + x, y, z);       // x = high
  quad(low + y, x, -y);      // z = low
  quad(low + z, x, y);       // z = high
}

void SceneBuilder::frustum(const Eigen::Vector3f& base, float bottom, float top, float height,
                           const Material& material) {
  start(material);
  const int low = vertex(base, 0, 0), high = vertex(base + Eigen::Vector3f(0, 0, height), 0, 0);
  int previous_low = 0, previous_high = 0;
  for (int i = 0; i <= kSides; ++i) {
    const float angle = 2.0F * kPi * static_cast<float>(i) / kSides;
    const Eigen::Vector3f out(std::cos(angle), std::sin(angle), 0);
    const float u = angle * std::max(bottom, top);
    const int a = vertex(base + bottom * out, u, 0);
    const int b = vertex(base + top * out + Eigen::Vector3f(0, 0, height), u, height);
    if (i > 0) {
      triangle(previous_low, a, b);
      triangle(previous_low, b, previous_high);
      triangle(low, a, previous_low);
      triangle(high, previous_high, b);
    }
    previous_low = a;
    previous_high = b;
  }
}

void SceneBuilder::ellipsoid(const Eigen::Vector3f& center, const Eigen::Vector3f& radii,
                             const Material& material) {
  start(material);
  const int first = static_cast<int>(scene_.mesh.vertices.size());
  for (int ring = 0; ring <= kRings; ++ring) {
    const float elevation = kPi * (static_cast<float>(ring) / kRings - 0.5F);
    for (int i = 0; i <= kSides; ++i) {
      const float angle = 2.0F * kPi * static_cast<float>(i) / kSides;
      const Eigen::Vector3f out(std::cos(angle) * std::cos(elevation), std::sin(angle) * std::cos(elevation),
                                std::sin(elevation));
      vertex(center + out.cwiseProduct(radii), angle * radii.x(), elevation * radii.z());
    }
  }
  for (int ring = 0; ring < kRings; ++ring)
    for (int i = 0; i < kSides; ++i) {
      const int a = first + ring * (kSides + 1) + i, above = a + kSides + 1;
      if (ring > 0) triangle(a, a + 1, above + 1);
      if (ring < kRings - 1) triangle(a, above + 1, above);
    }
}

}  // namespace loopsift
