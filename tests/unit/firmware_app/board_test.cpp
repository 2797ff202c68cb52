// SPDX-License-Identifier: MIT
#include "firmware_app/board.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

void put(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path) << text;
}

TEST(Board, TellsTheHottestZoneAndTheSlowestProcessor) {
  const test::TemporaryFolder sys;
  put(sys / "class/thermal/thermal_zone0/temp", "41500\n");
  put(sys / "class/thermal/thermal_zone1/temp", "63250\n");
  put(sys / "class/thermal/cooling_device0/temp", "99000\n");
  put(sys / "devices/system/cpu/cpu0/cpufreq/scaling_cur_freq", "1800000\n");
  put(sys / "devices/system/cpu/cpu1/cpufreq/scaling_cur_freq", "600000\n");
  put(sys / "devices/system/cpu/cpufreq/boost", "1\n");
  const BoardStatus board = read_board(sys.path());
  EXPECT_FLOAT_EQ(board.temperature_c, 63.25F);
  EXPECT_FLOAT_EQ(board.clock_mhz, 600.0F);
}

TEST(Board, ThatTellsNothingIsNotKnown) {
  const test::TemporaryFolder sys;
  put(sys / "class/thermal/thermal_zone0/temp", "no number\n");
  const BoardStatus board = read_board(sys.path());
  EXPECT_TRUE(std::isnan(board.temperature_c));
  EXPECT_TRUE(std::isnan(board.clock_mhz));
}

}  // namespace
}  // namespace loopsift
