// SPDX-License-Identifier: MIT
// Independent tasks on all cores, with progress and the time that is left.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace loopsift::tool {

/// Runs every task once, as many at a time as there are cores, in the order given; returns when all are done.
/// Tasks must not share what they write. What a task throws is thrown here, after the others have ended.
void run_tasks(const std::string& activity, const std::vector<std::function<void()>>& tasks);

}  // namespace loopsift::tool
