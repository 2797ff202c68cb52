// SPDX-License-Identifier: MIT
// What is asked of a device, and what comes of each way that it can say no.
#include <gmock/gmock.h>

#include <cerrno>

#include "tests/unit/drivers/v4l2/fake_camera.hpp"

namespace loopsift {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class V4l2Open : public test::FakeCamera {};

TEST_F(V4l2Open, TheDepthFormatIsTakenBeforeColour) {
  open();
  EXPECT_EQ(video_.format().pixelformat, V4L2_PIX_FMT_Y16);
  EXPECT_EQ(source_->info().camera.width, test::kWidth);
  EXPECT_EQ(source_->info().camera.fx, 10);
  EXPECT_EQ(source_->info().color_width, 0);
  EXPECT_TRUE(source_->info().live);
  EXPECT_EQ(source_->info().depth_unit_m, 0.001);
  EXPECT_THAT(source_->info().description,
              AllOf(HasSubstr("/dev/video0"), HasSubstr("Fake camera"), HasSubstr("Y16 8 x 4 at 30 Hz")));
  EXPECT_EQ(video_.buffers_with_device(), 4);
  EXPECT_TRUE(video_.streaming);
}

TEST_F(V4l2Open, AColourNodeHasNoDepthCamera) {
  open("/dev/video0?format=YUYV");
  EXPECT_EQ(source_->info().camera.width, 0);
  EXPECT_EQ(source_->info().color_width, test::kWidth);
  EXPECT_EQ(source_->info().color_height, test::kHeight);
}

TEST_F(V4l2Open, TheSizeComesFromTheCameraWhereNoneIsSet) {
  options_.v4l2.width = options_.v4l2.height = 0;
  open();
  EXPECT_EQ(video_.format().width, 8U);
  source_.reset();
  open("/dev/video0?format=YUYV");  // the depth camera's size says nothing about colour
  EXPECT_EQ(video_.format().width, 640U);
  EXPECT_EQ(video_.format().height, 480U);
}

TEST_F(V4l2Open, DepthNeedsIntrinsicsAndTakesAScale) {
  options_.camera = {};
  EXPECT_THAT(open_error().message, HasSubstr("camera.fx"));
  options_.camera = {0, 0, 10, 10, 4, 2};
  options_.depth_scale = 5000;
  open();
  EXPECT_DOUBLE_EQ(source_->info().depth_unit_m, 0.0002);
}

TEST_F(V4l2Open, ClosingGivesEverythingBack) {
  open();
  source_.reset();
  EXPECT_TRUE(video_.all_given_back());
  open();  // the same device again
  EXPECT_EQ(video_.stream_starts, 2);
}

TEST_F(V4l2Open, NodesThatCannotBeOpenedSayWhatToDo) {
  EXPECT_EQ(open_error("/dev/video9").code, ErrorCode::kNotFound);
  EXPECT_THAT(open_error("/dev/video9").message,
              AllOf(HasSubstr("v4l2:/dev/video9"), HasSubstr("plugged in")));
  video_.open_error = EACCES;
  EXPECT_EQ(open_error().code, ErrorCode::kIo);
  EXPECT_THAT(open_error().message, HasSubstr("group"));
  video_.open_error = EBUSY;
  EXPECT_THAT(open_error().message, HasSubstr("another program"));
  video_.open_error = ENODEV;
  EXPECT_EQ(open_error().code, ErrorCode::kNotFound);
}

TEST_F(V4l2Open, NodesThatAreNoCapturingCameraAreRefused) {
  video_.fail(VIDIOC_QUERYCAP, ENOTTY);
  EXPECT_THAT(open_error().message, HasSubstr("no V4L2 device"));
  video_.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_THAT(open_error().message, HasSubstr("captures no images"));
  video_.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE;
  EXPECT_THAT(open_error().message, HasSubstr("cannot map"));
}

TEST_F(V4l2Open, AFormatThatIsSilentlyChangedIsRefused) {
  const Error error = open_error("/dev/video0?format=Z16");
  EXPECT_EQ(error.code, ErrorCode::kUnsupported);
  EXPECT_THAT(error.message, AllOf(HasSubstr("asked for Z16"), HasSubstr("gives YUYV"), HasSubstr("Y16")));
}

TEST_F(V4l2Open, FormatsThatAreNotReadAreNamed) {
  EXPECT_THAT(open_error("/dev/video0?format=H264").message, AllOf(HasSubstr("'H264'"), HasSubstr("MJPG")));
  video_.formats = {V4L2_PIX_FMT_H264};
  EXPECT_THAT(open_error().message, AllOf(HasSubstr("no format that is read"), HasSubstr("H264")));
  video_.formats = {};
  EXPECT_THAT(open_error().message, HasSubstr("it has nothing"));
}

TEST_F(V4l2Open, ASizeThatIsSilentlyChangedIsRefused) {
  video_.adjust = [](v4l2_pix_format* format) { format->width = 320; };
  EXPECT_THAT(open_error().message, AllOf(HasSubstr("asked for 8 x 4"), HasSubstr("320 x 4")));
}

TEST_F(V4l2Open, ImagesThatDoNotFitTheirFormatAreRefused) {
  video_.adjust = [](v4l2_pix_format* format) { format->sizeimage = 63; };
  EXPECT_THAT(open_error().message, HasSubstr("63 bytes"));
  video_.adjust = [](v4l2_pix_format* format) { format->bytesperline = 15; };
  EXPECT_THAT(open_error().message, HasSubstr("rows of 15"));
  video_.adjust = [](v4l2_pix_format* format) { format->field = V4L2_FIELD_INTERLACED; };
  EXPECT_THAT(open_error().message, HasSubstr("interlaced"));
  video_.adjust = nullptr;
  video_.buffer_bytes = 60;
  EXPECT_THAT(open_error().message, HasSubstr("buffers of 60 bytes"));
}

TEST_F(V4l2Open, TheRateIsTheDevicesAnswer) {
  options_.v4l2.rate_hz = 15;
  open();
  EXPECT_DOUBLE_EQ(source_->info().nominal_rate_hz, 15);
  source_.reset();
  video_.interval = {1001, 30000};
  open();
  EXPECT_NEAR(source_->info().nominal_rate_hz, 29.97, 0.001);
  source_.reset();
  video_.rate_capability = 0;  // takes no rate and tells none: the wanted one stands
  open();
  EXPECT_DOUBLE_EQ(source_->info().nominal_rate_hz, 15);
  source_.reset();
  video_.fail(VIDIOC_G_PARM, ENOTTY);
  open();
  EXPECT_DOUBLE_EQ(source_->info().nominal_rate_hz, 15);
}

TEST_F(V4l2Open, FewerBuffersThanAskedForWillDoButNotOne) {
  video_.buffers_at_most = 2;
  open();
  EXPECT_EQ(video_.buffers_with_device(), 2);
  source_.reset();
  video_.buffers_at_most = 1;
  EXPECT_THAT(open_error().message, HasSubstr("only 1 buffers"));
}

TEST_F(V4l2Open, FailuresAtEachStepAreToldAndGiveEverythingBack) {
  const std::vector<std::pair<unsigned long, std::string>> steps = {
      {VIDIOC_G_FMT, "does not say its format"}, {VIDIOC_S_FMT, "refuses Y16 at 8 x 4"},
      {VIDIOC_REQBUFS, "gives no buffers"},      {VIDIOC_QUERYBUF, "does not describe its buffers"},
      {VIDIOC_QBUF, "cannot start streaming"},   {VIDIOC_STREAMON, "cannot start streaming"}};
  for (const auto& [request, what] : steps) {
    for (const int error_number : {EBUSY, ENODEV, EIO, EINVAL}) {
      video_.fail(request, error_number);
      const Error error = open_error();
      EXPECT_THAT(error.message, AllOf(HasSubstr("v4l2:/dev/video0"), HasSubstr(what)));
      EXPECT_EQ(error.message.find("another program") != std::string::npos, error_number == EBUSY);
      EXPECT_EQ(error.code == ErrorCode::kNotFound, error_number == ENODEV);
    }
  }
  video_.fail(VIDIOC_QUERYBUF, EIO, 3);  // two are mapped already
  EXPECT_THAT(open_error().message, HasSubstr("does not describe"));
  video_.map_error = ENOMEM;
  EXPECT_THAT(open_error().message, HasSubstr("cannot be mapped"));
}

TEST_F(V4l2Open, DevicesAreListedWithWhatIsReadOfThem) {
  video_.path = "/dev/video3";
  video_.formats = {V4L2_PIX_FMT_H264, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_Z16};
  const std::vector<DeviceInfo> devices = list_v4l2_devices(video_);
  ASSERT_EQ(devices.size(), 1U);
  EXPECT_EQ(devices[0].uri, "v4l2:/dev/video3");
  EXPECT_EQ(devices[0].name, "Fake camera");
  EXPECT_THAT(devices[0].formats, ElementsAre("MJPG (color) 640x480, 8x4", "Z16 (depth) 640x480, 8x4"));
  EXPECT_TRUE(video_.all_given_back());
  video_.capabilities = V4L2_CAP_META_CAPTURE;
  EXPECT_TRUE(list_v4l2_devices(video_).empty());
}

}  // namespace
}  // namespace loopsift
