// SPDX-License-Identifier: MIT
// record and play: LCM's own programs do this well; these commands call them with what fits loopsift.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

struct LogOptions {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string prefix, file;
  double speed = 1;
  bool all = false, print = false;
};

/// Becomes the program, so that an interrupt reaches it; returns only when that is not possible.
int become(const std::vector<std::string>& command, bool print) {
  if (print) {
    std::string line;
    for (const std::string& word : command) line += (line.empty() ? "'" : " '") + word + "'";
    std::printf("%s\n", line.c_str());
    return kExitDone;
  }
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  const std::string hint = errno == ENOENT ? "; it comes with LCM (Debian: apt install liblcm-bin)" : "";
  return fail({ErrorCode::kIo, command[0] + " cannot be started: " + std::strerror(errno) + hint});
}

int record(const LogOptions& options) {
  const std::string ours = "(" + options.prefix + ")(POSE|POSE_ODOM|LOOPSIFT_.*)";
  return become(
      {"lcm-logger", "--lcm-url=" + options.url, "--channel=" + (options.all ? ".*" : ours), options.file},
      options.print);
}

int play(const LogOptions& options) {
  return become(
      {"lcm-logplayer", "--lcm-url=" + options.url, "--speed=" + std::to_string(options.speed), options.file},
      options.print);
}

CLI::App* add_log_command(CLI::App& app, const char* name, const char* what, LogOptions* options) {
  CLI::App* command = app.add_subcommand(name, what);
  command->add_option("FILE", options->file, "the LCM log")->required();
  command->add_option("--url", options->url, "LCM provider, as lcm.url of the program")
      ->capture_default_str();
  command->add_flag("--print", options->print, "only print the command that would run");
  return command;
}

}  // namespace

void add_record_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<LogOptions>();
  CLI::App* command =
      add_log_command(app, "record", "Records what loopsift publishes, by lcm-logger", options.get());
  command->add_option("--prefix", options->prefix, "before each channel's name, as lcm.prefix");
  command->add_flag("--all", options->all, "every channel on the bus");
  command->callback([options, exit_code] { *exit_code = record(*options); });
}

void add_play_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<LogOptions>();
  CLI::App* command =
      add_log_command(app, "play", "Plays a recorded log back, by lcm-logplayer", options.get());
  command->add_option("--speed", options->speed, "times real time")->check(CLI::PositiveNumber);
  command->callback([options, exit_code] { *exit_code = play(*options); });
}

}  // namespace loopsift::tool
