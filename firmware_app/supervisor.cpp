// SPDX-License-Identifier: MIT
#include "firmware_app/supervisor.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "core/base/steady_time.hpp"
#include "firmware_app/board.hpp"
#include "firmware_app/realtime.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr const char* kMoreTime = "EXTEND_TIMEOUT_USEC=60000000";  // else it ends what stops too slowly

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

RunHealth::Latency summary(const LatencyHistogram& times) {
  return {static_cast<float>(times.percentile_ms(0.5)), static_cast<float>(times.percentile_ms(0.99)),
          static_cast<float>(times.max_ms()), times.count()};
}

}  // namespace

std::vector<PoolFigures> store_pools(const FragmentStore& store) {
  const auto pool = [](const char* name, const FragmentStore::Pool& p, std::int64_t refused) {
    return PoolFigures{name, static_cast<std::int64_t>(p.capacity), static_cast<std::int64_t>(p.used),
                       refused};
  };
  return {pool("store/fragments", store.fragment_pool(), store.refused()),
          pool("store/surfels", store.surfel_pool(), 0), pool("store/frames", store.frame_pool(), 0),
          pool("store/views", store.view_pool(), 0)};
}

Supervisor::Supervisor(const Settings& settings, View view, Progress& progress)
    : settings_(settings),
      view_(std::move(view)),
      progress_(progress),
      started_ns_(steady_now_ns()),
      back_at_work_ns_(started_ns_) {}

void Supervisor::ready() { service_.notify("READY=1"); }

RunState Supervisor::state(std::int64_t now_ns) const {
  if (finishing_) return RunState::kFinishing;
  const FrontStatus& front = view_.front.status();
  if (view_.source.away() || seconds(view_.source.waiting_ns(now_ns)) > settings_.watchdog.no_source_s)
    return RunState::kNoSource;
  if (front.frames == 0) return RunState::kStarting;
  return front.newest_lost ? RunState::kLost : RunState::kTracking;
}

void Supervisor::tick() {
  const std::int64_t now = steady_now_ns();
  tell_notes();
  obey_commands();
  watch(now);
  progress_.update(progress_state(now), seconds(now));
  const RunState state = this->state(now);
  if (state != told_state_ && service_.present())
    service_.notify(("STATUS=" + std::string(to_string(state))).c_str());
  told_state_ = state;
  if (now - health_told_ns_ < kSecond_ns) return;
  health_told_ns_ = now;
  if (finishing_) service_.notify(kMoreTime);
  (void)view_.publisher.publish(health(now));
}

void Supervisor::tell_notes() {
  FrontLoop::Note note;
  while (view_.front.next_note(&note)) spdlog::warn("{}", note.text.data());
}

void Supervisor::obey_commands() {
  Command command;
  while (view_.publisher.take(&command))
    view_.publisher.acknowledge(Publisher::AckFrom::kTaker, obey(command));
}

AckRecord Supervisor::obey(const Command& command) {
  switch (command.kind) {
    case CommandKind::kPause:
    case CommandKind::kResume: {
      const bool pause = command.kind == CommandKind::kPause;
      view_.control.paused = pause;
      view_.publisher.set_paused(pause);
      return answer(command, AckStatus::kDone, pause ? "paused" : "resumed");
    }
    case CommandKind::kFinish:
      view_.control.finish = true;
      return answer(command, AckStatus::kDone, "finishing");
    case CommandKind::kSave:
      return view_.back_worker.request_save(command)
                 ? answer(command, AckStatus::kStarted, "saving")
                 : answer(command, AckStatus::kRefused, "no map can be saved now");
    case CommandKind::kResend:
      break;  // the publisher's own
  }
  return answer(command, AckStatus::kRefused, "not for the program");
}

void Supervisor::watch(std::int64_t now_ns) {
  const ThreadMonitor& front = view_.monitors[static_cast<std::size_t>(ThreadRole::kFront)];
  const ThreadMonitor& back = view_.monitors[static_cast<std::size_t>(ThreadRole::kBack)];
  const bool front_hangs = seconds(front.busy_ns(now_ns)) > settings_.watchdog.front_hung_s;
  if (!front_hangs) {
    service_.keep_alive(now_ns);
  } else if (!std::exchange(front_hang_told_, true)) {
    spdlog::error("a frame has been in work for more than {} s (watchdog.front_hung_s)",
                  settings_.watchdog.front_hung_s);
  }
  if (back.busy_ns(now_ns) > 0 || view_.back_worker.backlog() == 0) back_at_work_ns_ = now_ns;
  const std::int64_t idle_ns = now_ns - back_at_work_ns_;  // with work that waits
  if (seconds(std::max(back.busy_ns(now_ns), idle_ns)) > settings_.watchdog.back_hung_s)
    view_.back_worker.abandon();
  if (view_.back_worker.disabled() && !std::exchange(back_end_told_, true))
    spdlog::error(
        "no further loops are looked for: the back thread {}. Poses go on with the last correction",
        back.running() ? "hangs (watchdog.back_hung_s)" : "ran out of memory (memory.back_heap_mib)");
}

void Supervisor::finishing() {
  finishing_ = true;
  service_.notify("STOPPING=1");
  service_.notify(kMoreTime);
  health_told_ns_ -= kSecond_ns;  // what became of the last frames is told at once
  tick();
}

void Supervisor::ended() {
  service_.notify(kMoreTime);  // for the results
  tell_notes();
  const std::int64_t now = steady_now_ns();
  progress_.finish(progress_state(now), seconds(now));
}

ProgressState Supervisor::progress_state(std::int64_t now_ns) const {
  ProgressState progress;
  const RunState state = this->state(now_ns);
  progress.activity = state == RunState::kTracking ? "mapping" : to_string(state);
  if (finishing_) progress.activity = "sifting";
  const FrontStatus& front = view_.front.status();
  progress.frames = front.frames;
  progress.frame_count = view_.frame_count;
  progress.fragments = front.fragments;
  progress.loops_proposed = view_.back_worker.loops_proposed();
  progress.loops_accepted = view_.back_worker.loops_accepted();
  const FrameQueueCounts counts = view_.queue.counts();
  progress.frames_dropped = counts.dropped + counts.bad;
  if (settings_.run.rate == Rate::kRealtime)
    progress.frames_late = view_.monitors[static_cast<std::size_t>(ThreadRole::kFront)].deadline_misses();
  return progress;
}

RunHealth Supervisor::health(std::int64_t now_ns) const {
  RunHealth health;
  const FrontStatus& front = view_.front.status();
  const FrameQueueCounts counts = view_.queue.counts();
  health.timestamp_ns = front.newest_timestamp_ns;
  health.uptime_ns = now_ns - started_ns_;
  health.state = state(now_ns);
  health.lost_reason = front.lost_reason;
  health.anchored = front.anchored;
  health.frames_received = counts.received + counts.bad;
  health.frames_dropped = counts.dropped + counts.bad;
  health.frames_tracked = front.tracked;
  health.frames_lost = front.lost;
  fill_latency(&health);
  for (std::size_t t = 0; t < kThreadCount; ++t) {
    const ThreadMonitor& monitor = view_.monitors[t];
    health.threads[t] = {monitor.deadline_misses(), monitor.heap_calls(), monitor.realtime(), false};
  }
  const BackWorker& back = view_.back_worker;
  health.threads[static_cast<std::size_t>(ThreadRole::kBack)].disabled = back.disabled();
  fill_pools(&health);
  health.fragments = front.fragments;
  health.back_backlog = static_cast<std::int32_t>(back.backlog());
  health.loops_proposed = static_cast<std::int32_t>(back.loops_proposed());
  health.loops_accepted = static_cast<std::int32_t>(back.loops_accepted());
  health.correction_epoch = front.epoch;
  health.resident_bytes = resident_bytes();
  health.budget_bytes = view_.budget_bytes;
  health.fence_limit_bytes = back.heap_limit_bytes();
  if (heap_is_watched()) health.fence_peak_bytes = back.heap_figures().peak_bytes;
  health.fence_refusals = back.heap_figures().refusals;
  const BoardStatus board = read_board();
  health.temperature_c = board.temperature_c;
  health.clock_mhz = board.clock_mhz;
  return health;
}

void Supervisor::fill_pools(RunHealth* health) const {
  std::vector<PoolFigures> pools = store_pools(view_.store);
  for (const std::vector<PoolFigures>& more :
       {view_.front.pools(), view_.back_worker.pools(), view_.publisher.pools()})
    pools.insert(pools.end(), more.begin(), more.end());
  for (const PoolFigures& pool : pools) {
    if (health->pool_count == static_cast<std::int32_t>(RunHealth::kMaxPools)) return;
    RunHealth::Pool& told = health->pools[static_cast<std::size_t>(health->pool_count++)];
    std::strncpy(told.name.data(), pool.name.c_str(), told.name.size() - 1);
    told.capacity = pool.capacity;
    told.high_water = pool.high_water;
    told.refused = pool.refused;
  }
}

void Supervisor::fill_latency(RunHealth* health) const {
  const auto put = [&](Stage stage, const LatencyHistogram& times) {
    health->latency[static_cast<std::size_t>(stage)] = summary(times);
  };
  for (const Stage stage : {Stage::kOdometry, Stage::kFusion, Stage::kFrame, Stage::kCaptureToPose})
    put(stage, view_.figures.latency[static_cast<std::size_t>(stage)]);
  put(Stage::kProposal, view_.back_end.proposal_times());
  put(Stage::kLoopSolve, view_.back_end.sifter().solve_times());
  put(Stage::kLoopScore, view_.back_end.sifter().score_times());
  put(Stage::kLoopTest, view_.back_end.sifter().test_times());
  put(Stage::kCorrection, view_.back_worker.correction_times());
}

}  // namespace loopsift
