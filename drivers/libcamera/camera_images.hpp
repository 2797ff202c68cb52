// SPDX-License-Identifier: MIT
// What a camera gives, one image at a time, as it lies in the camera's buffers; and the source that makes
// frames of it. The seam between libcamera (camera_session.hpp) and our own code: a test puts a script there.
// Thread: one reader. Never allocates once it is made.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "drivers/frame_source.hpp"
#include "drivers/libcamera/stream_format.hpp"

namespace loopsift {

/// An image that the camera has filled, the reader's until it is given back.
struct TakenImage {
  std::uint32_t request = 0;
  CameraImage image;
  std::uint32_t count = 0;        ///< the camera's frame number
  std::int64_t timestamp_ns = 0;  ///< monotonic clock; 0: none
  bool damaged = false;           ///< the camera says so, or the image is shorter than its format
};

class CameraImages {
 public:
  enum class Take { kImage, kTimeout, kLost };

  virtual ~CameraImages() = default;
  /// The next image, waited for at most timeout_ms; kLost when none can come any more.
  [[nodiscard]] virtual Take take(int timeout_ms, TakenImage* taken) = 0;
  /// Every image that was taken, before the next is.
  virtual void give_back(const TakenImage& taken) = 0;
};

/// Frames with colour alone, of `info`'s size, converted from images of the format `pixels`. `camera`: as
/// messages name it.
[[nodiscard]] std::unique_ptr<FrameSource> make_libcamera_source(std::string camera,
                                                                 std::unique_ptr<CameraImages> images,
                                                                 const StreamPixelFormat& pixels,
                                                                 SourceInfo info);

}  // namespace loopsift
