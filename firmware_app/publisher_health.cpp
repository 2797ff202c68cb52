// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_health.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace loopsift {
namespace {

static_assert(kStageCount <= std::extent_v<decltype(health_t::latency)>);
static_assert(kThreadCount <= std::extent_v<decltype(health_t::threads)>);
static_assert(RunHealth::kMaxPools <= std::extent_v<decltype(health_t::pools)>);
static_assert(static_cast<int>(RunState::kFinishing) == health_t::FINISHING);
static_assert(static_cast<int>(LostReason::kBadTime) == health_t::BAD_TIME);

void fill_latency(health_t* message, const RunHealth& health) {
  message->n_latency = static_cast<std::int32_t>(kStageCount);
  for (std::size_t k = 0; k < kStageCount; ++k) {
    latency_t& out = message->latency[k];
    const RunHealth::Latency& in = health.latency[k];
    out.stage = kStageNames[k];
    out.count = in.count;
    out.p50_ms = in.p50_ms;
    out.p99_ms = in.p99_ms;
    out.max_ms = in.max_ms;
  }
}

void fill_threads(health_t* message, const RunHealth& health) {
  message->n_threads = static_cast<std::int32_t>(kThreadCount);
  for (std::size_t k = 0; k < kThreadCount; ++k) {
    thread_t& out = message->threads[k];
    const RunHealth::Thread& in = health.threads[k];
    out.name = kThreadNames[k];
    out.deadline_misses = in.deadline_misses;
    out.heap_calls = in.heap_calls;
    out.realtime = in.realtime ? 1 : 0;
    out.disabled = in.disabled ? 1 : 0;
  }
}

void fill_pools(health_t* message, const RunHealth& health) {
  const auto count = static_cast<std::size_t>(
      std::clamp<std::int32_t>(health.pool_count, 0, static_cast<std::int32_t>(health.pools.size())));
  message->n_pools = static_cast<std::int32_t>(count);
  for (std::size_t k = 0; k < health.pools.size(); ++k) {
    pool_t& out = message->pools[k];
    const RunHealth::Pool in = k < count ? health.pools[k] : RunHealth::Pool{};
    out.name.assign(in.name.data(), strnlen(in.name.data(), in.name.size()));
    out.capacity = in.capacity;
    out.high_water = in.high_water;
    out.refused = in.refused;
  }
}

}  // namespace

health_t make_health_message() {
  health_t message{};
  for (latency_t& entry : message.latency) entry.stage.reserve(32);
  for (thread_t& entry : message.threads) entry.name.reserve(32);
  for (pool_t& entry : message.pools) entry.name.reserve(32);
  return message;
}

void fill(health_t* message, const RunHealth& health) {
  message->frame_utime = health.timestamp_ns / 1000;
  message->uptime_s = static_cast<double>(health.uptime_ns) * 1e-9;
  message->state = static_cast<std::int8_t>(health.state);
  message->lost_reason = static_cast<std::int8_t>(health.lost_reason);
  message->anchored = health.anchored ? 1 : 0;
  message->frames_received = health.frames_received;
  message->frames_dropped = health.frames_dropped;
  message->frames_tracked = health.frames_tracked;
  message->frames_lost = health.frames_lost;
  message->fragments = health.fragments;
  message->back_backlog = health.back_backlog;
  message->loops_proposed = health.loops_proposed;
  message->loops_accepted = health.loops_accepted;
  message->epoch = health.correction_epoch;
  message->resident_bytes = health.resident_bytes;
  message->budget_bytes = health.budget_bytes;
  message->fence_limit_bytes = health.fence_limit_bytes;
  message->fence_peak_bytes = health.fence_peak_bytes;
  message->fence_refusals = health.fence_refusals;
  message->temperature_c = health.temperature_c;
  message->clock_mhz = health.clock_mhz;
  fill_latency(message, health);
  fill_threads(message, health);
  fill_pools(message, health);
}

}  // namespace loopsift
