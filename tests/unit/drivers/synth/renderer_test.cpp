// SPDX-License-Identifier: MIT
#include "drivers/synth/renderer.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

const PinholeCamera kCamera{64, 48, 52.5F, 52.5F, 31.5F, 23.5F};

/// A square of side 2 · half in the plane z = depth; the identity pose looks at it along z.
Scene plane_at(float depth, float half) {
  TriangleMesh mesh;
  mesh.vertices = {{-half, -half, depth}, {half, -half, depth}, {half, half, depth}, {-half, half, depth}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return make_scene(std::move(mesh));
}

TEST(Renderer, PlaneAtKnownDepth) {
  const auto renderer = Renderer::create(plane_at(2.0F, 50.0F));
  ASSERT_TRUE(renderer.ok());
  RenderedFrame frame;
  (*renderer)->render(kCamera, Se3(), false, &frame);
  ASSERT_EQ(frame.depth.size(), 64U * 48U);
  EXPECT_TRUE(frame.color.empty());
  for (const float z : frame.depth) ASSERT_NEAR(z, 2.0F, 1e-5F);
  const float x = (0.0F - 31.5F) / 52.5F, y = (0.0F - 23.5F) / 52.5F;
  EXPECT_NEAR(frame.cosine.front(), 1.0F / std::sqrt(1.0F + x * x + y * y), 1e-5F);
}

TEST(Renderer, MovedAndTurnedCamera) {
  const auto renderer = Renderer::create(plane_at(3.0F, 50.0F));
  ASSERT_TRUE(renderer.ok());
  const double angle = 0.3;  // about the vertical: pixel columns see the plane at different depths
  const Se3 T_world_camera(so3_exp({0, angle, 0}), {0.2, -0.1, 1.0});
  RenderedFrame frame;
  (*renderer)->render(kCamera, T_world_camera, false, &frame);
  for (const int u : {0, 17, 63}) {
    const Eigen::Vector3d ray =
        T_world_camera.rotation() * kCamera.unproject(static_cast<float>(u), 10.0F, 1.0F).cast<double>();
    EXPECT_NEAR(frame.depth[static_cast<std::size_t>(10 * 64 + u)], 2.0 / ray.z(), 1e-4);
  }
}

TEST(Renderer, NothingBehindTheEdge) {
  const auto renderer = Renderer::create(plane_at(2.0F, 0.5F));
  ASSERT_TRUE(renderer.ok());
  RenderedFrame frame;
  (*renderer)->render(kCamera, Se3(), true, &frame);
  // The square covers ±0.5 · 52.5 / 2 = ±13.1 pixels about the principal point.
  EXPECT_GT(frame.depth[24 * 64 + 31 - 12], 0.0F);
  EXPECT_EQ(frame.depth[24 * 64 + 31 - 14], 0.0F);
  EXPECT_EQ(frame.color[24 * 64 + 2].r, 0);
  EXPECT_GT(frame.color[24 * 64 + 31].r, 0);
}

TEST(Renderer, VertexColorsAreInterpolated) {
  Scene scene = plane_at(1.0F, 1.0F);
  scene.mesh.colors = {{200, 0, 0}, {200, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const auto renderer = Renderer::create(scene);
  ASSERT_TRUE(renderer.ok());
  RenderedFrame frame;
  (*renderer)->render(kCamera, Se3(), true, &frame);
  const auto red = [&](int v) { return int{frame.color[static_cast<std::size_t>(v * 64 + 31)].r}; };
  EXPECT_GT(red(5), red(20));
  EXPECT_GT(red(20), red(40));
  EXPECT_EQ(frame.color[20 * 64 + 31].g, 0);
}

TEST(SceneBuilder, BoxesAreClosedAndStandWhereTheyArePut) {
  SceneBuilder builder;
  builder.place({2.0F, 0.0F, 0.0F, 90.0F});  // local x points along world y, local y along world −x
  builder.box({-0.5F, -1.0F, 0.0F}, {0.5F, 1.0F, 2.0F}, Material());
  const Scene scene = builder.finish();
  Eigen::Vector3f low = scene.mesh.vertices[0], high = low;
  for (const Eigen::Vector3f& v : scene.mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  EXPECT_TRUE(low.isApprox(Eigen::Vector3f(1.0F, -0.5F, 0.0F), 1e-5F)) << low.transpose();
  EXPECT_TRUE(high.isApprox(Eigen::Vector3f(3.0F, 0.5F, 2.0F), 1e-5F)) << high.transpose();
  // Closed: the signed volume of the tetrahedra to the origin is the volume, positive with outward triangles.
  double volume = 0;
  for (const Eigen::Vector3i& t : scene.mesh.triangles) {
    const auto at = [&](int i) -> Eigen::Vector3d {
      return scene.mesh.vertices[static_cast<std::size_t>(i)].cast<double>();
    };
    volume += at(t.x()).dot(at(t.y()).cross(at(t.z()))) / 6.0;
  }
  EXPECT_NEAR(volume, 4.0, 1e-4);
}

}  // namespace
}  // namespace loopsift
