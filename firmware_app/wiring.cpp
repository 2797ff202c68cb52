// SPDX-License-Identifier: MIT
#include "firmware_app/wiring.hpp"

#include <spdlog/spdlog.h>

#include <memory>
#include <string>
#include <utility>

#include "core/base/steady_time.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/given_odometry.hpp"
#include "firmware_app/memory_plan.hpp"
#include "firmware_app/realtime.hpp"
#include "firmware_app/run.hpp"
#include "firmware_app/supervised_source.hpp"

namespace loopsift {
namespace {

constexpr const char* kUsualSource = "synth:room";  // 640×480 with colour

}  // namespace

std::optional<Failure> plan_memory(const Settings& settings, MemoryBudget* budget) {
  load_program_code();
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
  const double started_s = static_cast<double>(steady_now_ns()) * 1e-9;
  limit_stacks();
  load_program_code();
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
