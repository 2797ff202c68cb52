// SPDX-License-Identifier: MIT
#include "firmware_app/wiring.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "core/base/arena.hpp"
#include "core/base/semaphore.hpp"
#include "core/base/steady_time.hpp"
#include "core/fragment/front_end.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/results.hpp"
#include "core/pipeline/run_figures.hpp"
#include "core/pipeline/run_report.hpp"
#include "drivers/decode_ahead.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/back_worker.hpp"
#include "firmware_app/front_loop.hpp"
#include "firmware_app/given_odometry.hpp"
#include "firmware_app/publisher.hpp"
#include "firmware_app/realtime.hpp"
#include "firmware_app/recorder.hpp"
#include "firmware_app/supervised_source.hpp"
#include "firmware_app/supervisor.hpp"
#include "firmware_app/watched_source.hpp"

namespace loopsift {
namespace {

constexpr const char* kUsualSource = "synth:room";  // 640×480 with colour
constexpr std::size_t kMib = std::size_t{1} << 20;
constexpr std::int64_t kLastWordsOfAStop_ns = 200'000'000;

double steady_seconds() { return static_cast<double>(steady_now_ns()) * 1e-9; }

std::size_t mebibytes(int count) { return static_cast<std::size_t>(count) * kMib; }

/// What the back thread may hold, and a quarter more for what lies between its blocks.
std::size_t heap_region_bytes(const Settings& settings) {
  return mebibytes(settings.memory.back_heap_mib) / 4 * 5;
}

FrameQueueOptions queue_options(const Settings& settings) {
  FrameQueueOptions options;
  options.realtime = settings.run.rate == Rate::kRealtime;
  return options;
}

GraphLimits graph_limits(const Settings& settings) {
  constexpr int kEdgesPerNode = 3;  // one of the odometry, the rest of loops
  GraphLimits limits;
  limits.max_fragments = settings.store.max_fragments;
  limits.max_nodes = limits.max_fragments * settings.back_end.keyframes_per_fragment;
  limits.max_edges = limits.max_nodes * kEdgesPerNode;
  return limits;
}

Status make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, path + ": the folder for the results cannot be made: " + error.message()};
}

/// What every thread may look at: outside the arena, there before it.
struct Shared {
  RunFigures figures;
  ThreadMonitors monitors{ThreadMonitor(ThreadRole::kCapture), ThreadMonitor(ThreadRole::kFront),
                          ThreadMonitor(ThreadRole::kBack), ThreadMonitor(ThreadRole::kPublish)};
  ThreadMonitor& operator[](ThreadRole role) { return monitors[static_cast<std::size_t>(role)]; }
};

/// Everything that lives in the arena, made once to measure and once for the run.
struct Parts {
  Parts(const Settings& settings, SupervisedSource& frame_source, ExternalOdometry* given, Shared& shared,
        Arena& arena)
      : recorder(settings.record, frame_source.info(), arena),
        source(frame_source, shared[ThreadRole::kCapture], recorder),
        queue(source, queue_options(settings), arena),
        publisher(settings.lcm, arena, graph_limits(settings)),
        store(settings.store, arena),
        front_end(source.info().camera, source.info().depth_unit_m, settings.front_end, &store, arena),
        back_end(settings.back_end, arena),
        back_worker(back_end, store, publisher, arena, back_worker_options(settings, shared)),
        front({queue, front_end, back_worker, publisher, given}, settings.lcm.slew,
              settings.run.rate == Rate::kMax, static_cast<std::size_t>(settings.store.max_frames),
              &shared.figures, arena) {}

  BackWorkerOptions back_worker_options(const Settings& settings, Shared& shared) {
    BackWorkerOptions options;
    options.heap_bytes = static_cast<std::int64_t>(mebibytes(settings.memory.back_heap_mib));
    options.steps_per_fragment = settings.back_end.steps_per_fragment;
    options.realtime = settings.run.rate == Rate::kRealtime;
    options.max_nodes = graph_limits(settings).max_nodes;
    options.monitor = &shared[ThreadRole::kBack];
    if (!settings.run.out.empty())
      options.save = [this, to = settings.run.out + "/saved"] { return save(to); };
    return options;
  }
  /// What there is by now. Back thread.
  Status save(const std::string& to) const {
    if (const Status made = make_folder(to); !made.ok()) return made;
    return write_results(to, back_end, front.poses(), store.fragments());
  }

  FrameRecorder recorder;
  WatchedSource source;
  FrameQueue queue;
  Publisher publisher;
  FragmentStore store;
  FrontEnd front_end;
  BackEnd back_end;
  BackWorker back_worker;
  FrontLoop front;
};

/// The budget of a run, and how much of it the arena has.
struct MemoryPlan {
  MemoryBudget budget;
  std::size_t arena_bytes = 0;
};

/// What is there beside the arena: the program with what its source and libraries took so far, what of their
/// code a run will still load (measured), stacks, and the heap of the back thread.
void add_process_rows(const Settings& settings, MemoryBudget* budget) {
  constexpr std::size_t kCodeToCome = 3 * kMib;
  const auto so_far = static_cast<std::size_t>(resident_bytes());
  budget->add("process/program, source", 1, (so_far + kCodeToCome + kMib - 1) / kMib * kMib);
  budget->add("process/stacks", kThreadCount, kThreadCount * kStackBytes / 4);
  budget->add("back/heap", 1, heap_region_bytes(settings));
}

std::optional<Failure> measure(const Settings& settings, SupervisedSource& source, MemoryPlan* plan) {
  if (const Status fits = check_views(settings, source.info().camera); !fits.ok())
    return Failure{Phase::kSettings, fits.error()};
  Arena measuring;
  Shared shared;
  const Parts parts(settings, source, nullptr, shared, measuring);
  plan->budget = measuring.budget();
  plan->arena_bytes = plan->budget.total_bytes();
  add_process_rows(settings, &plan->budget);
  const std::size_t cap_bytes = mebibytes(settings.memory.cap_mib);
  if (plan->budget.total_bytes() <= cap_bytes) return std::nullopt;
  return Failure{Phase::kMemoryPlan,
                 {ErrorCode::kCapacity,
                  "the memory budget is over memory.cap_mib; raise it, or make the largest "
                  "of these smaller:\n" +
                      plan->budget.to_text(cap_bytes)}};
}

void collect_back(const Parts& parts, RunFigures* figures) {
  const Sifter& sifter = parts.back_end.sifter();
  figures->loops.proposed = static_cast<std::int64_t>(sifter.records().size()) + sifter.dropped();
  figures->loops.dropped = sifter.dropped();
  figures->loops.pending = sifter.pending();
  figures->loops.scored = sifter.counts().scored;
  figures->loops.tested = sifter.counts().tested;
  figures->loops.accepted = static_cast<std::int64_t>(sifter.accepted().size());
  figures->loops.revoked = sifter.counts().revoked;
  figures->dmp.views = parts.back_end.scorer().view_count();
}

/// All views of both maps: seconds, where the map is large.
void score(const BackEnd& back_end, RunFigures::Dmp* dmp) {
  dmp->odometry_m2 = back_end.dmp_odometry();
  dmp->final_m2 = back_end.dmp_final();
}

void collect(const Parts& parts, const Shared& shared, RunFigures* figures) {
  const FrameQueueCounts counts = parts.queue.counts();
  const FrontStatus& front = parts.front.status();
  figures->frames = {counts.received + counts.bad, counts.dropped + counts.bad, front.tracked, front.lost};
  (*figures)[Stage::kProposal] = parts.back_end.proposal_times();
  (*figures)[Stage::kLoopSolve] = parts.back_end.sifter().solve_times();
  (*figures)[Stage::kLoopScore] = parts.back_end.sifter().score_times();
  (*figures)[Stage::kLoopTest] = parts.back_end.sifter().test_times();
  (*figures)[Stage::kCorrection] = parts.back_worker.correction_times();
  figures->pools = parts.publisher.pools();
  for (const std::vector<PoolFigures>& more :
       {store_pools(parts.store), parts.front.pools(), parts.back_worker.pools()})
    figures->pools.insert(figures->pools.end(), more.begin(), more.end());
  const ActiveSurfels& active = parts.front_end.builder().active();
  figures->pools.push_back({"fragment/active surfels", static_cast<std::int64_t>(active.capacity()),
                            static_cast<std::int64_t>(active.high_water()),
                            static_cast<std::int64_t>(active.refused())});
  const auto monitor = [&](ThreadRole role) -> const ThreadMonitor& {
    return shared.monitors[static_cast<std::size_t>(role)];
  };
  const auto counted = [](std::int64_t calls) { return calls < 0 ? std::nullopt : std::optional(calls); };
  figures->memory.capture_heap_calls = counted(monitor(ThreadRole::kCapture).heap_calls());
  figures->memory.front_heap_calls = counted(monitor(ThreadRole::kFront).heap_calls());
  figures->memory.publish_heap_calls = counted(monitor(ThreadRole::kPublish).heap_calls());
  figures->memory.camera_library_heap_calls = counted(monitor(ThreadRole::kCapture).library_heap_calls());
  if (!heap_is_watched()) return;
  figures->memory.fence_peak_bytes = parts.back_worker.heap_figures().peak_bytes;
  figures->memory.fence_refusals = parts.back_worker.heap_figures().refusals;
}

/// One run, from its threads' start to its results. On the heap: what a thread that hangs still uses is left
/// where it is.
class Run {
 public:
  Run(const Settings& settings, std::unique_ptr<SupervisedSource> source,
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

  [[nodiscard]] Status start_recording() { return parts_.recorder.start(); }
  std::optional<Failure> go(RunControl& control, Progress& progress);
  [[nodiscard]] Status write(double started_s);
  /// Whether the back thread, or one of those that wait for the device, could not be ended.
  [[nodiscard]] bool thread_left_behind() const { return !source_ended_ || !back_joined_; }

 private:
  void prepare();
  void start_threads(RunControl& control);
  void wait_for_back(RunControl& control, Supervisor* supervisor);
  void wait_for_capture();

  Settings settings_;
  Shared shared_;
  std::unique_ptr<SupervisedSource> source_;
  std::unique_ptr<ExternalOdometry> given_;
  Arena arena_;
  Parts parts_;
  std::thread capture_, front_;
  Semaphore front_ended_;
  ReadStatus source_status_ = ReadStatus::kEnd;
  bool source_ended_ = false, back_joined_ = false;
  bool stopped_ = false;  // by a signal: whoever sent it waits
};

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
  if (source_ended_)
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
  collect(parts_, shared_, &figures);
  const bool back_end_is_whole = back_joined_ && !parts_.back_worker.disabled();
  if (back_end_is_whole) collect_back(parts_, &figures);
  if (back_end_is_whole && !stopped_) score(parts_.back_end, &figures.dmp);
  const std::string& out = settings_.run.out;
  if (out.empty()) return {};
  const FrontLoop& front = parts_.front;
  Status written =
      back_end_is_whole
          ? write_results(out, parts_.back_end, front.poses(), parts_.store.fragments())
          : write_front_results(out, front.T_map_odom(), front.poses(), parts_.store.fragments());
  if (!back_end_is_whole)
    spdlog::warn("the back thread did not end: the results are the odometry's, moved by the last correction");
  figures.memory.peak_rss_bytes = peak_rss_bytes();
  figures.wall_s = steady_seconds() - started_s;
  const Status report = write_run_report(out + "/run.json", figures);
  return written.ok() ? report : written;
}

}  // namespace

std::optional<Failure> plan_memory(const Settings& settings, MemoryBudget* budget) {
  const std::string uri = settings.run.source.empty() ? kUsualSource : settings.run.source;
  auto opened = open_source(uri, settings.source);
  if (!opened.ok()) return Failure{Phase::kSourceOpen, opened.error()};
  SupervisedSource source(std::move(*opened), nullptr, settings.retry);
  MemoryPlan plan;
  std::optional<Failure> failure = measure(settings, source, &plan);
  *budget = std::move(plan.budget);
  return failure;
}

RunEnd run(const Settings& settings, RunControl& control, Progress* progress) {
  const double started_s = steady_seconds();
  limit_stacks();
  const SourceOpener open = [uri = settings.run.source, options = settings.source] {
    return open_source(uri, options);
  };
  auto opened = open_patiently(open, settings.retry, control.stop);
  if (!opened.ok()) return {Failure{Phase::kSourceOpen, opened.error()}};
  auto source = std::make_unique<SupervisedSource>(std::move(*opened), open, settings.retry);
  const bool camera_clock = source->info().live && settings.run.source.rfind("lcm:", 0) != 0;
  auto odometry = open_odometry(settings.run.odometry, settings.trajectory_odometry, settings.lcm_odometry,
                                settings.source.lcm_in, camera_clock);
  if (!odometry.ok()) return {Failure{Phase::kSourceOpen, odometry.error()}};
  MemoryPlan plan;
  if (auto failure = measure(settings, *source, &plan)) return {failure};
  spdlog::info("memory:\n{}", plan.budget.to_text(mebibytes(settings.memory.cap_mib)));
  if (!settings.run.out.empty())
    if (const Status made = make_folder(settings.run.out); !made.ok())
      return {Failure{Phase::kRun, made.error()}};
  auto one = std::make_unique<Run>(settings, std::move(source), std::move(*odometry), plan);
  if (const Status recording = one->start_recording(); !recording)
    return {Failure{Phase::kRun, recording.error()}};
  RunEnd end{one->go(control, *progress)};
  if (const Status written = one->write(started_s); !written.ok() && !end.failure)
    end.failure = Failure{Phase::kRun, written.error()};
  end.thread_left_behind = one->thread_left_behind();
  if (end.thread_left_behind) (void)one.release();
  return end;
}

}  // namespace loopsift
