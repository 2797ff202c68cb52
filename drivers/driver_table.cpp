// SPDX-License-Identifier: MIT
// The only place that lists the drivers.
#include "drivers/driver_table.hpp"

#include "drivers/lcm/open_lcm.hpp"
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

// FORMAT:PATH
Expected<std::unique_ptr<FrameSource>> open_recording(const std::string& address,
                                                      const SourceOptions& options) {
  const std::size_t colon = address.find(':');
  if (colon == std::string::npos) return open_replay(address, "", options);
  return open_replay(address.substr(0, colon), address.substr(colon + 1), options);
}

constexpr Driver kDrivers[] = {
    {"replay", "replay:FORMAT:PATH (tum, 7scenes, redwood, sun3d, klg)", open_recording, nullptr},
    {"synth", "synth:SCENE", open_synth, nullptr},
    {"lcm", "lcm:CHANNEL", open_lcm, nullptr},
#ifdef LOOPSIFT_HAVE_OPENNI2
    {"openni2", "openni2: (a camera), openni2:FILE.oni", open_openni2, list_openni2_devices},
#else
    {"openni2", "", nullptr, nullptr},
#endif
#ifdef LOOPSIFT_HAVE_V4L2
    {"v4l2", "v4l2:/dev/videoN", open_v4l2, list_v4l2_devices},
#else
    {"v4l2", "", nullptr, nullptr},
#endif
#ifdef LOOPSIFT_HAVE_LIBCAMERA
    {"libcamera", "libcamera:N", open_libcamera, list_libcamera_devices},
#else
    {"libcamera", "", nullptr, nullptr},
#endif
};

}  // namespace

Span<const Driver> drivers() { return {kDrivers, std::size(kDrivers)}; }

}  // namespace loopsift
