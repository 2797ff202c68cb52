// SPDX-License-Identifier: MIT
// What every command of the desk program shares: exit codes, how a failure is told, and the JSON file.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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

/// One line of a result table and one key of its JSON. A null value prints as "-".
struct Figure {
  const char* label;
  const char* key;
  nlohmann::ordered_json value;
  const char* unit;
};

/// Prints the figures as a table and writes them as one object to the file that --json named (none when
/// empty). Returns the exit code.
[[nodiscard]] int show_figures(const std::vector<Figure>& figures, const std::string& json_path);

/// Makes a folder for results, and those above it, where they are not there yet.
[[nodiscard]] Status make_folder(const std::string& path);

/// Writes `json`, indented, to the file that --json named; an empty path writes nothing.
[[nodiscard]] Status write_json(const std::string& path, const nlohmann::ordered_json& json);

}  // namespace loopsift::tool
