// SPDX-License-Identifier: MIT
// What a run leaves when it has ended: its figures and its results. Thread: main. Allocates.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "core/pipeline/run_figures.hpp"
#include "firmware_app/run_parts.hpp"

namespace loopsift {

/// Of all threads but the back one; into shared.figures.
void collect(const Parts& parts, Shared* shared);

/// Of the back thread's part: only once that thread has ended by itself.
void collect_back(const Parts& parts, RunFigures* figures);

/// The score of the odometry's map and of the best one: all views of both, seconds where the map is large.
void score(const BackEnd& back_end, RunFigures::Dmp* dmp);

/// The files of results.hpp into `out`. Without the back end, whose state is not known where its thread had
/// to be given up, the odometry's, moved by the last correction.
[[nodiscard]] Status write_files(const std::string& out, const Parts& parts, bool with_back_end);

}  // namespace loopsift
