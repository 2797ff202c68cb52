// SPDX-License-Identifier: MIT
// Where the map and a depth image disagree, as a picture. White: they agree. Red: the map is in front of what
// was measured; blue: behind it; full colour at 10 cm. Dark grey: measured but not predicted; black: not
// measured. Desk code: allocates.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/image.hpp"

namespace loopsift::tool {

/// The colour of one pixel; depths in metres, 0 for none.
[[nodiscard]] Rgb8 residual_color(double predicted_m, double measured_m);

/// Writes FOLDER/frame-NNNNNN.png. `inverse_depth` is the prediction (1/m, 0 for none), of the same size.
[[nodiscard]] Status write_residual_image(const std::string& folder, int frame,
                                          const ImageView<const float>& measured_m,
                                          const ImageView<const float>& inverse_depth);

}  // namespace loopsift::tool
