// SPDX-License-Identifier: MIT
#include "core/base/memory_budget.hpp"

#include <algorithm>
#include <cstdio>

namespace loopsift {
namespace {
constexpr double kMib = 1024.0 * 1024.0;
}

void MemoryBudget::add(const std::string& owner, std::size_t count, std::size_t bytes) {
  for (Row& row : rows) {
    if (row.owner != owner) continue;
    row.count += count;
    row.bytes += bytes;
    return;
  }
  rows.push_back({owner, count, bytes});
}

std::size_t MemoryBudget::total_bytes() const {
  std::size_t total = 0;
  for (const Row& row : rows) total += row.bytes;
  return total;
}

std::string MemoryBudget::to_text(std::size_t cap_bytes) const {
  std::vector<Row> sorted = rows;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Row& a, const Row& b) { return a.bytes > b.bytes; });
  std::string text = "owner                                        count          MiB\n";
  char line[128];
  for (const Row& row : sorted) {
    std::snprintf(line, sizeof line, "%-36s %13zu %12.2f\n", row.owner.c_str(), row.count,
                  static_cast<double>(row.bytes) / kMib);
    text += line;
  }
  std::snprintf(line, sizeof line, "%-36s %13s %12.2f of %.2f (memory.cap_mib)\n", "total", "",
                static_cast<double>(total_bytes()) / kMib, static_cast<double>(cap_bytes) / kMib);
  return text + line;
}

}  // namespace loopsift
