// SPDX-License-Identifier: MIT
// In: the figures of a run. Out: run.json, whose key names are stable. Thread: after the run. Allocates.
#pragma once
#include <cstdint>
#include <string>

#include "core/base/result.hpp"
#include "core/pipeline/run_figures.hpp"

namespace loopsift {

/// The figures as JSON text. What was not measured is null.
[[nodiscard]] std::string run_report_json(const RunFigures& figures);

/// Writes run_report_json to a file; kIo names the path.
[[nodiscard]] Status write_run_report(const std::string& path, const RunFigures& figures);

/// Largest resident set of this process so far (getrusage).
[[nodiscard]] std::int64_t peak_rss_bytes();

}  // namespace loopsift
