// SPDX-License-Identifier: MIT
// A program as a child process, for system tests. Throws std::runtime_error when it cannot be started.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace loopsift::test {

class Program {
 public:
  /// Starts it; both of its output streams go into one file.
  explicit Program(std::vector<std::string> command);
  ~Program();  ///< kills it if it still runs
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// What it has said so far.
  [[nodiscard]] std::string output() const;
  /// Until its output holds `text`; false when that does not happen within `limit_s` or it ends before.
  [[nodiscard]] bool wait_for(const std::string& text, double limit_s);
  void signal(int number) const;
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Waits for its end. The exit code; 128 + the signal that ended it.
  [[nodiscard]] int wait();

 private:
  [[nodiscard]] bool has_ended();
  TemporaryFolder folder_;
  pid_t pid_ = -1;
  int exit_code_ = -1;
};

struct Outcome {
  int exit_code = -1;
  std::string output;
};
/// Runs it to its end.
[[nodiscard]] Outcome run_program(const std::vector<std::string>& command);

/// The whole content; throws std::runtime_error when there is no such file.
[[nodiscard]] std::string read_file(const std::string& path);

}  // namespace loopsift::test
