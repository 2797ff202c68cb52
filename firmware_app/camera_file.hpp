// SPDX-License-Identifier: MIT
// camera.toml: what is known of one sensor (docs/calibration.md; ready ones in config/cameras). In: the file
// that camera.file names. Out: a CameraCalibration, or every problem at once. Set-up only; allocates.
#pragma once
#include <string>
#include <vector>

#include "core/geometry/camera_calibration.hpp"

namespace loopsift {

/// Sets `calibration` from the file. Appends a line to `problems` for each unknown key, wrong type and value
/// out of range (with FILE:LINE), and for what does not fit together: half-given intrinsics, extrinsics
/// without a colour camera, a correction that does not grow with depth. False when anything was appended.
/// A factor file that is no absolute path lies beside the camera file.
bool read_camera_file(const std::string& path, CameraCalibration* calibration,
                      std::vector<std::string>* problems);

}  // namespace loopsift
