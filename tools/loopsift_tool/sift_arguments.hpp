// SPDX-License-Identifier: MIT
// What `sift` and `compare` take, and how it becomes fragments and loops. Desk code: allocates.
#pragma once
#include <CLI/App.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/proposal/loop.hpp"
#include "tools/loopsift_tool/offline_map.hpp"

namespace loopsift::tool {

struct SiftArguments {
  std::string source, trajectory, loops, info, odometry_info, json;
  OfflineMapOptions map;
  std::size_t room_for_loops = 1;  ///< times the loops of the file, for those that are added later
};

/// Adds --source, --trajectory, --loops, --info, --odometry-info, --fragment-frames, --views, --view-width,
/// --map-width and --json.
void add_sift_arguments(CLI::App* command, SiftArguments* arguments);

/// A map with its loops.
struct SiftInput {
  std::unique_ptr<OfflineMap> map;
  std::vector<Loop> loops;
};

/// Reads everything: small files first, so that what is wrong with them is told before the recording is read.
/// False: the failure has been told and *exit_code says which.
[[nodiscard]] bool read_sift_input(const SiftArguments& arguments, SiftInput* input, int* exit_code);

}  // namespace loopsift::tool
