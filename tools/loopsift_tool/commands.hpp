// SPDX-License-Identifier: MIT
// The desk program's commands. Each lives in its own file NAME_command.cpp and adds itself to the command
// line; run_tool (commands.cpp) lists them.
#pragma once
#include <CLI/App.hpp>

namespace loopsift::tool {

/// Parses the command line, runs the command it names and returns the program's exit code (exit_code.hpp).
/// Writes results to stdout and complaints to stderr. No exception leaves it.
[[nodiscard]] int run_tool(int argc, const char* const* argv);

// Each adds one command; its callback writes the exit code, which is kExitDone before.
void add_compare_command(CLI::App& app, int* exit_code);
void add_convert_command(CLI::App& app, int* exit_code);
void add_devices_command(CLI::App& app, int* exit_code);
void add_dmp_command(CLI::App& app, int* exit_code);
void add_eval_loops_command(CLI::App& app, int* exit_code);
void add_eval_surface_command(CLI::App& app, int* exit_code);
void add_eval_trajectory_command(CLI::App& app, int* exit_code);
void add_report_command(CLI::App& app, int* exit_code);
void add_monitor_command(CLI::App& app, int* exit_code);
void add_play_command(CLI::App& app, int* exit_code);
void add_record_command(CLI::App& app, int* exit_code);
void add_sift_command(CLI::App& app, int* exit_code);
void add_synth_command(CLI::App& app, int* exit_code);
void add_view_command(CLI::App& app, int* exit_code);

}  // namespace loopsift::tool
