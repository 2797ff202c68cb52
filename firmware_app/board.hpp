// SPDX-License-Identifier: MIT
// What the board tells about itself through /sys. Thread: one, not a real-time one. Allocates.
#pragma once
#include <string>

namespace loopsift {

struct BoardStatus {
  float temperature_c;  ///< of the hottest thermal zone; NaN: it does not tell
  float clock_mhz;      ///< of the slowest processor; NaN: it does not tell
};

/// Reads below `sys`, the root of sysfs.
[[nodiscard]] BoardStatus read_board(const std::string& sys = "/sys");

}  // namespace loopsift
