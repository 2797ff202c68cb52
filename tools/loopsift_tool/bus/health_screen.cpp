// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/bus/health_screen.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <iterator>

namespace loopsift::tool {
namespace {

constexpr double kSilent_s = 2;  // health comes every second
constexpr double kMib = 1 << 20;

__attribute__((format(printf, 2, 3))) void append(std::string* text, const char* format, ...) {
  char line[256];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  *text += line;
}

long as_long(std::int64_t value) { return static_cast<long>(value); }
double mebibytes(std::int64_t bytes) { return static_cast<double>(bytes) / kMib; }

template <class T, std::size_t N>
int used(const T (&/*array*/)[N], std::int32_t count) {
  return std::clamp<std::int32_t>(count, 0, static_cast<std::int32_t>(N));
}

const char* state_name(std::int8_t state) {
  constexpr const char* kNames[] = {"starting", "tracking", "lost", "no source", "finishing"};
  return state >= 0 && state < static_cast<int>(std::size(kNames)) ? kNames[state] : "?";
}

const char* lost_reason(std::int8_t reason) {
  constexpr const char* kNames[] = {"",
                                    "too little depth",
                                    "the map is out of sight",
                                    "too few points agree with the map",
                                    "too large a motion",
                                    "no pose from outside",
                                    "time stamps do not advance"};
  return reason >= 0 && reason < static_cast<int>(std::size(kNames)) ? kNames[reason] : "?";
}

void append_summary(const health_t& h, double age_s, std::string* text) {
  append(text, "loopsift: %s", state_name(h.state));
  if (h.state == health_t::LOST) append(text, " (%s)", lost_reason(h.lost_reason));
  if (h.paused != 0) *text += ", paused";
  if (h.anchored == 0) *text += ", NOT JOINED to the map since a loss";
  if (age_s > kSilent_s) append(text, " — SILENT for %.0f s", age_s);
  append(text, ", up %.0f s", h.uptime_s);
  if (std::isfinite(h.temperature_c)) append(text, ", %.0f °C", static_cast<double>(h.temperature_c));
  if (std::isfinite(h.clock_mhz)) append(text, ", %.0f MHz", static_cast<double>(h.clock_mhz));
  append(text, "\n\nframes     %ld in, %ld tracked, %ld lost, %ld dropped\n", as_long(h.frames_received),
         as_long(h.frames_tracked), as_long(h.frames_lost), as_long(h.frames_dropped));
  append(text, "map        %d fragments, %d wait for the back thread; graph %d, correction %d\n", h.fragments,
         h.back_backlog, h.graph_version, h.epoch);
  append(text, "loops      %d of %d accepted\n", h.loops_accepted, h.loops_proposed);
  append(text, "messages   %ld sent, %ld failed; commands %ld obeyed, %ld refused\n",
         as_long(h.messages_sent), as_long(h.messages_failed), as_long(h.commands_obeyed),
         as_long(h.commands_refused));
  append(text, "memory     %.1f MiB resident, %.1f budgeted", mebibytes(h.resident_bytes),
         mebibytes(h.budget_bytes));
  if (h.fence_peak_bytes >= 0)
    append(text, "; back thread's heap %.1f of %.1f MiB, %ld refusals", mebibytes(h.fence_peak_bytes),
           mebibytes(h.fence_limit_bytes), as_long(h.fence_refusals));
  *text += "\n";
}

void append_latency(const health_t& h, std::string* text) {
  append(text, "\n%-18s %10s %10s %10s %10s\n", "latency, ms", "p50", "p99", "max", "count");
  for (int k = 0; k < used(h.latency, h.n_latency); ++k) {
    const latency_t& l = h.latency[k];
    if (l.count == 0) continue;
    append(text, "%-18.18s %10.2f %10.2f %10.2f %10ld\n", l.stage.c_str(), static_cast<double>(l.p50_ms),
           static_cast<double>(l.p99_ms), static_cast<double>(l.max_ms), as_long(l.count));
  }
}

void append_threads(const health_t& h, std::string* text) {
  append(text, "\n%-18s %10s %10s %10s\n", "thread", "late", "heap calls", "scheduled");
  for (int k = 0; k < used(h.threads, h.n_threads); ++k) {
    const thread_t& t = h.threads[k];
    const std::string heap = t.heap_calls < 0 ? "-" : std::to_string(t.heap_calls);
    const char* scheduled = t.disabled != 0 ? "DISABLED" : t.realtime != 0 ? "real time" : "normal";
    append(text, "%-18.18s %10ld %10s %10s\n", t.name.c_str(), as_long(t.deadline_misses), heap.c_str(),
           scheduled);
  }
}

void append_pools(const health_t& h, std::string* text) {
  append(text, "\n%-28s %10s %10s %10s\n", "pool", "most used", "capacity", "refused");
  for (int k = 0; k < used(h.pools, h.n_pools); ++k) {
    const pool_t& p = h.pools[k];
    append(text, "%-28.28s %10ld %10ld %10ld%s\n", p.name.c_str(), as_long(p.high_water), as_long(p.capacity),
           as_long(p.refused), p.refused > 0 ? "  FULL" : "");
  }
}

}  // namespace

std::string health_screen(const health_t& health, double age_s) {
  std::string text;
  append_summary(health, age_s, &text);
  append_latency(health, &text);
  append_threads(health, &text);
  append_pools(health, &text);
  return text;
}

}  // namespace loopsift::tool
