// SPDX-License-Identifier: MIT
// Recordings (.oni): made with the driver from the test camera, read back; broken ones; a Kinect's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/unit/drivers/openni2/camera_fixture.hpp"

namespace loopsift {
namespace {

using test::CameraFixture;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48, kFrames = 12;

class OpenNi2Recording : public CameraFixture {
 protected:
  void SetUp() override {
    CameraFixture::SetUp();
    if (IsSkipped()) return;
    film(kFrames, kWidth, kHeight);
    options.camera.width = kWidth;
    options.camera.height = kHeight;
    options.openni2.record_path = camera.folder() / "recorded.oni";
    const auto source = open();
    ASSERT_TRUE(source.ok()) << source.error().message;
    recorded = read_frames(**source, kFrames - 4);
    path = options.openni2.record_path;
    options = SourceOptions();
  }

  std::vector<Seen> recorded;
  std::string path;
};

TEST_F(OpenNi2Recording, HoldsWhatTheDeviceGaveToTheBitAndItsTimes) {
  const auto source = open(path);
  ASSERT_TRUE(source.ok()) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_FALSE(info.live);
  ASSERT_GE(info.frame_count, static_cast<std::int64_t>(recorded.size()) - 1);
  EXPECT_NEAR(info.camera.fx, 32 / std::tan(0.5), 1e-3);
  const auto frames = read_frames(**source, static_cast<int>(info.frame_count));
  for (std::size_t k = 0; k < frames.size(); ++k) {
    // The recording counts anew; its times say which of the film's frames this is.
    const std::int64_t seed =
        (frames[k].timestamp_ns / 1000 - frames[0].timestamp_ns / 1000 + 16'000) * 30 / 1'000'000;
    EXPECT_EQ(frames[k].sequence, static_cast<std::int64_t>(k) + 1);
    EXPECT_EQ(seed, static_cast<std::int64_t>(k));
  }
  test::FrameBuffers buffers(info);
  EXPECT_EQ(read(**source, buffers.frame), ReadStatus::kEnd);
  EXPECT_EQ(read(**source, buffers.frame), ReadStatus::kEnd) << "the end stays";
}

TEST_F(OpenNi2Recording, IsTheSameEachTime) {
  std::vector<Seen> first;
  for (int pass = 0; pass < 3; ++pass) {
    const auto source = open(path);
    ASSERT_TRUE(source.ok()) << source.error().message;
    const auto frames = read_frames(**source, static_cast<int>((*source)->info().frame_count));
    if (pass == 0) first = frames;
    ASSERT_EQ(frames.size(), first.size());
    for (std::size_t k = 0; k < frames.size(); ++k) {
      EXPECT_EQ(frames[k].timestamp_ns, first[k].timestamp_ns);
      EXPECT_EQ(frames[k].depth, first[k].depth);
      EXPECT_FALSE(frames[k].color.empty());
    }
  }
}

TEST_F(OpenNi2Recording, IsNotWrittenOver) {
  const auto size = std::filesystem::file_size(path);
  options.camera.width = kWidth;
  options.camera.height = kHeight;
  options.openni2.record_path = path;
  {
    const auto source = open();
    ASSERT_TRUE(source.ok()) << source.error().message;
    (void)read_frames(**source, 2);
  }
  EXPECT_EQ(std::filesystem::file_size(path), size);
  EXPECT_TRUE(std::filesystem::exists(camera.folder() / "recorded-2.oni"));
}

TEST_F(OpenNi2Recording, CannotBeRecordedItself) {
  options.openni2.record_path = camera.folder() / "again.oni";
  const auto source = open(path);
  ASSERT_FALSE(source.ok());
  EXPECT_EQ(source.error().code, ErrorCode::kUsage);
  EXPECT_THAT(source.error().message, HasSubstr("record_path needs a camera"));
}

// The end of the file may be room that was never written to.
TEST_F(OpenNi2Recording, CutOffItIsRefusedUnlessAllImagesAreThere) {
  for (const double fraction : {0.001, 0.1, 0.3, 0.5, 0.9, 0.999}) {
    const std::string cut = camera.folder() / "cut.oni";
    std::filesystem::copy_file(path, cut, std::filesystem::copy_options::overwrite_existing);
    test::truncate_file(cut, fraction);
    const auto source = open(cut);
    if (source.ok()) {
      EXPECT_GT(fraction, 0.4);
      const auto count = static_cast<int>((*source)->info().frame_count);
      EXPECT_EQ(read_frames(**source, count).size(), static_cast<std::size_t>(count)) << fraction;
    } else {
      EXPECT_EQ(source.error().code, ErrorCode::kFormat);
      EXPECT_THAT(source.error().message, AllOf(HasSubstr("cut.oni"), HasSubstr("cut off"))) << fraction;
    }
  }
}

TEST_F(OpenNi2Recording, MissingAndForeignFilesAreNamed) {
  const auto missing = open(camera.folder() / "none.oni");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  for (const std::string content : {"", "NI", "RIFF and so on, a film of another kind"}) {
    const auto foreign = open(camera.folder().write("foreign.oni", content));
    ASSERT_FALSE(foreign.ok()) << content;
    EXPECT_EQ(foreign.error().code, ErrorCode::kFormat);
    EXPECT_THAT(foreign.error().message, AllOf(HasSubstr("foreign.oni"), HasSubstr("no OpenNI2 recording")));
  }
}

TEST_F(OpenNi2Recording, DamagedInTheMiddleItEndsAllTheSame) {
  std::string bytes;
  {
    std::ifstream file(path, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(file), {});
  }
  for (std::size_t k = bytes.size() / 4; k < bytes.size() * 3 / 4; k += 97) bytes[k] = static_cast<char>(k);
  const auto source = open(camera.folder().write("damaged.oni", bytes));
  if (!source.ok()) {
    EXPECT_THAT(source.error().message, HasSubstr("damaged.oni"));
    return;
  }
  test::FrameBuffers buffers((*source)->info());
  ReadStatus status = ReadStatus::kFrame;
  for (int k = 0; k < 2 * kFrames && (status == ReadStatus::kFrame || status == ReadStatus::kBad); ++k) {
    status = read(**source, buffers.frame);
  }
  EXPECT_TRUE(status == ReadStatus::kEnd || status == ReadStatus::kLost) << static_cast<int>(status);
}

TEST(KinectRecording, IsReadWhole) {
  const char* data = std::getenv("LOOPSIFT_DATA");
  if (data == nullptr) GTEST_SKIP() << "LOOPSIFT_DATA is not set";
  const SourceOptions plain;
  const auto source = open_openni2(std::string(data) + "/oni/boot.oni", plain);
  ASSERT_TRUE(source.ok()) << source.error().message;
  const SourceInfo& info = (*source)->info();
  EXPECT_EQ(info.frame_count, 22);
  EXPECT_NEAR(info.camera.fx, 575.8, 1);
  test::FrameBuffers buffers(info);
  int frames = 0, with_color = 0;
  std::int64_t last_ns = -1;
  ReadStatus status = ReadStatus::kTimeout;
  while ((status = (*source)->read(buffers.frame, 100)) != ReadStatus::kEnd) {
    if (status == ReadStatus::kTimeout) continue;
    ASSERT_EQ(status, ReadStatus::kFrame) << (*source)->message();
    EXPECT_GT(buffers.frame.timestamp_ns, last_ns);
    last_ns = buffers.frame.timestamp_ns;
    ++frames;
    with_color += buffers.frame.color.empty() ? 0 : 1;
  }
  EXPECT_EQ(frames, 22);
  EXPECT_EQ(with_color, 21) << "the first colour image came 35 ms after the first depth image";
}

}  // namespace
}  // namespace loopsift
