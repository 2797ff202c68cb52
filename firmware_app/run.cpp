// SPDX-License-Identifier: MIT
#include "firmware_app/run.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <string>
#include <utility>

#include "core/base/steady_time.hpp"
#include "core/pipeline/run_report.hpp"
#include "firmware_app/realtime.hpp"
#include "firmware_app/run_results.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kLastWordsOfAStop_ns = 200'000'000;

}  // namespace

Run::Run(const Settings& settings, std::unique_ptr<SupervisedSource> source,
         std::unique_ptr<ExternalOdometry> given, const MemoryPlan& plan)
    : settings_(settings),
      source_(std::move(source)),
      given_(std::move(given)),
      arena_(plan.arena_bytes),
      parts_(settings_, *source_, given_.get(), shared_, arena_) {
  shared_.figures.source = source_->info().description;
  shared_.figures.memory.budget_bytes = static_cast<std::int64_t>(plan.budget.total_bytes());
  shared_.figures.memory.cap_bytes = static_cast<std::int64_t>(mebibytes(settings_.memory.cap_mib));
}

/// What must be asked of the system before the threads start, and after all parts were made: what they took
/// of the heap does not come from the back thread's region.
void Run::prepare() {
  warm_heap(heap_region_bytes(settings_));
  const bool live = settings_.run.rate == Rate::kRealtime || source_->info().live;
  const RealtimeRights rights = prepare_realtime(settings_.threads, live);
  if (!rights.warning.empty()) spdlog::warn("{}", rights.warning);
  const auto plans = thread_plans(settings_, rights);
  for (std::size_t t = 0; t < kThreadCount; ++t) shared_.monitors[t].set_plan(plans[t]);
}

void Run::start_threads(RunControl& control) {
  capture_ = std::thread([this] {
    ThreadTenure tenure(&shared_[ThreadRole::kCapture]);
    parts_.source.begin(&tenure);
    parts_.queue.run();
    parts_.source.end();
  });
  source_->start();
  parts_.back_worker.start();
  front_ = std::thread([this, &control] {
    {
      ThreadTenure tenure(&shared_[ThreadRole::kFront]);
      source_status_ = parts_.front.run(control, &shared_[ThreadRole::kFront], &tenure);
    }
    front_ended_.post();
  });
}

std::optional<Failure> Run::go(RunControl& control, Progress& progress) {
  prepare();
  if (const Status started = parts_.publisher.start(&parts_.store, &shared_[ThreadRole::kPublish]);
      !started.ok())
    spdlog::warn("{}", started.error().message);
  Supervisor supervisor(settings_,
                        {parts_.source, parts_.queue, parts_.front, parts_.back_worker, parts_.publisher,
                         control, parts_.store, parts_.back_end, shared_.figures, shared_.monitors,
                         source_->info().frame_count, shared_.figures.memory.budget_bytes},
                        progress);
  start_threads(control);
  supervisor.ready();
  while (!front_ended_.wait_until(steady_now_ns() + Supervisor::kTick_ns)) {
    supervisor.tick();
    if (control.stop) parts_.back_worker.request_end(Ending::kQuick);  // at rate max the front waits for it
  }
  front_.join();
  supervisor.finishing();
  parts_.queue.stop();
  parts_.front.close_last();
  wait_for_back(control, &supervisor);
  parts_.front.apply_corrections();
  wait_for_capture();
  if (!capture_.joinable())
    if (const std::string told = parts_.recorder.finish(); !told.empty()) spdlog::info("{}", told);
  stopped_ = control.stop;
  parts_.publisher.stop(stopped_ ? kLastWordsOfAStop_ns : Publisher::kLastWords_ns);
  supervisor.ended();
  if (given_ != nullptr && !given_->summary().empty()) spdlog::info("odometry: {}", given_->summary());
  if (source_status_ != ReadStatus::kLost) return std::nullopt;
  return Failure{Phase::kSourceRead,
                 {ErrorCode::kIo, "the source was lost: " + std::string(parts_.front.message())}};
}

void Run::wait_for_back(RunControl& control, Supervisor* supervisor) {
  BackWorker& back = parts_.back_worker;
  back.request_end(Ending::kThorough);
  std::int64_t stopped_ns = 0;
  while (!back.ended()) {
    const std::int64_t now = steady_now_ns();
    if (control.stop && stopped_ns == 0) {
      stopped_ns = now;
      back.request_end(Ending::kQuick);
    }
    const double waited_s = stopped_ns == 0 ? 0.0 : static_cast<double>(now - stopped_ns) * 1e-9;
    if (waited_s > settings_.watchdog.stop_s) back.abandon();
    if (back.disabled() && shared_[ThreadRole::kBack].running() && !back.ended()) return;
    supervisor->tick();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  back.join();
  back_joined_ = true;
}

/// A driver that waits for its device for ever must not keep the results from being written.
void Run::wait_for_capture() {
  constexpr int kPatience_ms = 500;
  for (int waited = 0; shared_[ThreadRole::kCapture].running() && waited < kPatience_ms; waited += 10)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (shared_[ThreadRole::kCapture].running()) return;
  capture_.join();
  source_ended_ = source_->end(kPatience_ms);
}

Status Run::write(double started_s) {
  RunFigures& figures = shared_.figures;
  collect(parts_, &shared_);
  const bool back_end_is_whole = back_joined_ && !parts_.back_worker.disabled();
  if (back_end_is_whole) collect_back(parts_, &figures);
  if (back_end_is_whole && !stopped_) score(parts_.back_end, &figures.dmp);
  const std::string& out = settings_.run.out;
  if (out.empty()) return {};
  const Status written = write_files(out, parts_, back_end_is_whole);
  figures.memory.peak_rss_bytes = peak_rss_bytes();
  figures.wall_s = static_cast<double>(steady_now_ns()) * 1e-9 - started_s;
  const Status report = write_run_report(out + "/run.json", figures);
  return written.ok() ? report : written;
}

}  // namespace loopsift
