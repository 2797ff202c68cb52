// SPDX-License-Identifier: MIT
// A rendered sequence as a folder in TUM format. Allocates; renders with OpenMP, the bytes do not depend on
// the number of threads.
#pragma once
#include <cstdint>
#include <string>

#include "core/base/result.hpp"
#include "drivers/synth/synth_sequence.hpp"

namespace loopsift::tool {

struct SequenceWriterOptions {
  std::string folder;      ///< made when missing
  double drift_m = 0;      ///< > 0: odometry.txt ends this far off (odometry_drift.hpp)
  std::uint64_t seed = 1;  ///< of the drift
  bool images = true;      ///< false: only what needs no rendering
};

struct WrittenSequence {
  std::size_t frames = 0;
  double duration_s = 0;
  double length_m = 0;        ///< of the camera's way
  double valid_fraction = 0;  ///< of all pixels; 0 without images
};

/// Writes depth/NNNNNN.png (16 bit), rgb/NNNNNN.jpg when there is colour, depth.txt, rgb.txt,
/// associations.txt, camera.txt, groundtruth.txt (TUM, camera-to-world), mesh.ply and, with drift,
/// odometry.txt. Without images, camera.txt and what follows it. Errors name the file.
[[nodiscard]] Expected<WrittenSequence> write_sequence(const SynthSequence& sequence,
                                                       const SequenceWriterOptions& options);

}  // namespace loopsift::tool
