// SPDX-License-Identifier: MIT
#include "drivers/synth/synth_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "drivers/synth/synth_sequence.hpp"

namespace loopsift {
namespace {

using ::testing::HasSubstr;

/// A consumer's buffers.
struct Reader {
  explicit Reader(FrameSource& source)
      : depth(static_cast<std::size_t>(source.info().camera.width * source.info().camera.height)),
        color(static_cast<std::size_t>(source.info().color_width * source.info().color_height)) {
    frame.depth_buffer = depth;
    frame.color_buffer = color;
  }
  std::vector<std::uint16_t> depth;
  std::vector<Rgb8> color;
  RawFrame frame;
};

TEST(SynthSource, ReadsItsFramesInOrderAndEnds) {
  const auto source = open_synth("room?frames=4&width=80&height=60&rate=10", {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.frame_count, 4);
  EXPECT_EQ(info.camera.width, 80);
  EXPECT_FLOAT_EQ(info.camera.fx, 525.0F / 8.0F);
  EXPECT_EQ(info.depth_unit_m, 0.001);
  EXPECT_EQ(info.nominal_rate_hz, 10.0);
  EXPECT_FALSE(info.live);
  Reader reader(**source);
  for (int k = 0; k < 4; ++k) {
    ASSERT_EQ((*source)->read(reader.frame, 0), ReadStatus::kFrame);
    EXPECT_EQ(reader.frame.sequence, k);
    EXPECT_EQ(reader.frame.timestamp_ns, k * 100000000LL);
    EXPECT_EQ(reader.frame.depth.width, 80);
    EXPECT_EQ(reader.frame.color.height, 60);
  }
  EXPECT_EQ((*source)->read(reader.frame, 0), ReadStatus::kEnd);
  EXPECT_EQ((*source)->read(reader.frame, 0), ReadStatus::kEnd);
}

TEST(SynthSource, SameSeedSameBytes) {
  const auto bytes = [](const std::string& scene, std::uint64_t seed) {
    SourceOptions options;
    options.seed = seed;
    const auto source = open_synth(scene, options);
    EXPECT_TRUE(source.ok());
    Reader reader(**source);
    std::vector<unsigned char> all;
    while ((*source)->read(reader.frame, 0) == ReadStatus::kFrame) {
      const auto* d = reinterpret_cast<const unsigned char*>(reader.depth.data());
      const auto* c = reinterpret_cast<const unsigned char*>(reader.color.data());
      all.insert(all.end(), d, d + 2 * reader.depth.size());
      all.insert(all.end(), c, c + 3 * reader.color.size());
    }
    return all;
  };
  const std::string scene = "lookalike?frames=3&width=160&height=120";
  const auto first = bytes(scene, 1);
  EXPECT_EQ(first.size(), 3U * 160 * 120 * 5);
  EXPECT_EQ(first, bytes(scene, 1));
  EXPECT_NE(first, bytes(scene, 2));
  EXPECT_EQ(first, bytes(scene + "&seed=1", 2)) << "the scene's own key wins";
}

TEST(SynthSource, WithoutColor) {
  for (const bool by_key : {true, false}) {
    SourceOptions options;
    options.want_color = by_key;
    const auto source = open_synth(by_key ? "room?frames=1&color=0" : "room?frames=1", options);
    ASSERT_TRUE(source.ok());
    EXPECT_EQ((*source)->info().color_width, 0);
    Reader reader(**source);
    ASSERT_EQ((*source)->read(reader.frame, 0), ReadStatus::kFrame);
    EXPECT_TRUE(reader.frame.color.empty());
  }
}

TEST(SynthSource, OptionsOverrideCameraAndDepthScale) {
  SourceOptions options;
  options.camera = {160, 120, 140.0F, 0.0F, 0.0F, 61.0F};
  options.depth_scale = 5000;
  const auto source = open_synth("room", options);
  ASSERT_TRUE(source.ok()) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.camera.width, 160);
  EXPECT_FLOAT_EQ(info.camera.fx, 140.0F);
  EXPECT_FLOAT_EQ(info.camera.fy, 131.25F);  // the standard camera's, scaled
  EXPECT_FLOAT_EQ(info.camera.cy, 61.0F);
  EXPECT_DOUBLE_EQ(info.depth_unit_m, 0.0002);
}

TEST(SynthSource, WrongScenesAndKeysAreNamed) {
  const auto error = [](const std::string& scene) {
    const auto source = open_synth(scene, {});
    if (source.ok()) return std::string("no error");
    EXPECT_EQ(source.error().code, ErrorCode::kUsage);
    return source.error().message;
  };
  EXPECT_THAT(error("rom"), HasSubstr("'rom'"));
  EXPECT_THAT(error(""), HasSubstr("lookalike"));
  EXPECT_THAT(error("room?fps=3"), HasSubstr("'fps'"));
  EXPECT_THAT(error("room?fps=3"),
              HasSubstr("frames, laps, noise, distortion, seed, width, height, rate, color"));
  EXPECT_THAT(error("room?frames=0"), HasSubstr("frames=0"));
  EXPECT_THAT(error("room?frames=2.5"), HasSubstr("whole number"));
  EXPECT_THAT(error("room?frames=ten"), HasSubstr("frames=ten"));
  EXPECT_THAT(error("room?frames"), HasSubstr("'frames'"));
  EXPECT_THAT(error("room?noise=2"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(error("room?"), HasSubstr("no key ''"));
}

TEST(SynthSequence, FirstFramesAreTheSameAtAnyLength) {
  const auto all = make_synth_sequence("rooms", {}), some = make_synth_sequence("rooms?frames=50", {});
  ASSERT_TRUE(all.ok() && some.ok());
  ASSERT_EQ(some->trajectory.poses.size(), 50U);
  EXPECT_EQ(all->trajectory.poses[49].T_world_camera.matrix(),
            some->trajectory.poses[49].T_world_camera.matrix());
}

TEST(MeshSequence, MissingFilesAreNamed) {
  const auto settings = parse_synth_settings("mesh", {});
  ASSERT_TRUE(settings.ok());
  const auto sequence = make_mesh_sequence("nowhere/a.obj", "b.log", {0, 0, 0}, *settings);
  ASSERT_FALSE(sequence.ok());
  EXPECT_EQ(sequence.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(sequence.error().message, HasSubstr("nowhere/a.obj"));
}

TEST(MeshSequence, LivingRoomIsSeenAlongItsTrajectory) {
  const char* data = std::getenv("LOOPSIFT_DATA");
  if (data == nullptr) GTEST_SKIP() << "LOOPSIFT_DATA is not set";
  const std::string folder = std::string(data) + "/icl_livingroom";
  const auto settings = parse_synth_settings("mesh?noise=0&distortion=0&width=160&height=120&color=0", {});
  ASSERT_TRUE(settings.ok());
  const auto sequence =
      make_mesh_sequence(folder + "/living_room.obj", folder + "/m1.log", {-0.84, -0.01, -0.14}, *settings);
  ASSERT_TRUE(sequence.ok()) << sequence.error().message;
  ASSERT_EQ(sequence->trajectory.poses.size(), 2350U);
  const auto renderer = SequenceRenderer::create(*sequence);
  ASSERT_TRUE(renderer.ok());
  RenderedFrame scratch;
  std::vector<std::uint16_t> depth(160 * 120);
  double valid = 0, pixels = 0;
  for (std::size_t k = 0; k < 2350; k += 50) {
    (*renderer)->render(k, &scratch, {depth.data(), 160, 120}, {});
    valid += static_cast<double>(std::count_if(depth.begin(), depth.end(), [](auto d) { return d > 0; }));
    pixels += static_cast<double>(depth.size());
  }
  EXPECT_NEAR(valid / pixels, 0.80, 0.02);  // the mesh has holes
}

}  // namespace
}  // namespace loopsift
