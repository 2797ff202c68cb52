// SPDX-License-Identifier: MIT
// The main thread's work while the others run: watches over them, gives up a back thread that hangs, tells
// the person, the service manager and, once a second, all subscribers how the run feels. Touches none of the
// others' locks, because there are none. Allocates.
#pragma once
#include <vector>

#include "core/fragment/fragment_store.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/run_figures.hpp"
#include "drivers/decode_ahead.hpp"
#include "firmware_app/back_worker.hpp"
#include "firmware_app/front_loop.hpp"
#include "firmware_app/progress.hpp"
#include "firmware_app/run_health.hpp"
#include "firmware_app/service_manager.hpp"
#include "firmware_app/settings.hpp"
#include "firmware_app/thread_monitor.hpp"
#include "firmware_app/watched_source.hpp"

namespace loopsift {

/// The store's pools; the first one's `refused` counts for all, since a fragment is refused as a whole. Any
/// thread.
[[nodiscard]] std::vector<PoolFigures> store_pools(const FragmentStore& store);

class Supervisor {
 public:
  /// What it looks at; all must outlive it.
  struct View {
    const WatchedSource& source;
    const FrameQueue& queue;
    FrontLoop& front;
    BackWorker& back_worker;
    Publisher& publisher;
    RunControl& control;
    const FragmentStore& store;
    const BackEnd& back_end;
    const RunFigures& figures;
    const ThreadMonitors& monitors;
    std::int64_t frame_count = -1;  ///< of the whole source; −1: not known
    std::int64_t budget_bytes = 0;
  };
  static constexpr std::int64_t kTick_ns = 100'000'000;  ///< how often tick() wants to be called

  Supervisor(const Settings& settings, View view, Progress& progress);

  /// All threads run.
  void ready();
  /// A look at everything.
  void tick();
  /// The source has ended, or a stop was asked for.
  void finishing();
  /// The threads have ended.
  void ended();
  [[nodiscard]] RunState state(std::int64_t now_ns) const;

 private:
  void tell_notes();
  void obey_commands();
  [[nodiscard]] AckRecord obey(const Command& command);
  void watch(std::int64_t now_ns);
  [[nodiscard]] RunHealth health(std::int64_t now_ns) const;
  void fill_latency(RunHealth* health) const;
  void fill_pools(RunHealth* health) const;
  [[nodiscard]] ProgressState progress_state(std::int64_t now_ns) const;

  const Settings& settings_;
  View view_;
  Progress& progress_;
  ServiceManager service_;
  std::int64_t started_ns_;
  std::int64_t back_at_work_ns_;  // the back thread was last seen at work, or without any
  std::int64_t health_told_ns_ = 0;
  RunState told_state_ = RunState::kStarting;
  bool finishing_ = false, front_hang_told_ = false, back_end_told_ = false;
};

}  // namespace loopsift
