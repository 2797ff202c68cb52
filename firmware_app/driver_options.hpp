// SPDX-License-Identifier: MIT
// The keys of the drivers' options, a section each.
#pragma once
#include "drivers/frame_source.hpp"
#include "firmware_app/given_odometry.hpp"
#include "firmware_app/option_table.hpp"

namespace loopsift {

/// Binds the options of every driver, also of those that this build has not.
[[nodiscard]] OptionTable driver_sections(SourceOptions& options);

/// odometry.lcm.
[[nodiscard]] OptionSection lcm_odometry_section(LcmOdometryOptions& options);

}  // namespace loopsift
