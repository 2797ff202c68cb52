// SPDX-License-Identifier: MIT
// A trajectory as a drifting odometry would have estimated it. Set-up code: allocates.
#pragma once
#include <cstdint>

#include "core/geometry/trajectory.hpp"

namespace loopsift {

/// The truth with every frame-to-frame motion disturbed: white tracking noise and a bias that changes slowly
/// over 5–25 s (sums of sines), in translation and rotation. The whole disturbance is scaled so that, both
/// starting at the same pose, the last position is end_error_m off. Deterministic in the seed. Needs two
/// poses or more; end_error_m ≥ 0.
[[nodiscard]] Trajectory drifting_odometry(const Trajectory& truth, double end_error_m, std::uint64_t seed);

}  // namespace loopsift
