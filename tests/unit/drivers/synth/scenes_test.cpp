// SPDX-License-Identifier: MIT
// What every built-in scene promises: a camera that moves like one, never inside furniture, that sees enough,
// and comes back where the scene says so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "drivers/synth/builtin_scenes.hpp"
#include "drivers/synth/synth_sequence.hpp"

namespace loopsift {
namespace {

struct Promise {
  const char* name;
  std::size_t least_frames, most_frames;
  double most_speed_mps, most_turn_dps;
};
void PrintTo(const Promise& promise, std::ostream* out) { *out << promise.name; }

class BuiltinScenes : public ::testing::TestWithParam<Promise> {
 protected:
  void SetUp() override {
    auto sequence = make_synth_sequence(std::string(GetParam().name) + "?width=320&height=240", {});
    ASSERT_TRUE(sequence.ok()) << sequence.error().message;
    sequence_ = std::move(*sequence);
  }
  const std::vector<StampedPose>& poses() const { return sequence_.trajectory.poses; }
  SynthSequence sequence_;
};

TEST_P(BuiltinScenes, CameraMovesWithinBounds) {
  const Promise& promise = GetParam();
  ASSERT_GE(poses().size(), promise.least_frames);
  ASSERT_LE(poses().size(), promise.most_frames);
  double fastest_turn = 0;
  Eigen::Vector3d last_velocity = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k < poses().size(); ++k) {
    const double dt = poses()[k].time_s - poses()[k - 1].time_s;
    ASSERT_NEAR(dt, 1.0 / 30.0, 1e-9);
    const Se3 motion = poses()[k - 1].T_world_camera.inverse() * poses()[k].T_world_camera;
    const Eigen::Vector3d velocity =
        (poses()[k].T_world_camera.translation() - poses()[k - 1].T_world_camera.translation()) / dt;
    const double turn = motion.angle() / dt * 57.29578;
    ASSERT_LE(velocity.norm(), promise.most_speed_mps) << "frame " << k;
    ASSERT_LE(turn, promise.most_turn_dps) << "frame " << k;
    if (k > 1) {
      ASSERT_LE((velocity - last_velocity).norm() / dt, 4.0) << "jerks at frame " << k;
    }
    last_velocity = velocity;
    fastest_turn = std::max(fastest_turn, turn);
  }
  if (std::string(promise.name) == "rotation") {
    EXPECT_GE(fastest_turn, 55.0);
  }
}

TEST_P(BuiltinScenes, CameraSeesEnoughAndIsNeverInsideAnything) {
  const auto renderer = SequenceRenderer::create(sequence_);
  ASSERT_TRUE(renderer.ok());
  RenderedFrame exact;
  std::vector<std::uint16_t> depth(320 * 240);
  for (std::size_t k = 0; k < poses().size(); k += 40) {
    (*renderer)->render(k, &exact, {depth.data(), 320, 240}, {});
    const auto holes = static_cast<double>(std::count(depth.begin(), depth.end(), 0));
    EXPECT_LT(holes / static_cast<double>(depth.size()), 0.4) << "frame " << k;
    EXPECT_GT(*std::min_element(exact.depth.begin(), exact.depth.end()), 0.3F) << "frame " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, BuiltinScenes,
    ::testing::Values(Promise{"room", 900, 1200, 0.65, 50.0}, Promise{"rooms", 1300, 1700, 0.75, 55.0},
                      Promise{"lookalike", 1000, 1300, 0.60, 50.0}, Promise{"corridor", 500, 700, 0.60, 50.0},
                      Promise{"notexture", 500, 700, 0.65, 50.0}, Promise{"rotation", 500, 700, 0.60, 66.0}),
    [](const auto& test) { return std::string(test.param.name); });

/// Whether `later` looks nearly where one of the first `count` poses looked.
bool comes_back(const Trajectory& trajectory, std::size_t later, std::size_t count) {
  const Se3& T = trajectory.poses[later].T_world_camera;
  return std::any_of(trajectory.poses.begin(), trajectory.poses.begin() + static_cast<std::ptrdiff_t>(count),
                     [&](const StampedPose& pose) {
                       const Se3 between = pose.T_world_camera.inverse() * T;
                       return between.translation().norm() < 0.45 && between.angle() < 0.35;
                     });
}

TEST(Revisits, SecondRoundOfTheRoomMeetsTheFirst) {
  const auto room = make_synth_sequence("room", {});
  ASSERT_TRUE(room.ok());
  const std::size_t count = room->trajectory.poses.size();
  for (std::size_t k = count * 11 / 20; k < count; k += 20)
    EXPECT_TRUE(comes_back(room->trajectory, k, count / 2)) << "frame " << k;
}

TEST(Revisits, RoomsAndLookalikeEndWhereTheyBegan) {
  for (const char* name : {"rooms", "lookalike"}) {
    const auto sequence = make_synth_sequence(name, {});
    ASSERT_TRUE(sequence.ok());
    const std::size_t count = sequence->trajectory.poses.size();
    EXPECT_TRUE(comes_back(sequence->trajectory, count - 1, count / 4)) << name;
    EXPECT_FALSE(comes_back(sequence->trajectory, count / 2, count / 4)) << name;
  }
}

TEST(Lookalike, TwoAlcovesCannotBeToldApartByGeometryNorColor) {
  const auto sequence = make_synth_sequence("lookalike?width=160&height=120&noise=0", {});
  ASSERT_TRUE(sequence.ok());
  const auto renderer = Renderer::create(sequence->scene);
  ASSERT_TRUE(renderer.ok());
  Eigen::Matrix3d R;  // looking along +y, level
  R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  RenderedFrame first, third;
  (*renderer)->render(sequence->settings.camera, Se3(R, {1.3, -0.3, 1.4}), true, &first);
  (*renderer)->render(sequence->settings.camera, Se3(R, {1.3 + 2 * 2.3, -0.3, 1.4}), true, &third);
  int differing = 0;
  for (int v = 0; v < 120; ++v)
    for (int u = 60; u < 100; ++u) {
      const auto i = static_cast<std::size_t>(v * 160 + u);
      differing += std::abs(first.depth[i] - third.depth[i]) > 0.001F ||
                   std::abs(int{first.color[i].g} - int{third.color[i].g}) > 3;
    }
  EXPECT_LT(differing, 120 * 40 / 50);
}

TEST(NoTexture, EveryMaterialIsTheSameGrey) {
  const auto scene = make_builtin_scene("notexture");
  ASSERT_TRUE(scene.ok());
  for (const Material& material : scene->scene.materials) {
    EXPECT_EQ(material.pattern, Pattern::kPlain);
    EXPECT_EQ(material.base, scene->scene.materials.front().base);
  }
}

TEST(BuiltinScene, UnknownNameListsTheKnownOnes) {
  const auto scene = make_builtin_scene("kitchen");
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.error().code, ErrorCode::kUsage);
  for (const char* name : {"kitchen", "corridor", "lookalike", "notexture", "room", "rooms", "rotation"})
    EXPECT_THAT(scene.error().message, ::testing::HasSubstr(name));
}

}  // namespace
}  // namespace loopsift
