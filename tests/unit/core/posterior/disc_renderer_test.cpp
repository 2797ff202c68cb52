// SPDX-License-Identifier: MIT
#include "core/posterior/disc_renderer.hpp"

#include <gtest/gtest.h>

#include <random>

namespace loopsift {
namespace {

constexpr float kMin = 0.3F, kMax = 6.0F;
constexpr PinholeCamera kCamera = {43, 31, 40, 42, 20.7F, 15.2F};  // a width that is no multiple of eight

struct Disc {
  Eigen::Vector3f p, n;
  float radius;
};

// Discs in the form that the renderer takes, with their chunks.
struct Discs {
  explicit Discs(const std::vector<Disc>& discs) {
    for (const Disc& d : discs) {
      const float values[7] = {d.p.x(), d.p.y(), d.p.z(), d.n.x(), d.n.y(), d.n.z(), d.radius};
      for (int a = 0; a < 7; ++a) arrays[a].push_back(values[a]);
    }
    chunks.resize((discs.size() + kChunkSize - 1) / kChunkSize);
    surfels = {arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5], arrays[6], chunks};
    bound_chunks(&surfels);
  }
  std::vector<float> arrays[7];
  std::vector<SurfelChunk> chunks;
  ScoreSurfels surfels;
};

// An image with guard values behind its rows' padding and around it.
struct Canvas {
  explicit Canvas(int stride = padded_stride(kCamera.width)) {
    const auto size = static_cast<std::size_t>(stride) * static_cast<std::size_t>(kCamera.height);
    values.assign(size + 2 * kGuards, kGuard);
    image = {values.data() + kGuards, kCamera.width, kCamera.height, stride};
    for (int y = 0; y < kCamera.height; ++y) std::fill_n(image.row(y), padded_stride(kCamera.width), 0.0F);
  }
  [[nodiscard]] bool guards_untouched() const {
    for (std::size_t k = 0; k < kGuards; ++k)
      if (values[k] != kGuard || values[values.size() - 1 - k] != kGuard) return false;
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = padded_stride(kCamera.width); x < image.stride; ++x)
        if (image.row(y)[x] != kGuard) return false;
    return true;
  }
  static constexpr float kGuard = -77.0F;
  static constexpr std::size_t kGuards = 128;
  std::vector<float> values;
  ImageView<float> image;
};

Canvas rendered(const std::vector<Disc>& discs, const Se3& T = {}) {
  Discs d(discs);
  Canvas canvas;
  render_discs(d.surfels, T, kCamera, kMin, kMax, canvas.image);
  return canvas;
}

Canvas rendered_plain(const std::vector<Disc>& discs, const Se3& T = {}) {
  Discs d(discs);
  Canvas canvas;
  render_discs_plain(d.surfels, T, kCamera, kMin, kMax, canvas.image);
  return canvas;
}

int predicted_pixels(const Canvas& canvas) {
  int count = 0;
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x) count += canvas.image(x, y) > 0 ? 1 : 0;
  return count;
}

// In and around the view, behind it, near, far, at all angles, from a fraction of a pixel to half the image.
std::vector<Disc> random_discs(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  std::vector<Disc> discs;
  for (int k = 0; k < count; ++k) {
    const float z = -1.0F + 8.0F * unit(random);
    const Eigen::Vector3f p(1.0F * z * (unit(random) - 0.5F), 1.0F * z * (unit(random) - 0.5F), z);
    Eigen::Vector3f n(normal(random), normal(random), normal(random));
    if (n.dot(p) > 0 && unit(random) < 0.8F) n = -n;  // most of them face the camera
    discs.push_back({p, n.normalized(), 0.01F + 0.2F * unit(random) * unit(random)});
  }
  return discs;
}

// Distance on the disc's plane from its centre to where the pixel's ray meets it, and the depth there.
double distance_on_disc(const Disc& d, int x, int y, double* depth) {
  const Eigen::Vector3d ray =
      kCamera.unproject(static_cast<float>(x), static_cast<float>(y), 1.0F).cast<double>();
  const Eigen::Vector3d p = d.p.cast<double>(), n = d.n.cast<double>();
  *depth = n.dot(p) / n.dot(ray);
  return (*depth * ray - p).norm();
}

// The fast form takes the distance on the disc to first order in the pixel, which is the exact one times the
// ratio of the depth at the disc's centre to that at the pixel. So the two may differ only in the rim
// between.
TEST(RenderDiscs, EqualsThePlainFormButForARim) {
  int compared = 0, in_rim = 0;  // of discs that are small against their distance
  for (const Disc& disc : random_discs(4000, 1)) {
    const Canvas fast = rendered({disc}), plain = rendered_plain({disc});
    const int counts = disc.radius < 0.05F * disc.p.z() ? 1 : 0;
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        const float a = fast.image(x, y), b = plain.image(x, y);
        if (a > 0 && b > 0) {
          ASSERT_NEAR(a / b, 1.0F, 1e-4F) << "pixel " << x << ' ' << y;
          compared += counts;
        } else if (a > 0 || b > 0) {
          double depth = 0;
          const double distance = distance_on_disc(disc, x, y, &depth);
          const double rim = std::abs(depth / static_cast<double>(disc.p.z()) - 1.0) + 1e-3;
          ASSERT_LE(std::abs(distance / static_cast<double>(disc.radius) - 1.0), rim);
          in_rim += counts;
        }
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_LT(in_rim, compared / 20);
}

TEST(RenderDiscs, SkipsTheSameDiscsAsThePlainForm) {
  int visible = 0, skipped = 0;
  for (const Disc& disc : random_discs(4000, 2)) {
    if (disc.radius > 0.05F * disc.p.z()) continue;  // near ones may be in sight by their rim alone
    const int fast = predicted_pixels(rendered({disc})), plain = predicted_pixels(rendered_plain({disc}));
    (fast > 0 ? visible : skipped) += 1;
    if ((fast > 0) != (plain > 0)) {
      EXPECT_LE(std::max(fast, plain), 1) << "a disc of several pixels is in one form only";
    }
  }
  EXPECT_GT(visible, 300);
  EXPECT_GT(skipped, 300);
}

TEST(RenderDiscs, SkipsBacksGrazingDiscsAndDepthsOutOfRange) {
  const Eigen::Vector3f toward(0, 0, -1);
  EXPECT_GT(predicted_pixels(rendered({{{0, 0, 2}, toward, 0.1F}})), 0);
  EXPECT_EQ(predicted_pixels(rendered({{{0, 0, 2}, -toward, 0.1F}})), 0) << "shows its back";
  EXPECT_EQ(predicted_pixels(rendered({{{0, 0, -2}, toward, 0.1F}})), 0) << "is behind the camera";
  EXPECT_EQ(predicted_pixels(rendered({{{0, 0, 0.9F * kMin}, toward, 0.1F}})), 0) << "is too near";
  EXPECT_EQ(predicted_pixels(rendered({{{0, 0, 1.1F * kMax}, toward, 0.1F}})), 0) << "is too far";
  EXPECT_EQ(predicted_pixels(rendered({{{9, 0, 2}, toward, 0.1F}})), 0) << "is beside the view";
  const auto tilted = [](float cosine) {
    return Disc{{0, 0, 2}, Eigen::Vector3f(std::sqrt(1 - cosine * cosine), 0, -cosine), 0.1F};
  };
  EXPECT_GT(predicted_pixels(rendered({tilted(1.1F * kGrazingCosine)})), 0);
  EXPECT_EQ(predicted_pixels(rendered({tilted(0.9F * kGrazingCosine)})), 0);
}

TEST(Frustum, MeetsSpheresThatReachIntoTheView) {
  const Frustum frustum(kCamera, kMin, kMax);
  const float edge = (42.5F - kCamera.cx) / kCamera.fx * 2.0F;  // of the image's right side at 2 m
  const float slant = std::sqrt(1.0F + 0.25F * edge * edge);    // from there outward to a sphere's centre
  EXPECT_TRUE(frustum.meets({0, 0, 2}, 0));
  EXPECT_TRUE(frustum.meets({edge + 0.099F * slant, 0, 2}, 0.1F));
  EXPECT_FALSE(frustum.meets({edge + 0.101F * slant, 0, 2}, 0.1F));
  EXPECT_FALSE(frustum.meets({0, 9, 2}, 0.1F));
  EXPECT_FALSE(frustum.meets({-9, 0, 2}, 0.1F));
  EXPECT_TRUE(frustum.meets({0, 0, kMax + 0.09F}, 0.1F));
  EXPECT_FALSE(frustum.meets({0, 0, kMax + 0.11F}, 0.1F));
  EXPECT_FALSE(frustum.meets({0, 0, kMin - 0.11F}, 0.1F));
}

TEST(RenderDiscs, WritesThePixelAtTheCentreOfATinyDisc) {
  const Canvas canvas = rendered({{kCamera.unproject(12.3F, 7.4F, 3.0F), {0, 0, -1}, 0.001F}});
  EXPECT_EQ(predicted_pixels(canvas), 1);
  EXPECT_NEAR(canvas.image(12, 7), 1.0F / 3.0F, 1e-5F);
}

TEST(RenderDiscs, KeepsTheNearestOfTwo) {
  const Disc near{{0, 0, 1.5F}, {0, 0, -1}, 0.3F}, far{{0, 0, 2.5F}, {0, 0, -1}, 2.0F};
  const Canvas alone = rendered({near});
  for (const auto& discs : {std::vector<Disc>{near, far}, std::vector<Disc>{far, near}}) {
    const Canvas both = rendered(discs);
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x)
        EXPECT_NEAR(both.image(x, y), alone.image(x, y) > 0 ? 1.0F / 1.5F : 1.0F / 2.5F, 1e-5F);
  }
}

TEST(RenderDiscs, ManyDiscsAreTheNearestOfEach) {
  const std::vector<Disc> discs = random_discs(500, 4);
  const Canvas all = rendered(discs);
  Canvas nearest;
  for (const Disc& disc : discs) {
    const Canvas one = rendered({disc});
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x)
        nearest.image(x, y) = std::max(nearest.image(x, y), one.image(x, y));
  }
  int different = 0;
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x)
      different += std::abs(all.image(x, y) - nearest.image(x, y)) > 1e-4F * all.image(x, y) ? 1 : 0;
  EXPECT_LE(different, 2) << "rounding may move a disc's border by a pixel, no more";
  EXPECT_GT(predicted_pixels(all), kCamera.width * kCamera.height / 2);
}

TEST(RenderDiscs, MovesTheDiscsByThePose) {
  const Se3 T(so3_exp({0.1, -0.2, 0.05}), {0.2, -0.1, 0.4});
  std::vector<Disc> discs = random_discs(200, 5), moved = discs;
  const Se3f Tf(T);
  for (Disc& disc : moved) disc = {Tf * disc.p, Tf.R * disc.n, disc.radius};
  const Canvas a = rendered(discs, T), b = rendered(moved);
  int different = 0;
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x)
      different += std::abs(a.image(x, y) - b.image(x, y)) > 1e-3F * b.image(x, y) ? 1 : 0;
  EXPECT_LE(different, kCamera.width * kCamera.height / 100);
}

TEST(RenderDiscs, StaysWithinTheImageAndItsPadding) {
  const std::vector<Disc> discs = random_discs(3000, 6);
  const Canvas canvas = rendered(discs);
  EXPECT_TRUE(canvas.guards_untouched());
  Discs d(discs);
  Canvas wide(padded_stride(kCamera.width) + 24);
  render_discs(d.surfels, {}, kCamera, kMin, kMax, wide.image);
  EXPECT_TRUE(wide.guards_untouched());
  for (int y = 0; y < kCamera.height; ++y)  // what goes into the padding never shows in the next row
    for (int x = 0; x < kCamera.width; ++x) EXPECT_EQ(canvas.image(x, y), wide.image(x, y));
}

// Smaller than the two rows that are drawn at once.
TEST(RenderDiscs, DrawsIntoAnImageOfOneRow) {
  Canvas canvas;
  PinholeCamera camera = kCamera;
  camera.height = 1;
  std::vector<float> row(static_cast<std::size_t>(padded_stride(camera.width)), 0.0F);
  row.insert(row.begin(), Canvas::kGuards, Canvas::kGuard);
  row.insert(row.end(), Canvas::kGuards, Canvas::kGuard);
  const ImageView<float> image(row.data() + Canvas::kGuards, camera.width, 1, padded_stride(camera.width));
  Discs discs(random_discs(500, 8));
  render_discs(discs.surfels, {}, camera, kMin, kMax, image);
  render_discs(discs.surfels, {}, kCamera, kMin, kMax, canvas.image);
  for (int x = 0; x < camera.width; ++x) EXPECT_EQ(image(x, 0), canvas.image(x, 0));
  EXPECT_EQ(std::count(row.begin(), row.begin() + Canvas::kGuards, Canvas::kGuard), Canvas::kGuards);
  EXPECT_EQ(std::count(row.end() - Canvas::kGuards, row.end(), Canvas::kGuard), Canvas::kGuards);
}

}  // namespace
}  // namespace loopsift
