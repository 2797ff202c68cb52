// SPDX-License-Identifier: MIT
// The stages' options as sections of the settings: one function per group of sections, one line per key.
// In: the options structs that the keys stand for; they must outlive the table. Thread: set-up only.
// Allocates.
//
// Left out are members that another key decides: depth range and noise (camera), capacities of the scorer and
// the proposer (store.max_fragments), see finalize() in settings.hpp.
#pragma once
#include "core/fragment/front_end.hpp"
#include "core/odometry/trajectory_odometry.hpp"
#include "core/pipeline/back_end.hpp"
#include "firmware_app/option_table.hpp"

namespace loopsift {

/// frame, odometry, odometry.file, depth_calibration, fragment, model.
[[nodiscard]] OptionTable front_end_sections(FrontEndOptions& options, TrajectoryOdometryOptions& file);
/// store.
[[nodiscard]] OptionSection store_section(StoreOptions& options);
/// proposal, proposal.icp, posegraph, posterior, sifter.
[[nodiscard]] OptionTable back_end_sections(BackEndOptions& options);

}  // namespace loopsift
