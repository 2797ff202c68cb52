// SPDX-License-Identifier: MIT
#include "firmware_app/wiring.hpp"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <string>

#include "core/base/arena.hpp"
#include "core/base/steady_time.hpp"
#include "core/fragment/front_end.hpp"
#include "core/odometry/trajectory_odometry.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/results.hpp"
#include "core/pipeline/run_figures.hpp"
#include "core/pipeline/run_report.hpp"
#include "drivers/decode_ahead.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/back_worker.hpp"
#include "firmware_app/publisher.hpp"

namespace loopsift {
namespace {

constexpr int kReadTimeout_ms = 100;
constexpr const char* kUsualSource = "synth:room";  // 640×480 with colour

double steady_seconds() { return static_cast<double>(steady_now_ns()) * 1e-9; }

SourceOptions source_options(const Settings& settings) {
  SourceOptions options;
  options.camera = settings.camera.model;
  options.depth_scale = settings.camera.depth_scale;
  options.rate_hz = settings.replay.rate_hz;
  return options;
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

/// Everything that lives in the arena, made once to measure and once for the run.
struct Parts {
  Parts(const Settings& settings, FrameSource& source, Arena& arena)
      : queue(source, queue_options(settings), arena),
        publisher(settings.lcm, arena, graph_limits(settings)),
        store(settings.store, arena),
        front_end(source.info().camera, source.info().depth_unit_m, settings.front_end, &store, arena),
        back_end(settings.back_end, arena),
        back_worker(back_end, store, publisher, arena),
        poses(arena.carve<OdometryPose>("pipeline/poses",
                                        static_cast<std::size_t>(settings.store.max_frames))) {}
  FrameQueue queue;
  Publisher publisher;
  FragmentStore store;
  FrontEnd front_end;
  BackEnd back_end;
  BackWorker back_worker;
  Span<OdometryPose> poses;  // of every tracked frame
};

std::optional<Failure> measure(const Settings& settings, FrameSource& source, MemoryBudget* budget) {
  if (const Status fits = check_views(settings, source.info().camera); !fits.ok())
    return Failure{Phase::kSettings, fits.error()};
  Arena measuring;
  const Parts parts(settings, source, measuring);
  *budget = measuring.budget();
  const std::size_t cap_bytes = static_cast<std::size_t>(settings.memory.cap_mib) << 20;
  if (budget->total_bytes() <= cap_bytes) return std::nullopt;
  return Failure{Phase::kMemoryPlan,
                 {ErrorCode::kCapacity,
                  "the memory budget is over memory.cap_mib; raise it, or make the largest "
                  "of these smaller:\n" +
                      budget->to_text(cap_bytes)}};
}

/// The front thread: one frame after the other, from the queue to the pose.
class FrontLoop {
 public:
  FrontLoop(const Settings& settings, Parts& parts, TrajectoryOdometry* given, RunFigures* figures,
            Progress* progress)
      : lockstep_(settings.run.rate == Rate::kMax),
        parts_(parts),
        given_(given),
        figures_(*figures),
        progress_(*progress) {}

  /// Until the source's end, its loss, or `stop`.
  std::optional<Failure> run(const std::atomic<bool>& stop, std::int64_t frame_count) {
    state_.frame_count = frame_count;
    std::optional<Failure> failure;
    for (bool reading = true; reading && !stop;) {
      RawFrame* frame = nullptr;
      switch (parts_.queue.next(&frame, kReadTimeout_ms)) {
        case ReadStatus::kFrame:
          take(*frame);
          parts_.queue.release(frame);
          break;
        case ReadStatus::kBad:
          spdlog::warn("frame skipped: {}", parts_.queue.message());
          break;
        case ReadStatus::kTimeout:
          break;
        case ReadStatus::kEnd:
          reading = false;
          break;
        case ReadStatus::kLost:
          failure = Failure{Phase::kSourceRead,
                            {ErrorCode::kIo, "the source was lost: " + std::string(parts_.queue.message())}};
          reading = false;
          break;
      }
      progress_.update(state(), steady_seconds());
    }
    return failure;
  }

  /// Closes the last fragment and waits for the back thread's last word.
  void finish() {
    state_.activity = "sifting";
    progress_.update(state(), steady_seconds());
    if (parts_.front_end.finish() != nullptr) parts_.back_worker.submit(last_timestamp_ns_);
    parts_.back_worker.finish();
    apply_corrections();
    progress_.finish(state(), steady_seconds());
  }

  [[nodiscard]] Span<const OdometryPose> poses() const { return {parts_.poses.data(), pose_count_}; }
  /// The store of poses(): past its end a run goes on, and its trajectory files end.
  [[nodiscard]] PoolFigures pose_pool() const {
    return {"pipeline/poses", static_cast<std::int64_t>(parts_.poses.size()),
            static_cast<std::int64_t>(pose_count_), poses_refused_};
  }

 private:
  void take(const RawFrame& raw) {
    const std::int64_t start = steady_now_ns();
    const FrontEndResult result =
        given_ == nullptr
            ? parts_.front_end.process(raw)
            : parts_.front_end.process(
                  raw, given_->track(FrameId{static_cast<std::int32_t>(raw.sequence)}, raw.timestamp_ns));
    apply_corrections();
    if (result.tracking.status == TrackingStatus::kLost) {
      ++figures_.frames.lost;
    } else {
      keep(result);
    }
    if (result.closed != nullptr) hand_over(raw.timestamp_ns);
    note_times(result, start, raw);
    if (state_.frames++ == 0) first_timestamp_ns_ = raw.timestamp_ns;
    last_timestamp_ns_ = raw.timestamp_ns;
    figures_.sequence_duration_s = static_cast<double>(last_timestamp_ns_ - first_timestamp_ns_) * 1e-9;
  }

  void keep(const FrontEndResult& result) {
    ++figures_.frames.tracked;
    T_odom_camera_ = result.tracking.T_odom_camera;
    if (pose_count_ < parts_.poses.size()) {
      parts_.poses[pose_count_++] = {result.timestamp_ns, T_odom_camera_};
    } else {
      ++poses_refused_;
    }
    (void)parts_.publisher.publish(
        PoseRecord{result.timestamp_ns, T_odom_camera_, T_map_odom_, epoch_, result.tracking.information});
  }

  void hand_over(std::int64_t timestamp_ns) {
    ++state_.fragments;
    if (lockstep_) {
      parts_.back_worker.wait_until_idle();  // a fragment's work is always done when the next one closes
      apply_corrections();
    }
    parts_.back_worker.submit(timestamp_ns);
  }

  /// At a frame boundary, as DESIGN's data flow has it: what the back thread found becomes the pose's
  /// correction.
  void apply_corrections() {
    if (lockstep_ && parts_.back_worker.backlog() > 0) return;  // when it comes must not depend on timing
    while (parts_.back_worker.take(&correction_)) {
      correction_.timestamp_ns = last_timestamp_ns_;
      correction_.T_odom_camera = T_odom_camera_;
      correction_.T_map_odom_before = T_map_odom_;
      T_map_odom_ = correction_.T_map_odom;
      epoch_ = correction_.epoch;
      (void)parts_.publisher.publish(correction_);
    }
  }

  void note_times(const FrontEndResult& result, std::int64_t start, const RawFrame& raw) {
    const std::int64_t now = steady_now_ns();
    figures_[Stage::kOdometry].record_ns(result.times.odometry_ns);
    figures_[Stage::kFusion].record_ns(result.times.fusion_ns);
    figures_[Stage::kFrame].record_ns(result.times.preprocess_ns + result.times.odometry_ns +
                                      result.times.fusion_ns);
    figures_[Stage::kCaptureToPose].record_ns(now - (raw.captured_ns > 0 ? raw.captured_ns : start));
  }

  const ProgressState& state() {
    state_.loops_proposed = parts_.back_worker.loops_proposed();
    state_.loops_accepted = parts_.back_worker.loops_accepted();
    return state_;
  }

  bool lockstep_;
  Parts& parts_;
  TrajectoryOdometry* given_;  // null: the built-in odometry
  RunFigures& figures_;
  Progress& progress_;
  ProgressState state_;
  CorrectionRecord correction_;
  Se3 T_odom_camera_, T_map_odom_;
  std::int32_t epoch_ = 0;  // of the correction that T_map_odom_ is
  std::int64_t first_timestamp_ns_ = 0, last_timestamp_ns_ = 0;
  std::size_t pose_count_ = 0;
  std::int64_t poses_refused_ = 0;
};

Status make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, path + ": the folder for the results cannot be made: " + error.message()};
}

/// Nothing for the built-in odometry.
Expected<std::optional<TrajectoryOdometry>> open_odometry(const Settings& settings) {
  const std::string& odometry = settings.run.odometry;
  if (odometry == "builtin") return std::optional<TrajectoryOdometry>();
  if (odometry.rfind("file:", 0) != 0) {
    return Error{ErrorCode::kUnsupported,
                 odometry + ": this build takes odometry from builtin or file:TRAJECTORY only"};
  }
  auto given = TrajectoryOdometry::open(odometry.substr(5), settings.trajectory_odometry);
  if (!given.ok()) return given.error();
  return std::optional<TrajectoryOdometry>(std::move(*given));
}

PoolFigures pool(const std::string& name, const FragmentStore::Pool& p, std::int64_t refused) {
  return {name, static_cast<std::int64_t>(p.capacity), static_cast<std::int64_t>(p.used), refused};
}

void collect(const Parts& parts, RunFigures* figures) {
  const FrameQueueCounts counts = parts.queue.counts();
  figures->frames.received = counts.received + counts.bad;
  figures->frames.dropped = counts.dropped + counts.bad;
  const Sifter& sifter = parts.back_end.sifter();
  figures->loops.proposed = static_cast<std::int64_t>(parts.back_end.proposals().size());
  figures->loops.scored = sifter.counts().scored;
  figures->loops.tested = sifter.counts().tested;
  figures->loops.accepted = static_cast<std::int64_t>(sifter.accepted().size());
  figures->loops.revoked = sifter.counts().revoked;
  (*figures)[Stage::kProposal] = parts.back_end.proposal_times();
  (*figures)[Stage::kLoopSolve] = sifter.solve_times();
  (*figures)[Stage::kLoopScore] = sifter.score_times();
  (*figures)[Stage::kLoopTest] = sifter.test_times();
  (*figures)[Stage::kCorrection] = parts.back_worker.correction_times();
  figures->dmp.odometry_m2 = parts.back_end.dmp_odometry();
  figures->dmp.final_m2 = parts.back_end.dmp_final();
  figures->dmp.views = parts.back_end.scorer().view_count();
  figures->pools = parts.publisher.pools();
  const FragmentStore& store = parts.store;
  figures->pools.push_back(pool("store/fragments", store.fragment_pool(), store.refused()));
  figures->pools.push_back(pool("store/surfels", store.surfel_pool(), 0));
  figures->pools.push_back(pool("store/frames", store.frame_pool(), 0));
  figures->pools.push_back(pool("store/views", store.view_pool(), 0));
}

}  // namespace

std::optional<Failure> plan_memory(const Settings& settings, MemoryBudget* budget) {
  const std::string uri = settings.run.source.empty() ? kUsualSource : settings.run.source;
  const auto source = open_source(uri, source_options(settings));
  if (!source.ok()) return Failure{Phase::kSourceOpen, source.error()};
  return measure(settings, **source, budget);
}

std::optional<Failure> run(const Settings& settings, const std::atomic<bool>& stop, Progress* progress) {
  const double started_s = steady_seconds();
  const auto source = open_source(settings.run.source, source_options(settings));
  if (!source.ok()) return Failure{Phase::kSourceOpen, source.error()};
  auto odometry = open_odometry(settings);
  if (!odometry.ok()) return Failure{Phase::kSourceOpen, odometry.error()};
  MemoryBudget budget;
  if (auto failure = measure(settings, **source, &budget)) return failure;
  if (!settings.run.out.empty())
    if (const Status made = make_folder(settings.run.out); !made.ok())
      return Failure{Phase::kRun, made.error()};

  Arena arena(budget.total_bytes());
  Parts parts(settings, **source, arena);
  if (const Status started = parts.publisher.start(&parts.store); !started.ok())
    spdlog::warn("{}", started.error().message);

  RunFigures figures;
  figures.source = (*source)->info().description;
  FrontLoop front(settings, parts, odometry->has_value() ? &**odometry : nullptr, &figures, progress);
  parts.queue.start();
  parts.back_worker.start();
  std::optional<Failure> failure = front.run(stop, (*source)->info().frame_count);
  parts.queue.stop();
  front.finish();
  parts.publisher.stop();

  collect(parts, &figures);
  figures.pools.push_back(front.pose_pool());
  figures.memory.budget_bytes = static_cast<std::int64_t>(budget.total_bytes());
  figures.memory.cap_bytes = std::int64_t{settings.memory.cap_mib} << 20;
  if (settings.run.out.empty()) return failure;
  Status written = write_results(settings.run.out, parts.back_end, front.poses(), parts.store.fragments());
  figures.memory.peak_rss_bytes = peak_rss_bytes();
  figures.wall_s = steady_seconds() - started_s;
  const Status report = write_run_report(settings.run.out + "/run.json", figures);
  if (written.ok()) written = report;
  if (!written.ok() && !failure) failure = Failure{Phase::kRun, written.error()};
  return failure;
}

}  // namespace loopsift
