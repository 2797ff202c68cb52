// SPDX-License-Identifier: MIT
// The parts of a run and how they are joined. All that takes memory lives in the arena: made once without one
// to measure it (memory_plan.hpp), once more for the run. Thread: main makes them; each part says whose it is
// then.
#pragma once
#include <cstddef>
#include <string>

#include "core/base/arena.hpp"
#include "core/fragment/front_end.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/run_figures.hpp"
#include "drivers/decode_ahead.hpp"
#include "firmware_app/back_worker.hpp"
#include "firmware_app/front_loop.hpp"
#include "firmware_app/given_odometry.hpp"
#include "firmware_app/publisher.hpp"
#include "firmware_app/recorder.hpp"
#include "firmware_app/settings.hpp"
#include "firmware_app/supervised_source.hpp"
#include "firmware_app/thread_monitor.hpp"
#include "firmware_app/watched_source.hpp"

namespace loopsift {

constexpr std::size_t mebibytes(int count) { return static_cast<std::size_t>(count) << 20; }

/// Makes a folder for results, and those above it.
[[nodiscard]] Status make_folder(const std::string& path);

/// What every thread may look at: outside the arena, there before it.
struct Shared {
  RunFigures figures;
  ThreadMonitors monitors{ThreadMonitor(ThreadRole::kCapture), ThreadMonitor(ThreadRole::kFront),
                          ThreadMonitor(ThreadRole::kBack), ThreadMonitor(ThreadRole::kPublish)};
  ThreadMonitor& operator[](ThreadRole role) { return monitors[static_cast<std::size_t>(role)]; }
};

/// Everything that lives in the arena.
struct Parts {
  /// All must outlive this. given: null where the odometry is the built-in one.
  Parts(const Settings& settings, SupervisedSource& frame_source, ExternalOdometry* given, Shared& shared,
        Arena& arena);
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;

  FrameRecorder recorder;
  WatchedSource source;
  FrameQueue queue;
  Publisher publisher;
  FragmentStore store;
  FrontEnd front_end;
  BackEnd back_end;
  BackWorker back_worker;
  FrontLoop front;

 private:
  BackWorkerOptions back_worker_options(const Settings& settings, Shared& shared);
  /// What there is by now. Back thread.
  [[nodiscard]] Status save(const std::string& to) const;
};

}  // namespace loopsift
