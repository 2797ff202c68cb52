// SPDX-License-Identifier: MIT
#include "firmware_app/board.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace loopsift {
namespace {

namespace fs = std::filesystem;

// The number in each FOLDER/PREFIX*/FILE, put together by `choose`.
template <class Choose>
float number_of(const std::string& folder, const std::string& prefix, const std::string& file,
                Choose choose) {
  float chosen = std::nanf("");
  std::error_code no_such_folder;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, no_such_folder)) {
    if (entry.path().filename().string().rfind(prefix, 0) != 0) continue;
    std::ifstream in(entry.path() / file);
    float value = 0;
    if (in >> value) chosen = std::isnan(chosen) ? value : choose(chosen, value);
  }
  return chosen;
}

}  // namespace

BoardStatus read_board(const std::string& sys) {
  const auto highest = [](float a, float b) { return std::max(a, b); };
  const auto lowest = [](float a, float b) { return std::min(a, b); };
  BoardStatus board{};
  board.temperature_c = number_of(sys + "/class/thermal", "thermal_zone", "temp", highest) / 1000.0F;  // m°C
  board.clock_mhz =
      number_of(sys + "/devices/system/cpu", "cpu", "cpufreq/scaling_cur_freq", lowest) / 1000.0F;  // kHz
  return board;
}

}  // namespace loopsift
