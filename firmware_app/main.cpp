// SPDX-License-Identifier: MIT
// The onboard program: command line, signals, log, exit code. Everything else is in wiring.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "firmware_app/cli.hpp"
#include "firmware_app/failure.hpp"
#include "firmware_app/wiring.hpp"

namespace loopsift {
namespace {

RunControl control;

void request_stop(int /*signal*/) { control.stop = true; }

/// The first SIGINT or SIGTERM asks the run to end and write its results; the second ends the process at once
/// (the default action is back by then).
void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = request_stop;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

/// Messages go to the error stream, so that what is printed on request stays clean.
void set_up_log(LogLevel level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("loopsift"));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::set_level(spdlog::level::debug);
    case LogLevel::kInfo:
      return spdlog::set_level(spdlog::level::info);
    case LogLevel::kWarning:
      return spdlog::set_level(spdlog::level::warn);
    case LogLevel::kError:
      return spdlog::set_level(spdlog::level::err);
  }
}

int report(const std::optional<Failure>& failure) {
  if (!failure) return kExitDone;
  std::fprintf(stderr, "loopsift: %s\n", failure->error.message.c_str());
  return exit_code(*failure);
}

int print_budget(const Settings& settings) {
  MemoryBudget budget;
  const std::optional<Failure> failure = plan_memory(settings, &budget);
  if (!failure)  // a failure's message holds the table
    std::fputs(budget.to_text(static_cast<std::size_t>(settings.memory.cap_mib) << 20).c_str(), stdout);
  return report(failure);
}

int run_program(int argc, const char* const* argv) {
  const auto line = parse_command_line(argc, argv);
  if (!line.ok()) return report(Failure{Phase::kSettings, line.error()});
  const Settings& settings = line->settings;
  switch (line->action) {
    case CommandLine::Action::kPrintText:
      std::fputs(line->text.c_str(), stdout);
      return kExitDone;
    case CommandLine::Action::kPrintSettings:
      std::fputs(to_toml(settings).c_str(), stdout);
      return kExitDone;
    case CommandLine::Action::kPrintBudget:
      return print_budget(settings);
    case CommandLine::Action::kRun:
      break;
  }
  set_up_log(settings.run.log_level);
  install_signal_handlers();
  spdlog::debug("settings:\n{}", to_toml(settings));
  Progress progress(stderr);
  const RunEnd end = run(settings, control, &progress);
  const int code = report(end.failure);
  if (end.thread_left_behind) std::_Exit(code);
  return code;
}

}  // namespace
}  // namespace loopsift

int main(int argc, char** argv) {
  try {
    return loopsift::run_program(argc, argv);
  } catch (const std::exception& error) {  // out of memory, or a library's complaint that nobody foresaw
    std::fprintf(stderr, "loopsift: %s\n", error.what());
    return loopsift::kExitOther;
  }
}
