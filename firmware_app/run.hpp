// SPDX-License-Identifier: MIT
// One run: its threads, from their start to their end. Thread: main.
#pragma once
#include <memory>
#include <optional>
#include <thread>

#include "core/base/arena.hpp"
#include "core/base/semaphore.hpp"
#include "firmware_app/failure.hpp"
#include "firmware_app/memory_plan.hpp"
#include "firmware_app/progress.hpp"
#include "firmware_app/run_control.hpp"
#include "firmware_app/run_parts.hpp"
#include "firmware_app/supervisor.hpp"

namespace loopsift {

/// One run, from its threads' start to its results. On the heap: what a thread that hangs still uses is left
/// where it is.
class Run {
 public:
  Run(const Settings& settings, std::unique_ptr<SupervisedSource> source,
      std::unique_ptr<ExternalOdometry> given, const MemoryPlan& plan);

  /// Before go(), where the settings want a recording.
  [[nodiscard]] Status start_recording() { return parts_.recorder.start(); }
  /// Until the source ends, is lost, or `control` says so, and all threads have ended.
  std::optional<Failure> go(RunControl& control, Progress& progress);
  /// Everything found, to settings.run.out. started_s: when the run began, on the steady clock.
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

}  // namespace loopsift
