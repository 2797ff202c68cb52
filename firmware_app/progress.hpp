// SPDX-License-Identifier: MIT
// What a person sees while a run goes on: a bar that is redrawn on a terminal, else a line every few seconds.
// Thread: one, not a real-time one. Allocates.
#pragma once
#include <cstdint>
#include <cstdio>
#include <string>

namespace loopsift {

struct ProgressState {
  const char* activity = "mapping";  ///< one word: mapping, lost, sifting, writing
  std::int64_t frames = 0;
  std::int64_t frame_count = -1;  ///< of the whole source; −1: not known
  std::int64_t fragments = 0;
  std::int64_t loops_proposed = 0;
  std::int64_t loops_accepted = 0;
  std::int64_t frames_dropped = 0;  ///< said from the first on
  std::int64_t frames_late = 0;     ///< past their deadline; said from the first on
};

/// One line without its end: "mapping [####------] 400/1000 frames, 31.2 frames/s, 8 fragments, loops 3 of
/// 17".
[[nodiscard]] std::string progress_line(const ProgressState& state, double frames_per_s, int bar_width);

class Progress {
 public:
  /// Writes to `stream`; asks isatty() whether it is a terminal.
  explicit Progress(std::FILE* stream);
  Progress(std::FILE* stream, bool is_terminal);

  /// Call as often as you like: prints at most ten times a second (terminal) or every five seconds.
  void update(const ProgressState& state, double now_s);
  /// The last state, and an end of line.
  void finish(const ProgressState& state, double now_s);

 private:
  void print(const ProgressState& state, double now_s);

  std::FILE* stream_;
  bool is_terminal_;
  double started_s_ = -1;
  double printed_s_ = 0;
  std::int64_t printed_frames_ = 0;
  double frames_per_s_ = 0;
};

}  // namespace loopsift
