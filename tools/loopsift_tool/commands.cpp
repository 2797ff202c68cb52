// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/commands.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "tools/loopsift_tool/command_support.hpp"

namespace loopsift::tool {
namespace {

int parse_and_run(int argc, const char* const* argv) {
  CLI::App app{"Measures, compares and makes sequences for loopsift. COMMAND --help says more.",
               "loopsift-tool"};
  app.set_version_flag("--version", "loopsift-tool " LOOPSIFT_VERSION);
  app.require_subcommand(1);
  int exit_code = kExitDone;
  add_sift_command(app, &exit_code);
  add_compare_command(app, &exit_code);
  add_convert_command(app, &exit_code);
  add_devices_command(app, &exit_code);
  add_dmp_command(app, &exit_code);
  add_eval_trajectory_command(app, &exit_code);
  add_eval_loops_command(app, &exit_code);
  add_eval_surface_command(app, &exit_code);
  add_report_command(app, &exit_code);
  add_synth_command(app, &exit_code);
  add_view_command(app, &exit_code);
  add_monitor_command(app, &exit_code);
  add_record_command(app, &exit_code);
  add_play_command(app, &exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitDone : kExitUsage;  // --help and --version come this way too
  }
  return exit_code;
}

}  // namespace

int run_tool(int argc, const char* const* argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const std::exception& error) {  // out of memory, or a library's complaint that nobody foresaw
    std::fprintf(stderr, "loopsift-tool: %s\n", error.what());
    return kExitOther;
  }
}

}  // namespace loopsift::tool
