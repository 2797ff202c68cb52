// SPDX-License-Identifier: MIT
// The command line of the onboard program. In: arguments. Out: what to do, with which settings. Set-up only;
// allocates; CLI11's exceptions end here.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "firmware_app/settings.hpp"

namespace loopsift {

struct CommandLine {
  enum class Action {
    kRun,
    kPrintBudget,
    kPrintSettings,  ///< --check-config: they are valid, or the parse had failed
    kPrintText,      ///< --help, --version: print `text`
  };
  Action action = Action::kRun;
  Settings settings;
  std::string text;
};

/// Settings are the defaults, then --config, then --set in order, then the options with a name of their own.
/// An Error of kUsage holds every problem of the settings, or the first of the command line itself.
[[nodiscard]] Expected<CommandLine> parse_command_line(int argc, const char* const* argv);

}  // namespace loopsift
