// SPDX-License-Identifier: MIT
#include "tests/support/openni2_plugin/camera_stream.hpp"

#include <cmath>
#include <cstring>

namespace loopsift::test {
namespace {

constexpr int kMaxDepth = 10000;  // as a Kinect's

int bytes_per_pixel(OniPixelFormat format) { return format == ONI_PIXEL_FORMAT_RGB888 ? 3 : 2; }

/// Answers a property, or says that the caller's buffer does not fit.
template <class T>
OniStatus answer(const T& value, void* data, int* size) {
  if (*size != static_cast<int>(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof(T));
  return ONI_STATUS_OK;
}

bool equal(const OniVideoMode& a, const OniVideoMode& b) {
  return a.pixelFormat == b.pixelFormat && a.resolutionX == b.resolutionX && a.resolutionY == b.resolutionY &&
         a.fps == b.fps;
}

}  // namespace

CameraStream::CameraStream(OniSensorType sensor, const std::vector<OniVideoMode>& modes,
                           float horizontal_fov_rad, bool mirrored)
    : sensor_(sensor),
      modes_(modes),
      mode_(modes.front()),
      horizontal_fov_rad_(horizontal_fov_rad),
      mirrored_(mirrored ? TRUE : FALSE) {}

OniStatus CameraStream::start() {
  running_ = true;
  return ONI_STATUS_OK;
}

OniBool CameraStream::isPropertySupported(int id) {
  switch (id) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
    case ONI_STREAM_PROPERTY_MIN_VALUE:
    case ONI_STREAM_PROPERTY_MAX_VALUE:
    case ONI_STREAM_PROPERTY_STRIDE:
    case ONI_STREAM_PROPERTY_MIRRORING:
    case ONI_STREAM_PROPERTY_CROPPING:
      return TRUE;
    default:
      return FALSE;
  }
}

OniStatus CameraStream::getProperty(int id, void* data, int* size) {
  const float ratio = static_cast<float>(mode_.resolutionY) / static_cast<float>(mode_.resolutionX);
  switch (id) {
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return answer(mode_, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return answer(horizontal_fov_rad_, data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return answer(2 * std::atan(ratio * std::tan(horizontal_fov_rad_ / 2)), data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return answer(0, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return answer(kMaxDepth, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return answer(mode_.resolutionX * bytes_per_pixel(mode_.pixelFormat), data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return answer(mirrored_, data, size);
    case ONI_STREAM_PROPERTY_CROPPING:
      return answer(OniCropping{}, data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus CameraStream::setProperty(int id, const void* data, int size) {
  OniVideoMode wanted;
  if (id != ONI_STREAM_PROPERTY_VIDEO_MODE || size != static_cast<int>(sizeof wanted)) {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  std::memcpy(&wanted, data, sizeof wanted);
  for (const OniVideoMode& mode : modes_) {
    if (!equal(wanted, mode)) continue;
    mode_ = mode;
    return ONI_STATUS_OK;
  }
  return ONI_STATUS_NOT_SUPPORTED;
}

void CameraStream::send(const void* pixels, std::uint64_t timestamp_us, int index) {
  if (!running_) return;
  OniFrame* frame = getServices().acquireFrame();
  if (frame == nullptr) return;
  const int stride = mode_.resolutionX * bytes_per_pixel(mode_.pixelFormat);
  frame->dataSize = stride * mode_.resolutionY;
  std::memcpy(frame->data, pixels, static_cast<std::size_t>(frame->dataSize));
  frame->sensorType = sensor_;
  frame->timestamp = timestamp_us;
  frame->frameIndex = index;
  frame->width = mode_.resolutionX;
  frame->height = mode_.resolutionY;
  frame->videoMode = mode_;
  frame->croppingEnabled = FALSE;
  frame->cropOriginX = frame->cropOriginY = 0;
  frame->stride = stride;
  raiseNewFrame(frame);
  getServices().releaseFrame(frame);
}

}  // namespace loopsift::test
