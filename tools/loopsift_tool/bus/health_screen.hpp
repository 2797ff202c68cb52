// SPDX-License-Identifier: MIT
// LOOPSIFT_HEALTH for a person.
#pragma once
#include <loopsift/health_t.hpp>
#include <string>

namespace loopsift::tool {

/// Several lines, each ended. age_s: since it came; past two seconds the program counts as silent, and the
/// first line says so.
[[nodiscard]] std::string health_screen(const health_t& health, double age_s);

}  // namespace loopsift::tool
