// SPDX-License-Identifier: MIT
// The one interface behind which cameras, recordings and rendered scenes stand.
// In: a device or files. Out: RawFrames decoded into the caller's buffers. Thread: one reader (the capture
// thread). May allocate in open; read does not allocate once the first frame has been read, unless a decoder
// library does.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/camera.hpp"
#include "core/geometry/camera_calibration.hpp"
#include "core/geometry/raw_frame.hpp"
#include "drivers/lcm/lcm_in_options.hpp"
#include "drivers/libcamera/libcamera_options.hpp"
#include "drivers/openni2/openni2_options.hpp"
#include "drivers/v4l2/v4l2_options.hpp"

namespace loopsift {

/// Known once the source is open.
struct SourceInfo {
  std::string description;      ///< for a person: "7scenes DIR, 1000 frames"
  PinholeCamera camera;         ///< of the depth image
  double depth_unit_m = 0.001;  ///< metres per raw unit
  int color_width = 0;          ///< 0 when the source never has colour
  int color_height = 0;
  double nominal_rate_hz = 30.0;  ///< used where the recording has no time stamps
  std::int64_t frame_count = -1;  ///< −1 where unknown (live)
  bool live = false;              ///< frames arrive by themselves; a recording waits for its reader
};

enum class ReadStatus {
  kFrame,    ///< a frame was written
  kBad,      ///< this frame could not be used (message() says why and names it); go on reading
  kTimeout,  ///< nothing within the time limit; the source may still be alive
  kEnd,      ///< a recording is over
  kLost,     ///< a device is gone (message() says what is known)
};

/// Settings that override what a source says about itself. Zero or empty: not overridden.
struct SourceOptions {
  // Not an aggregate: g++ 12 takes the strings of a temporary `{}` for uninitialised.
  SourceOptions() {}              // NOLINT(modernize-use-equals-default)
  PinholeCamera camera;           ///< any member that is not 0 replaces the source's own
  double depth_scale = 0;         ///< raw units per metre
  CameraCalibration calibration;  ///< of the sensor; applied to the images of any source
  std::string color_source;       ///< URI of another source that gives the colour; empty: the source's own
  bool want_color = true;
  double rate_hz = 0;      ///< nominal frame rate of recordings without time stamps
  std::uint64_t seed = 1;  ///< noise of synthetic sources
  OpenNi2Options openni2;
  V4l2Options v4l2;
  LibcameraOptions libcamera;
  LcmInOptions lcm_in;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  [[nodiscard]] virtual const SourceInfo& info() const = 0;
  /// The next frame in order of time, written into frame's buffers (whose capacities fit info()).
  /// timeout_ms bounds the wait of live sources; recordings ignore it.
  [[nodiscard]] virtual ReadStatus read(RawFrame& frame, int timeout_ms) = 0;
  /// Why the last read was kBad or kLost, or why its kFrame came without the colour that belongs to it; empty
  /// otherwise.
  [[nodiscard]] virtual const std::string& message() const = 0;
};

/// A source from a URI as the command line takes it: `replay:FORMAT:PATH` (tum, 7scenes, redwood, sun3d,
/// klg), `synth:SCENE`, `lcm:CHANNEL`, and where the build has them `openni2:`, `v4l2:/dev/videoN`,
/// `libcamera:N` (drivers/driver_table.cpp). Errors name the URI, the file or device and what to do.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_source(const std::string& uri,
                                                                 const SourceOptions& options);

}  // namespace loopsift
