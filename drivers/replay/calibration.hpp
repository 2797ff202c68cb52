// SPDX-License-Identifier: MIT
// What maps a recording's depth image to metres and rays, and where it comes from: the format's default, then
// `camera.txt` beside the recording, then the user's options, each replacing what it names. Set-up only:
// allocates.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/camera.hpp"
#include "drivers/frame_source.hpp"

namespace loopsift {

struct Calibration {
  PinholeCamera camera;       ///< members that nobody gave are 0
  double depth_scale = 1000;  ///< raw units per metre
};

/// `defaults`, overridden by FOLDER/camera.txt where there is one (`fx fy cx cy width height depth_scale`,
/// one `name value` per line) and by `options`. Errors name file and line: an unknown name, a value that is
/// no number or not positive, a depth scale of zero.
[[nodiscard]] Expected<Calibration> resolve_calibration(const Calibration& defaults,
                                                        const std::string& folder,
                                                        const SourceOptions& options);

/// Takes the image's size where the calibration has none, then checks that there are intrinsics and that they
/// are for images of this size. `image` is the file that the size was read from.
[[nodiscard]] Status fit_to_image(const std::string& folder, const std::string& image, int width, int height,
                                  PinholeCamera* camera);

}  // namespace loopsift
