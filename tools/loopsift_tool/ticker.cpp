// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/ticker.hpp"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "core/base/steady_time.hpp"

namespace loopsift::tool {
namespace {
constexpr std::int64_t kPeriod_ns = 100'000'000;
}

Ticker::Ticker(std::string activity)
    : activity_(std::move(activity)), is_terminal_(isatty(STDERR_FILENO) != 0) {}

Ticker::~Ticker() {
  if (drawn_ns_ != 0) std::fputs("\r\033[K", stderr);
}

void Ticker::update(std::size_t done, std::size_t of) {
  if (!is_terminal_ || steady_now_ns() - drawn_ns_ < kPeriod_ns) return;
  drawn_ns_ = steady_now_ns();
  std::fprintf(stderr, "\r%s %zu of %zu\033[K", activity_.c_str(), done, of);
  std::fflush(stderr);
}

}  // namespace loopsift::tool
