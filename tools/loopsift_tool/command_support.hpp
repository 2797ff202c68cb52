// SPDX-License-Identifier: MIT
// What every command of the desk program shares: exit codes, how a failure is told, and the JSON file.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.hpp"

namespace loopsift::tool {

/// Exit codes of loopsift-tool, a subset of loopsift's.
enum ExitCode : int {
  kExitDone = 0,
  kExitOther = 1,            ///< writing failed, memory ran out, a solve did not converge
  kExitUsage = 2,            ///< a wrong command line, setting or input file
  kExitSourceNotOpened = 3,  ///< the sequence could not be opened
};

/// Prints "loopsift-tool: MESSAGE" to stderr and returns the exit code that fits the error: input that is
/// missing or malformed is kExitUsage, what fails in the middle is kExitOther.
[[nodiscard]] int fail(const Error& error);
/// The same for a sequence that could not be opened: kExitSourceNotOpened, or kExitUsage for a URI that is
/// none.
[[nodiscard]] int fail_to_open_source(const Error& error);

/// Writes `json`, indented, to the file that --json named; an empty path writes nothing.
[[nodiscard]] Status write_json(const std::string& path, const nlohmann::ordered_json& json);

}  // namespace loopsift::tool
