// SPDX-License-Identifier: MIT
#include "core/fragment/fragment_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <vector>

#include "core/fragment/surfel_ply.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/core/fragment/fused_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::FusedScene;
using test::shifted;

TEST(FragmentStore, RefusesAndCountsWhenFullAndKeepsWhatItHas) {
  StoreOptions options = test::small_store();
  options.max_fragments = 2;
  FusedScene fused(AnalyticScene::room(), {}, options);
  std::vector<const Fragment*> closed;
  for (int f = 0; f < 4; ++f) {
    fused.add(shifted(0.1 * f, 0, 0));
    closed.push_back(fused.builder().close(&fused.store()));
  }
  ASSERT_NE(closed[0], nullptr);
  ASSERT_NE(closed[1], nullptr);
  EXPECT_EQ(closed[2], nullptr);
  EXPECT_EQ(closed[3], nullptr);
  EXPECT_EQ(fused.store().refused(), 2);
  ASSERT_EQ(fused.store().fragments().size(), 2U);
  EXPECT_EQ(&fused.store().fragments()[1], closed[1]);
  EXPECT_EQ(closed[1]->id, FragmentId{1});
  EXPECT_DOUBLE_EQ(closed[1]->T_odom_fragment.translation().x(), 0.1);
  EXPECT_EQ(fused.store().fragment_pool().used, 2U);
  EXPECT_TRUE(fused.builder().empty()) << "the builder goes on with a fresh fragment";
}

TEST(FragmentStore, EveryPoolIsALimit) {
  for (int which = 0; which < 4; ++which) {
    StoreOptions options = test::small_store();
    if (which == 0) options.max_surfels = 10;
    if (which == 1) options.max_frames = 2;
    if (which == 2) options.max_views = 1;
    if (which == 3) options.max_view_pixels = 100;
    FragmentOptions fragment;
    fragment.frames_per_fragment = 6;
    FusedScene fused(AnalyticScene::room(), fragment, options);
    for (int i = 0; i < 6; ++i) fused.add(Se3());
    EXPECT_EQ(fused.builder().close(&fused.store()), nullptr) << which;
    EXPECT_EQ(fused.store().refused(), 1) << which;
    EXPECT_EQ(fused.store().surfel_pool().used, 0U) << which;
  }
}

TEST(FragmentStore, SharesOutItsSecondHalf) {
  StoreOptions options = test::small_store();
  options.max_fragments = 8;
  options.max_surfels = 60000;
  FusedScene fused(AnalyticScene::room(), {}, options);
  FragmentStore& store = fused.store();
  std::vector<float> values(30000);
  std::vector<std::uint32_t> colours(values.size());
  std::vector<std::uint16_t> frames(values.size());
  const auto add = [&](std::size_t surfels) {
    Fragment fragment;
    for (Span<float>* list :
         {&fragment.surfels.x, &fragment.surfels.y, &fragment.surfels.z, &fragment.surfels.nx,
          &fragment.surfels.ny, &fragment.surfels.nz, &fragment.surfels.radius, &fragment.surfels.weight})
      *list = {values.data(), surfels};
    fragment.surfels.rgb = {colours.data(), surfels};
    fragment.surfels.first_frame = fragment.surfels.last_frame = {frames.data(), surfels};
    return store.add(fragment) != nullptr;
  };
  EXPECT_EQ(store.surfel_allowance(), 60000U);
  ASSERT_TRUE(add(29999));
  EXPECT_EQ(store.surfel_allowance(), 30001U) << "more than half are free: as many as it likes";
  ASSERT_TRUE(add(9001));
  for (int left = 6; left > 0; --left) {
    EXPECT_EQ(store.surfel_allowance(), 3500U) << left;
    ASSERT_TRUE(add(3500)) << left;
  }
  EXPECT_EQ(store.refused(), 0);
  EXPECT_EQ(store.surfel_pool().used, 60000U);
}

TEST(FragmentStore, NeverSharesOutTooLittleToTrackAgainst) {
  StoreOptions options = test::small_store();
  options.max_surfels = 10;
  FusedScene fused(AnalyticScene::room(), {}, options);
  EXPECT_EQ(fused.store().surfel_allowance(), FragmentStore::kLeastSurfels);
}

TEST(FragmentStore, CopiesEverythingThatAFragmentPointsTo) {
  FusedScene fused(AnalyticScene::room());
  std::vector<FragmentFrame> frames(2);
  frames[1].timestamp_ns = 77;
  std::vector<float> depth = {1, 2, 3, 0, 5, 6};  // rows of 2 in a wider buffer
  std::vector<ScoreView> views(1);
  views[0].depth_m = {depth.data(), 2, 2, 3};
  Fragment fragment;
  fragment.frames = {frames.data(), frames.size()};
  fragment.views = {views.data(), views.size()};
  const Fragment* stored = fused.store().add(fragment);
  frames[1].timestamp_ns = 0;
  depth.assign(6, 9.0F);
  ASSERT_NE(stored, nullptr);
  EXPECT_EQ(stored->frames[1].timestamp_ns, 77);
  EXPECT_EQ(stored->views[0].depth_m(1, 0), 2.0F);
  EXPECT_EQ(stored->views[0].depth_m(0, 1), 0.0F);
  EXPECT_EQ(stored->views[0].depth_m(1, 1), 5.0F);
}

TEST(FragmentStore, OptionErrorsNameTheKey) {
  StoreOptions options;
  EXPECT_TRUE(validate(options).ok());
  options.max_views = 0;
  EXPECT_THAT(validate(options).error().message, testing::HasSubstr("store.max_views"));
}

struct Vertex {
  float position[3], normal[3];
  unsigned char rgb[3];
  float radius, confidence;
};

std::vector<Vertex> read_ply(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  std::size_t count = 0;
  while (std::getline(file, line) && line != "end_header")
    if (line.rfind("element vertex ", 0) == 0) count = std::stoul(line.substr(15));
  std::vector<Vertex> vertices(count);
  for (Vertex& v : vertices) {
    file.read(reinterpret_cast<char*>(v.position), 12);
    file.read(reinterpret_cast<char*>(v.normal), 12);
    file.read(reinterpret_cast<char*>(v.rgb), 3);
    file.read(reinterpret_cast<char*>(&v.radius), 4);
    file.read(reinterpret_cast<char*>(&v.confidence), 4);
  }
  EXPECT_TRUE(file.good());
  EXPECT_EQ(file.peek(), std::ifstream::traits_type::eof()) << "bytes after the last vertex";
  return vertices;
}

TEST(SurfelPly, ComesBackAsWritten) {
  FusedScene fused(AnalyticScene::room());
  for (int f = 0; f < 2; ++f) {
    for (int i = 0; i < 3; ++i) fused.add(shifted(0.3 * f, 0, 0));
    ASSERT_NE(fused.builder().close(&fused.store()), nullptr);
  }
  const Span<const Fragment> fragments = fused.store().fragments();
  const std::vector<Se3> poses = {Se3(),
                                  Se3(so3_exp(Eigen::Vector3d(0, 0, M_PI_2)), Eigen::Vector3d(1, 2, 3))};
  const test::TemporaryFolder folder;
  const std::string path = folder / "map.ply";
  ASSERT_TRUE(write_surfel_ply(path, fragments, {poses.data(), poses.size()}).ok());
  const std::vector<Vertex> vertices = read_ply(path);
  const std::size_t first = fragments[0].surfels.size();
  ASSERT_EQ(vertices.size(), first + fragments[1].surfels.size());
  const SurfelSpan& s = fragments[1].surfels;
  for (std::size_t i = 0; i < s.size(); i += 97) {
    const Vertex& v = vertices[first + i];
    const Eigen::Vector3f p = Se3f(poses[1]) * Eigen::Vector3f(s.x[i], s.y[i], s.z[i]);
    ASSERT_LT((Eigen::Vector3f(v.position) - p).norm(), 1e-5F);
    ASSERT_NEAR(v.normal[1], s.nx[i], 1e-5F) << "turned by a quarter about z: x becomes y";
    ASSERT_EQ(v.rgb[0] << 16 | v.rgb[1] << 8 | v.rgb[2], static_cast<int>(s.rgb[i]));
    ASSERT_EQ(v.radius, s.radius[i]);
    ASSERT_EQ(v.confidence, s.weight[i]);
  }
}

TEST(SurfelPly, HeaderSaysWhereEachFragmentEnds) {
  FusedScene fused(AnalyticScene::room());
  for (int i = 0; i < 3; ++i) fused.add(Se3());
  ASSERT_NE(fused.builder().close(&fused.store()), nullptr);
  const Span<const Fragment> fragments = fused.store().fragments();
  const Se3 pose;
  const test::TemporaryFolder folder;
  const std::string path = folder / "map.ply";
  ASSERT_TRUE(write_surfel_ply(path, fragments, {&pose, 1}).ok());
  char expected[128];
  std::snprintf(expected, sizeof expected, "comment fragment 0 surfels %zu first_frame_s %.9f",
                fragments[0].surfels.size(), static_cast<double>(fragments[0].frames[0].timestamp_ns) * 1e-9);
  std::ifstream file(path, std::ios::binary);
  std::vector<std::string> header;
  for (std::string line; std::getline(file, line) && line != "end_header";) header.push_back(line);
  EXPECT_THAT(header, testing::Contains(expected));
}

TEST(SurfelPly, SaysWhatWentWrong) {
  FusedScene fused(AnalyticScene::room());
  for (int i = 0; i < 3; ++i) fused.add(Se3());
  ASSERT_NE(fused.builder().close(&fused.store()), nullptr);
  const Se3 pose;
  const Status missing = write_surfel_ply("/nonexistent/map.ply", fused.store().fragments(), {&pose, 1});
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, testing::HasSubstr("/nonexistent/map.ply"));
  const Status full = write_surfel_ply("/dev/full", fused.store().fragments(), {&pose, 1});
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().code, ErrorCode::kIo);
  EXPECT_FALSE(write_surfel_ply("/dev/null", fused.store().fragments(), {}).ok())
      << "no pose for the fragment";
}

}  // namespace
}  // namespace loopsift
