// SPDX-License-Identifier: MIT
#include "firmware_app/wiring.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "core/base/arena.hpp"
#include "core/pipeline/run_figures.hpp"
#include "core/pipeline/run_report.hpp"
#include "drivers/decode_ahead.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/publisher.hpp"

namespace loopsift {
namespace {

constexpr int kReadTimeout_ms = 100;
constexpr const char* kUsualSource = "synth:room";  // 640×480 with colour

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

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

/// Everything that lives in the arena, made once to measure and once for the run.
struct Parts {
  Parts(const Settings& settings, FrameSource& source, Arena& arena)
      : queue(source, queue_options(settings), arena), publisher(settings.lcm, arena) {}
  FrameQueue queue;
  Publisher publisher;
};

std::optional<Failure> measure(const Settings& settings, FrameSource& source, MemoryBudget* budget) {
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

/// Takes frames until the end, loss or `stop`.
std::optional<Failure> take_all(FrameQueue& queue, const std::atomic<bool>& stop, std::int64_t frame_count,
                                RunFigures* figures, Progress* progress) {
  ProgressState state;
  state.frame_count = frame_count;
  std::optional<Failure> failure;
  std::int64_t first_ns = 0;
  bool reading = true;
  while (reading && !stop) {
    RawFrame* frame = nullptr;
    switch (queue.next(&frame, kReadTimeout_ms)) {
      case ReadStatus::kFrame:
        if (state.frames++ == 0) first_ns = frame->timestamp_ns;
        figures->sequence_duration_s = static_cast<double>(frame->timestamp_ns - first_ns) * 1e-9;
        queue.release(frame);
        break;
      case ReadStatus::kBad:
        spdlog::warn("frame skipped: {}", queue.message());
        break;
      case ReadStatus::kTimeout:
        break;
      case ReadStatus::kEnd:
        reading = false;
        break;
      case ReadStatus::kLost:
        failure = Failure{Phase::kSourceRead,
                          {ErrorCode::kIo, "the source was lost: " + std::string(queue.message())}};
        reading = false;
        break;
    }
    progress->update(state, steady_seconds());
  }
  progress->finish(state, steady_seconds());
  const FrameQueueCounts counts = queue.counts();
  figures->frames.received = counts.received + counts.bad;
  figures->frames.dropped = counts.dropped + counts.bad;
  return failure;
}

Status make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, path + ": the folder for the results cannot be made: " + error.message()};
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
  MemoryBudget budget;
  if (auto failure = measure(settings, **source, &budget)) return failure;
  if (!settings.run.out.empty())
    if (const Status made = make_folder(settings.run.out); !made.ok())
      return Failure{Phase::kRun, made.error()};

  Arena arena(budget.total_bytes());
  Parts parts(settings, **source, arena);
  if (const Status started = parts.publisher.start(); !started.ok())
    spdlog::warn("{}", started.error().message);

  RunFigures figures;
  figures.source = (*source)->info().description;
  parts.queue.start();
  std::optional<Failure> failure =
      take_all(parts.queue, stop, (*source)->info().frame_count, &figures, progress);
  parts.queue.stop();
  parts.publisher.stop();

  figures.wall_s = steady_seconds() - started_s;
  figures.memory.budget_bytes = static_cast<std::int64_t>(budget.total_bytes());
  figures.memory.cap_bytes = std::int64_t{settings.memory.cap_mib} << 20;
  figures.memory.peak_rss_bytes = peak_rss_bytes();
  figures.pools = parts.publisher.pools();
  if (settings.run.out.empty()) return failure;
  const Status written = write_run_report(settings.run.out + "/run.json", figures);
  if (!written.ok() && !failure) failure = Failure{Phase::kRun, written.error()};
  return failure;
}

}  // namespace loopsift
