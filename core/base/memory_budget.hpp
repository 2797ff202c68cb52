// SPDX-License-Identifier: MIT
// What the process will use, in bytes, before the first frame: one row per store, summed.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace loopsift {

/// The rows that an Arena recorded. Set-up only: allocates.
struct MemoryBudget {
  struct Row {
    std::string owner;      ///< "part/what"
    std::size_t count = 0;  ///< elements
    std::size_t bytes = 0;  ///< with alignment
  };
  std::vector<Row> rows;  ///< carves of the same owner are one row

  void add(const std::string& owner, std::size_t count, std::size_t bytes);
  [[nodiscard]] std::size_t total_bytes() const;
  /// A table for a person, largest row first, with the total and the cap below it.
  [[nodiscard]] std::string to_text(std::size_t cap_bytes) const;
};

}  // namespace loopsift
