// SPDX-License-Identifier: MIT
// What follows `v4l2:` in a source's URI. Set-up only; allocates.
#pragma once
#include <string>

#include "core/base/result.hpp"
#include "drivers/v4l2/v4l2_options.hpp"

namespace loopsift {

struct V4l2Address {
  std::string path;
  V4l2Options options;
};

/// "PATH?key=value&key=value"; keys as in [v4l2], controls separated by commas. Errors name the URI and key.
[[nodiscard]] Expected<V4l2Address> parse_v4l2_uri(const std::string& text, const V4l2Options& defaults);

}  // namespace loopsift
