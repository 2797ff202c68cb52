// SPDX-License-Identifier: MIT
// Small text files (trajectories, lists, settings), read at once and walked line by line. Desk and set-up
// code: allocates. Numbers are read the same way in every locale.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"

namespace loopsift {

/// The lines of a file that are neither blank nor comments (first character '#'), split at white space.
class TextFile {
 public:
  /// Errors: kNotFound, kIo; the message names the file.
  [[nodiscard]] static Expected<TextFile> open(const std::string& path);

  /// Goes to the next line; false at the end.
  [[nodiscard]] bool next();
  /// The words of the current line; they point into this object.
  [[nodiscard]] const std::vector<std::string_view>& words() const { return words_; }
  /// "PATH:LINE" of the current line, for messages.
  [[nodiscard]] std::string where() const;
  /// kFormat, "PATH:LINE: what".
  [[nodiscard]] Error error(const std::string& what) const;

 private:
  std::string path_;
  std::string text_;
  std::size_t position_ = 0;
  int line_ = 0;
  std::vector<std::string_view> words_;
};

/// The whole word as a number; false when it is none, or (double) not finite.
[[nodiscard]] bool parse_number(std::string_view word, double* value);
[[nodiscard]] bool parse_number(std::string_view word, int* value);
/// Decimal seconds ("1305031102.175304") as nanoseconds without a detour through floating point; digits past
/// the ninth decimal are cut off.
[[nodiscard]] bool parse_seconds(std::string_view word, std::int64_t* nanoseconds);

}  // namespace loopsift
