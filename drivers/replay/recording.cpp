// SPDX-License-Identifier: MIT
#include "drivers/replay/recording.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace loopsift {

std::vector<int> pair_nearest(const std::vector<std::int64_t>& depth, const std::vector<std::int64_t>& color,
                              std::int64_t limit) {
  std::vector<int> pairs(depth.size(), -1);
  std::size_t c = 0;
  for (std::size_t d = 0; d < depth.size() && !color.empty(); ++d) {
    const auto distance = [&](std::size_t k) { return std::abs(color[k] - depth[d]); };
    while (c + 1 < color.size() && distance(c + 1) <= distance(c)) ++c;
    if (distance(c) <= limit) pairs[d] = static_cast<int>(c);
  }
  return pairs;
}

Expected<std::vector<std::string>> list_folder(const std::string& folder) {
  std::error_code problem;
  std::filesystem::directory_iterator entries(folder, problem);
  if (problem) {
    const bool missing = problem == std::errc::no_such_file_or_directory;
    return Error{missing ? ErrorCode::kNotFound : ErrorCode::kIo,
                 folder + ": cannot be listed as a folder: " + problem.message()};
  }
  std::vector<std::string> names;
  for (const auto& entry : entries) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace loopsift
