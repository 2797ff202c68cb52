// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/frame_source.hpp"
#include "tests/support/sequence_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

using test::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;

Error error_of(const std::string& uri) {
  const SourceOptions options;
  const auto source = open_source(uri, options);
  return source.ok() ? Error{ErrorCode::kUsage, "opened"} : source.error();
}

TEST(OpenSource, AReplayUriOpensARecordingWhosePathHoldsAColon) {
  const TemporaryFolder folder;
  folder.write("a:b/camera.txt", "width 40\nheight 30\n");
  folder.write("a:b/depth.txt", "1.0 depth/0.png\n");
  test::write_depth(folder / "a:b/depth/0.png", test::make_depth(40, 30, 0));
  const auto source = open_source("replay:tum:" + (folder / "a:b"), SourceOptions());
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().frame_count, 1);
}

TEST(OpenSource, ADriverNamesItsDeviceOrIsLeftOutAndSaysWhatIsThere) {
  for (const std::string kind : {"openni2", "v4l2", "libcamera"}) {
    const Error error = error_of(kind + ":/no/such/device");
    const bool left_out = error.message.find("no " + kind + " driver") != std::string::npos;
    EXPECT_THAT(error.message, HasSubstr(left_out ? "replay:FORMAT:PATH" : "/no/such/device"));
    EXPECT_EQ(error.code == ErrorCode::kUnsupported, left_out) << error.message;
  }
}

TEST(OpenSource, UnknownKindsListTheKnownOnes) {
  for (const std::string uri : {"", "kinect:", "/some/folder", "replay"}) {
    EXPECT_EQ(error_of(uri).code, ErrorCode::kUsage) << uri;
  }
  EXPECT_THAT(error_of("kinect:0").message, AllOf(HasSubstr("'kinect'"), HasSubstr("synth:SCENE")));
  EXPECT_THAT(error_of("replay:bag:/x").message, HasSubstr("unknown format 'bag'"));
}

TEST(OpenSource, AnUnknownSceneIsRefused) {
  EXPECT_THAT(error_of("synth:no_such_scene").message, HasSubstr("no_such_scene"));
}

TEST(OpenSource, AMissingFolderIsNotFound) {
  const Error error = error_of("replay:7scenes:/no/such/folder");
  EXPECT_EQ(error.code, ErrorCode::kNotFound);
  EXPECT_THAT(error.message, HasSubstr("/no/such/folder"));
}

}  // namespace
}  // namespace loopsift
