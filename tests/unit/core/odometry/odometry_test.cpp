// SPDX-License-Identifier: MIT
#include "core/odometry/odometry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "tests/unit/core/odometry/tracked_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::TrackedScene;

Vector6d twist(double tx, double ty, double tz, double rx, double ry, double rz) {
  Vector6d xi;
  xi << tx, ty, tz, rx, ry, rz;
  return xi;
}

TEST(Odometry, RecoversKnownMotions) {
  TrackedScene scene(AnalyticScene::room(), 2);
  const Se3 start = Se3::exp(twist(0.1, -0.2, 0.1, 0.05, 0.1, 0));
  for (const Vector6d& motion :
       {twist(0, 0, 0, 0, 0, 0), twist(0.05, 0, 0, 0, 0, 0), twist(0, -0.04, 0.05, 0, 0, 0),
        twist(0, 0, 0, 0.05, 0, 0), twist(0, 0, 0, 0, -0.05, 0.04),
        twist(-0.03, 0.02, -0.04, 0.03, 0.03, -0.03)}) {
    Odometry odometry((OdometryOptions()));
    EXPECT_EQ(odometry.start(scene.frame_at(start), start).status, TrackingStatus::kFirst);
    const ModelView model = scene.model_at(start);
    const Se3 truth = start * Se3::exp(motion);
    const TrackingResult result = odometry.track(scene.frame_at(truth), model);
    ASSERT_EQ(result.status, TrackingStatus::kTracked);
    const Vector6d error = (truth.inverse() * result.T_odom_camera).log();
    EXPECT_LT(error.head<3>().norm(), 0.003) << motion.transpose();
    EXPECT_LT(error.tail<3>().norm(), 0.002) << motion.transpose();
    EXPECT_LT(result.degeneracy, 0.1F);
    EXPECT_GT(result.inlier_fraction, 0.6F);
  }
}

TEST(Odometry, StartsFromAnotherPoseOnlyWhereItIsTheLikelier) {
  TrackedScene scene(AnalyticScene::room(), 2);
  const ModelView model = scene.model_at(Se3());
  const auto tracked_from = [&](const Se3& truth, const Se3* other) {
    Odometry odometry((OdometryOptions()));
    EXPECT_EQ(odometry.start(scene.frame_at(Se3()), Se3()).status, TrackingStatus::kFirst);
    return odometry.track(scene.frame_at(truth), model, nullptr, other);
  };
  const Se3 near = Se3::exp(twist(0.01, 0, 0, 0, 0.01, 0)), far = Se3::exp(twist(0, 0, 0, 0, 0.18, 0));
  const TrackingResult alone = tracked_from(near, nullptr), misled = tracked_from(near, &far);
  EXPECT_LT((alone.T_odom_camera.inverse() * misled.T_odom_camera).log().norm(), 1e-9);
  const TrackingResult helped = tracked_from(far, &far);
  ASSERT_EQ(helped.status, TrackingStatus::kTracked);
  EXPECT_LT((far.inverse() * helped.T_odom_camera).log().norm(), 0.005);
}

TEST(Odometry, PredictsConstantVelocityByTime) {
  TrackedScene scene(AnalyticScene::room(), 2);
  Odometry odometry((OdometryOptions()));
  const Frame first = scene.frame_at(Se3());
  EXPECT_EQ(odometry.start(first, Se3()).status, TrackingStatus::kFirst);
  EXPECT_LT(odometry.predict(first.timestamp_ns + 33333333).log().norm(), 1e-12) << "nothing known yet";
  const Vector6d motion = twist(0.02, 0, 0.01, 0, 0.01, 0);
  const ModelView model = scene.model_at(Se3());
  const Frame second = scene.frame_at(Se3::exp(motion));
  const TrackingResult tracked = odometry.track(second, model);
  // The frames are two periods apart (the model took one), so one period later half the motion is added.
  const Se3 predicted = odometry.predict(second.timestamp_ns + 33333333);
  const Vector6d step = (tracked.T_odom_camera.inverse() * predicted).log();
  EXPECT_LT((step - 0.5 * tracked.T_odom_camera.log()).norm(), 1e-6);
  EXPECT_LT(
      (odometry.predict(second.timestamp_ns + 5000000000).inverse() * tracked.T_odom_camera).log().norm(),
      1e-9)
      << "a velocity seconds old says nothing";
}

// With white noise and nothing correlated, eᵀ Λ e averages to 6.
TEST(Odometry, InformationIsHonestUnderWhiteNoise) {
  TrackedScene scene(AnalyticScene::room(), 2, 0.002, 0.002);
  OdometryOptions options;
  options.correlated_pixels = 1;
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 0.005);
  double sum = 0;
  const int trials = 40;
  const ModelView model = scene.model_at(Se3());
  for (int i = 0; i < trials; ++i) {
    Vector6d motion;
    for (int k = 0; k < 6; ++k) motion[k] = normal(random);
    Odometry odometry(options);
    const Se3 truth = Se3::exp(motion);
    (void)odometry.start(scene.frame_at(Se3()), Se3());
    const TrackingResult result = odometry.track(scene.frame_at(truth), model);
    ASSERT_EQ(result.status, TrackingStatus::kTracked);
    const Vector6d error = (result.T_odom_camera.inverse() * truth).log();
    sum += error.dot(result.information * error);
  }
  EXPECT_GT(sum / trials, 6.0 / 3);
  EXPECT_LT(sum / trials, 6.0 * 3);
}

// What is not known of the depths' error makes a motion less certain, and so does a view that changes more;
// neither moves the pose.
TEST(Odometry, AMotionIsAsCertainAsTheModelIsKnownAndTheViewStays) {
  TrackedScene scene(AnalyticScene::room(), 2, 0.002, 0.002);
  ModelView model = scene.model_at(Se3());
  const auto tracked = [&](double motion_m, float unknown) {
    model.disparity_unknown = unknown;
    Odometry odometry((OdometryOptions()));
    EXPECT_EQ(odometry.start(scene.frame_at(Se3()), Se3()).status, TrackingStatus::kFirst);
    return odometry.track(scene.frame_at(Se3::exp(twist(0, 0, motion_m, 0, 0, 0))), model);
  };
  const auto variance = [](const TrackingResult& result) { return result.information.inverse().trace(); };
  const TrackingResult known = tracked(0.03, 0.01F), unknown = tracked(0.03, 1.0F);
  EXPECT_GT(variance(unknown), 3.0 * variance(known));
  EXPECT_LT(variance(unknown), 10.0 * variance(known));
  EXPECT_LT((known.T_odom_camera.inverse() * unknown.T_odom_camera).log().norm(), 0.002);
  EXPECT_GT(variance(tracked(0.06, 1.0F)), 1.5 * variance(unknown));
  EXPECT_LT(variance(tracked(0, 1.0F)), 0.5 * variance(unknown));
  EXPECT_GT(variance(tracked(0, 1.0F)), 0.0);
}

TEST(Odometry, SaysThatASingleWallSlides) {
  TrackedScene scene(AnalyticScene::wall(), 2, 0.002, 0.002);
  Odometry odometry((OdometryOptions()));
  (void)odometry.start(scene.frame_at(Se3()), Se3());
  const ModelView model = scene.model_at(Se3());
  const TrackingResult result =
      odometry.track(scene.frame_at(Se3::exp(twist(0.03, 0, 0.02, 0, 0, 0))), model);
  ASSERT_EQ(result.status, TrackingStatus::kTracked);
  EXPECT_GT(result.degeneracy, 0.5F);
  // What the wall does say is found; where it says nothing the prediction stands.
  EXPECT_NEAR(result.T_odom_camera.translation().z(), 0.02, 0.003);
  EXPECT_LT(std::fabs(result.T_odom_camera.translation().y()), 0.01);
}

// A keyframe in memory of its own.
struct KeptFrame {
  KeptFrame(const TrackedScene& scene, const Frame& frame, const Se3& T) {
    Arena measuring;
    const Keyframe unused(scene.working_camera(), frame.level_count, measuring);
    arena = std::make_unique<Arena>(measuring.used_bytes());
    keyframe = std::make_unique<Keyframe>(scene.working_camera(), frame.level_count, *arena);
    keyframe->keep(frame, T);
  }
  std::unique_ptr<Arena> arena;
  std::unique_ptr<Keyframe> keyframe;
};

// Where the wall alone slides, its texture holds; also when the exposure changes.
TEST(Odometry, ATextureHoldsASingleWall) {
  TrackedScene scene(AnalyticScene::wall(), 2, 0.002, 0.002);
  const Vector6d motion = twist(0.03, -0.02, 0.02, 0.01, 0, 0.02);
  for (const double gain : {1.0, 1.3}) {
    Odometry odometry((OdometryOptions()));
    const KeptFrame kept(scene, scene.color_frame_at(Se3()), Se3());
    (void)odometry.start(scene.frame_at(Se3()), Se3());
    const ModelView model = scene.model_at(Se3());
    const Frame& frame = scene.color_frame_at(Se3::exp(motion), gain);
    const TrackingResult result = odometry.track(frame, model, kept.keyframe.get());
    ASSERT_EQ(result.status, TrackingStatus::kTracked);
    EXPECT_LT(result.degeneracy, 0.5F);
    EXPECT_GT(result.keyframe_overlap, 0.8F);
    EXPECT_LT((result.T_odom_camera.log() - motion).norm(), 0.015) << "gain " << gain;
  }
}

TEST(Odometry, LosesItselfWithAReasonAndKeepsItsPose) {
  TrackedScene scene(AnalyticScene::room(), 2);
  const Se3 start = Se3::exp(twist(0.1, 0, 0, 0, 0, 0));
  Odometry odometry((OdometryOptions()));
  EXPECT_EQ(odometry.start(scene.black_frame(), start).reason, LostReason::kNoDepth);
  (void)odometry.start(scene.frame_at(start), start);
  const ModelView model = scene.model_at(start);
  const TrackingResult covered = odometry.track(scene.black_frame(), model);
  EXPECT_EQ(covered.status, TrackingStatus::kLost);
  EXPECT_EQ(covered.reason, LostReason::kNoDepth);
  const Se3 far_away = start * Se3::exp(twist(0, 0, 0, 0, M_PI, 0));
  ModelView elsewhere = model;
  elsewhere.T_odom_view = far_away;
  const TrackingResult unseen = odometry.track(scene.frame_at(start), elsewhere);
  EXPECT_EQ(unseen.status, TrackingStatus::kLost);
  EXPECT_EQ(unseen.reason, LostReason::kNoModel);
  EXPECT_EQ(unseen.information.norm(), 0.0);
  EXPECT_LT((odometry.T_odom_camera().inverse() * start).log().norm(), 1e-12);
}

TEST(Odometry, RefusesALargeJump) {
  TrackedScene scene(AnalyticScene::room(), 2);
  OdometryOptions options;
  options.max_step_m = 0.02F;
  Odometry odometry(options);
  (void)odometry.start(scene.frame_at(Se3()), Se3());
  const ModelView model = scene.model_at(Se3());
  const TrackingResult result = odometry.track(scene.frame_at(Se3::exp(twist(0.05, 0, 0, 0, 0, 0))), model);
  EXPECT_EQ(result.reason, LostReason::kLargeMotion);
}

TEST(OdometryOptions, ErrorsNameTheOption) {
  EXPECT_TRUE(validate(OdometryOptions()).ok());
  OdometryOptions options;
  options.correlated_pixels = 0;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("odometry.correlated_pixels"));
  options = {};
  options.prior_sigma_m = std::nanf("");
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("odometry.prior_sigma_m"));
}

}  // namespace
}  // namespace loopsift
