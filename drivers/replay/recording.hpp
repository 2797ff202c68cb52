// SPDX-License-Identifier: MIT
// The formats that keep a sequence as a folder of images differ only in how the images are found and timed.
// Each is one function that lists a folder. Set-up only: allocates. Errors name the folder, file or line.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/replay/calibration.hpp"

namespace loopsift {

struct RecordedFrame {
  std::int64_t timestamp_ns = 0;  ///< of the depth image
  std::int64_t sequence = 0;      ///< frame number in the recording
  std::string depth_path;
  std::string color_path;  ///< empty: no colour belongs to this frame
};

/// A listed folder. Time stamps and sequence numbers strictly increase; there is at least one frame.
struct Recording {
  std::vector<RecordedFrame> frames;
  Calibration defaults;       ///< what the format says about the camera
  bool rotated_bits = false;  ///< sun3d: depth values are rotated left by three bits
};

struct ListOptions {
  double rate_hz = 30.0;  ///< for formats without time stamps; half a period is the limit for pairing by time
  bool want_color = true;  ///< false: colour images are not looked for
};

/// TUM RGB-D (Sturm et al. 2012): associations.txt (`t depth`, or `t depth t color` in either order), else
/// depth.txt and rgb.txt paired by nearest time.
[[nodiscard]] Expected<Recording> list_tum(const std::string& folder, const ListOptions& options);
/// 7-Scenes (Shotton et al. 2013): frame-NNNNNN.depth.png and frame-NNNNNN.color.{jpg,png}.
[[nodiscard]] Expected<Recording> list_7scenes(const std::string& folder, const ListOptions& options);
/// Redwood (Choi et al. 2015): depth/ and image/, color/ or rgb/, numbered files.
[[nodiscard]] Expected<Recording> list_redwood(const std::string& folder, const ListOptions& options);
/// SUN3D (Xiao et al. 2013): as redwood, NUMBER-MICROSECONDS in the names, intrinsics.txt, rotated depth
/// bits.
[[nodiscard]] Expected<Recording> list_sun3d(const std::string& folder, const ListOptions& options);

/// For each of `depth`, the index of the nearest of `color` at most `limit` away, or −1. Both increase.
[[nodiscard]] std::vector<int> pair_nearest(const std::vector<std::int64_t>& depth,
                                            const std::vector<std::int64_t>& color, std::int64_t limit);

/// The names in a folder, sorted.
[[nodiscard]] Expected<std::vector<std::string>> list_folder(const std::string& folder);

}  // namespace loopsift
