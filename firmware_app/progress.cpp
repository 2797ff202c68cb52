// SPDX-License-Identifier: MIT
#include "firmware_app/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace loopsift {
namespace {
constexpr double kTerminalPeriod_s = 0.1;
constexpr double kPlainPeriod_s = 5.0;
constexpr double kRateMemory_s = 2.0;  // the frame rate is averaged over about this long
constexpr int kBarWidth = 24;
}  // namespace

std::string progress_line(const ProgressState& state, double frames_per_s, int bar_width) {
  std::string line = state.activity;
  std::string frames = std::to_string(state.frames);
  if (state.frame_count > 0) {
    const auto filled =
        static_cast<std::size_t>(std::min(state.frames, state.frame_count) * bar_width / state.frame_count);
    line += " [" + std::string(filled, '#') + std::string(static_cast<std::size_t>(bar_width) - filled, '-') +
            "]";
    frames += "/" + std::to_string(state.frame_count);
  }
  char text[160];
  std::snprintf(text, sizeof text, " %s frames, %.1f frames/s, %lld fragments, loops %lld of %lld",
                frames.c_str(), frames_per_s, static_cast<long long>(state.fragments),
                static_cast<long long>(state.loops_accepted), static_cast<long long>(state.loops_proposed));
  line += text;
  if (state.frames_dropped > 0) line += ", " + std::to_string(state.frames_dropped) + " dropped";
  if (state.frames_late > 0) line += ", " + std::to_string(state.frames_late) + " late";
  return line;
}

Progress::Progress(std::FILE* stream) : Progress(stream, isatty(fileno(stream)) != 0) {}

Progress::Progress(std::FILE* stream, bool is_terminal) : stream_(stream), is_terminal_(is_terminal) {}

void Progress::update(const ProgressState& state, double now_s) {
  if (started_s_ < 0) {
    started_s_ = printed_s_ = now_s;
    printed_frames_ = state.frames;
    return;
  }
  if (now_s - printed_s_ >= (is_terminal_ ? kTerminalPeriod_s : kPlainPeriod_s)) print(state, now_s);
}

void Progress::finish(const ProgressState& state, double now_s) {
  if (started_s_ < 0) return;
  const double elapsed_s = now_s - started_s_;
  const double mean_rate = elapsed_s > 0 ? static_cast<double>(state.frames) / elapsed_s : 0.0;
  std::fprintf(stream_, "%s%s%s\n", is_terminal_ ? "\r" : "",
               progress_line(state, mean_rate, kBarWidth).c_str(), is_terminal_ ? "\033[K" : "");
  std::fflush(stream_);
}

void Progress::print(const ProgressState& state, double now_s) {
  const double elapsed_s = now_s - printed_s_;
  const double rate = static_cast<double>(state.frames - printed_frames_) / elapsed_s;
  const bool first = printed_s_ == started_s_;
  const double weight = first ? 1.0 : 1.0 - std::exp(-elapsed_s / kRateMemory_s);
  frames_per_s_ += weight * (rate - frames_per_s_);
  printed_s_ = now_s;
  printed_frames_ = state.frames;
  const std::string line = progress_line(state, frames_per_s_, kBarWidth);
  std::fprintf(stream_, is_terminal_ ? "\r%s\033[K" : "%s\n", line.c_str());
  std::fflush(stream_);
}

}  // namespace loopsift
