// SPDX-License-Identifier: MIT
// The only place that lists the drivers.
#include <algorithm>
#include <array>
#include <string_view>

#include "drivers/assemble_source.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/lcm/open_lcm.hpp"
#include "drivers/paired_source.hpp"
#include "drivers/replay/replay_source.hpp"
#include "drivers/synth/synth_source.hpp"
#ifdef LOOPSIFT_HAVE_LIBCAMERA
#include "drivers/libcamera/libcamera_source.hpp"
#endif
#ifdef LOOPSIFT_HAVE_OPENNI2
#include "drivers/openni2/openni2_source.hpp"
#endif
#ifdef LOOPSIFT_HAVE_V4L2
#include "drivers/v4l2/v4l2_source.hpp"
#endif

namespace loopsift {
namespace {

constexpr std::string_view kAvailable =
    "replay:FORMAT:PATH (tum, 7scenes, redwood, sun3d, klg), synth:SCENE, lcm:CHANNEL"
#ifdef LOOPSIFT_HAVE_OPENNI2
    ", openni2: (a camera), openni2:FILE.oni"
#endif
#ifdef LOOPSIFT_HAVE_V4L2
    ", v4l2:/dev/videoN"
#endif
#ifdef LOOPSIFT_HAVE_LIBCAMERA
    ", libcamera:N"
#endif
    ;
// Sources that the program may have, but this build has not.
constexpr std::array<std::string_view, 3> kLeftOut = {"openni2", "v4l2", "libcamera"};

// "head:tail" at the first colon; everything is head where there is none.
struct Parts {
  std::string head, tail;
};

Parts split(const std::string& text) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  return {text.substr(0, colon), colon < text.size() ? text.substr(colon + 1) : ""};
}

Expected<std::unique_ptr<FrameSource>> open_driver(const std::string& uri, const SourceOptions& options) {
  const Parts parts = split(uri);
  if (parts.head == "replay") {
    const Parts format = split(parts.tail);
    return open_replay(format.head, format.tail, options);
  }
  if (parts.head == "synth") return open_synth(parts.tail, options);
  if (parts.head == "lcm") return open_lcm(parts.tail, options);
#ifdef LOOPSIFT_HAVE_OPENNI2
  if (parts.head == "openni2") return open_openni2(parts.tail, options);
#endif
#ifdef LOOPSIFT_HAVE_V4L2
  if (parts.head == "v4l2") return open_v4l2(parts.tail, options);
#endif
#ifdef LOOPSIFT_HAVE_LIBCAMERA
  if (parts.head == "libcamera") return open_libcamera(parts.tail, options);
#endif
  if (std::find(kLeftOut.begin(), kLeftOut.end(), parts.head) != kLeftOut.end()) {
    return Error{ErrorCode::kUnsupported, "source '" + uri + "': this build has no " + parts.head +
                                              " driver; available are " + std::string(kAvailable)};
  }
  return Error{ErrorCode::kUsage, "source '" + uri + "': unknown kind '" + parts.head + "'; known are " +
                                      std::string(kAvailable)};
}

}  // namespace

Expected<std::unique_ptr<FrameSource>> open_source(const std::string& uri, const SourceOptions& options) {
  auto source = open_driver(uri, depth_options(options));
  if (source.ok() && !options.color_source.empty()) {
    auto color = open_driver(options.color_source, color_options(options));
    if (!color) return Error{color.error().code, "camera.color_source: " + color.error().message};
    source = PairedSource::create(std::move(*source), std::move(*color));
  }
  if (!source) return source.error();
  return calibrate(std::move(*source), options.calibration);
}

}  // namespace loopsift
