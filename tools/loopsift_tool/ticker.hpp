// SPDX-License-Identifier: MIT
// Progress of a long computation for a person: one line with the time left, redrawn, on a terminal; nothing
// elsewhere. One thread.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

namespace loopsift::tool {

class Ticker {
 public:
  /// Writes to stderr if that is a terminal.
  explicit Ticker(std::string activity);
  ~Ticker();  ///< wipes the line
  Ticker(const Ticker&) = delete;
  Ticker& operator=(const Ticker&) = delete;
  /// Call as often as you like: draws at most ten times a second.
  void update(std::size_t done, std::size_t of);

 private:
  std::string activity_;
  bool is_terminal_;
  std::int64_t started_ns_;
  std::int64_t drawn_ns_ = 0;
};

}  // namespace loopsift::tool
