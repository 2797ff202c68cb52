// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/ticker.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "core/base/steady_time.hpp"

namespace loopsift::tool {
namespace {
constexpr std::int64_t kPeriod_ns = 100'000'000;
constexpr std::int64_t kFirstGuess_ns = 2'000'000'000;  // sooner, the rate is not known well enough

// ", 1 min 20 s left"; nothing while that is not known.
std::string time_left(std::int64_t spent_ns, std::size_t done, std::size_t of) {
  if (spent_ns < kFirstGuess_ns || done == 0 || done >= of) return "";
  const double left_s =
      static_cast<double>(spent_ns) * 1e-9 * static_cast<double>(of - done) / static_cast<double>(done);
  const auto seconds = static_cast<long long>(left_s + 0.5);
  const std::string minutes = seconds >= 60 ? std::to_string(seconds / 60) + " min " : "";
  return ", " + minutes + std::to_string(seconds % 60) + " s left";
}
}  // namespace

Ticker::Ticker(std::string activity)
    : activity_(std::move(activity)),
      is_terminal_(isatty(STDERR_FILENO) != 0),
      started_ns_(steady_now_ns()) {}

Ticker::~Ticker() {
  if (drawn_ns_ != 0) std::fputs("\r\033[K", stderr);
}

void Ticker::update(std::size_t done, std::size_t of) {
  if (!is_terminal_ || steady_now_ns() - drawn_ns_ < kPeriod_ns) return;
  drawn_ns_ = steady_now_ns();
  std::fprintf(stderr, "\r%s %zu of %zu%s\033[K", activity_.c_str(), done, of,
               time_left(drawn_ns_ - started_ns_, done, of).c_str());
  std::fflush(stderr);
}

}  // namespace loopsift::tool
