// SPDX-License-Identifier: MIT
// The back thread: takes closed fragments from the front thread, lets the BackEnd work on them, and hands
// corrections back. The front thread never waits for it, except where the caller asks to (rate `max`, where
// the same input must give the same output). Capacity: fragments wait in their store, so none is refused
// here; at most kCorrections corrections wait to be taken — a further one is handed over with the next
// fragment, or replaced by the next one, which says all that it said.
//
// The thread holds at most BackWorkerOptions::heap_bytes of the heap. Registrations and solves get seven
// eighths of it; one that wants more is refused, and the map stays as it is. When our own lists want more
// than all of it, or the thread is given up because it hangs, it is *disabled*: no further fragment is looked
// at, the last correction stays in force, and BackEnd is not to be read any more.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "core/base/arena.hpp"
#include "core/base/heap_watch.hpp"
#include "core/base/latency_histogram.hpp"
#include "core/base/semaphore.hpp"
#include "core/fragment/fragment_store.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/outside_loops.hpp"
#include "core/posegraph/node_covariance.hpp"
#include "firmware_app/publisher.hpp"
#include "firmware_app/record_queue.hpp"
#include "firmware_app/thread_monitor.hpp"

namespace loopsift {

struct BackWorkerOptions {
  std::int64_t heap_bytes = std::int64_t{1} << 40;  ///< of the heap, for all that the thread does
  int steps_per_fragment = 256;                     ///< of sifting, at most, before the next fragment
  bool realtime = false;             ///< a fragment that waits, or slice_s, ends the steps for the one before
  double slice_s = 0.8;              ///< from the closing of the fragment
  int max_nodes = 128;               ///< of the graph; a larger one's covariances are not known
  ThreadMonitor* monitor = nullptr;  ///< null: nobody watches
  std::function<Status()> save;      ///< writes what there is; on the back thread
};

/// What is still done once the end is asked for.
enum class Ending {
  kThorough,  ///< all that waits, then all loops once more (BackEnd::finish)
  kQuick,     ///< only what is in work
};

class BackWorker {
 public:
  static constexpr std::size_t kCorrections = 4;
  static constexpr std::size_t kSaves = 4;

  /// All must outlive this.
  BackWorker(BackEnd& back_end, const FragmentStore& store, Publisher& publisher, Arena& arena,
             const BackWorkerOptions& options = {});
  ~BackWorker();
  BackWorker(const BackWorker&) = delete;
  BackWorker& operator=(const BackWorker&) = delete;

  void start();

  // Front thread.
  /// A fragment closed with the frame of this time stamp. Never waits, never allocates.
  void submit(std::int64_t timestamp_ns);
  /// Waits until all submitted fragments are done; no longer than until the thread is disabled or a quick end
  /// is asked for.
  void wait_until_idle();
  /// The next correction, if there is one. Its epoch counts from 1; the fields about the newest pose are the
  /// caller's.
  [[nodiscard]] bool take(CorrectionRecord* correction);
  /// A thorough end, waited for.
  void finish();

  // Any thread.
  /// Asks the thread to end; a quick end may overtake a thorough one.
  void request_end(Ending ending);
  /// Whether the thread has ended: join() does not wait then.
  [[nodiscard]] bool ended() const { return ended_; }
  void join() { thread_.join(); }
  /// The command to save: obeyed between two fragments, and answered through the publisher. One thread's;
  /// false when too many wait.
  [[nodiscard]] bool request_save(const Command& command);
  /// Gives the thread up: nobody waits for it again, and what it still does has no effect. It may go on to
  /// use all that this object was given, which therefore must be kept.
  void abandon();
  [[nodiscard]] bool disabled() const { return disabled_; }
  /// Registrations and solves that were refused memory, and the bytes held.
  [[nodiscard]] const HeapFence::Figures& heap_figures() const { return heap_figures_; }
  [[nodiscard]] std::int64_t heap_limit_bytes() const { return options_.heap_bytes; }
  [[nodiscard]] std::int64_t loops_proposed() const { return loops_proposed_; }
  [[nodiscard]] std::int64_t loops_accepted() const { return loops_accepted_; }
  /// Fragments submitted and not done.
  [[nodiscard]] std::int64_t backlog() const { return submitted_ - done_; }
  /// Corrections and commands that wait. Allocates.
  [[nodiscard]] std::vector<PoolFigures> pools() const { return {corrections_.figures(), saves_.figures()}; }
  /// From the arrival of a deciding frame to its correction being ready.
  [[nodiscard]] const LatencyHistogram& correction_times() const { return correction_times_; }

 private:
  void run();
  void work_off();
  void process(std::size_t fragment);
  void take_outside_loops();
  void finish_thoroughly();
  void save_what_is_asked();
  template <class Work>
  void guarded(Work&& work);
  void announce(bool changed, std::int64_t deciding_since_ns);
  void put_covariance(CorrectionRecord* correction);
  void publish_graph(std::int32_t epoch);
  void publish_decisions(std::int64_t timestamp_ns);

  BackWorkerOptions options_;
  BackEnd& back_end_;
  const FragmentStore& store_;
  Publisher& publisher_;
  RecordQueue<CorrectionRecord> corrections_;
  RecordQueue<Command> saves_;
  NodeCovariance covariance_;  // of the back thread
  CorrectionRecord scratch_;   // of the back thread: too large for its stack
  Semaphore work_, idle_;
  std::thread thread_;
  std::atomic<std::int64_t> submitted_{0}, done_{0};
  std::atomic<std::int64_t> submitted_at_ns_{0}, newest_timestamp_ns_{0};
  std::atomic<std::int64_t> loops_proposed_{0}, loops_accepted_{0};
  std::atomic<bool> ending_{false}, quick_{false}, ended_{false}, disabled_{false};
  HeapFence::Figures heap_figures_;
  struct Announced {  // what was last published of a loop
    LoopId id;
    Decision decision = Decision::kPending;
    int revisions = 0;
    friend bool operator==(const Announced& a, const Announced& b) {
      return a.id == b.id && a.decision == b.decision && a.revisions == b.revisions;
    }
  };
  OutsideLoops outside_loops_;
  std::vector<Announced> announced_;  // by place in the list
  bool undelivered_ = false;          // scratch_ found the ring full; the front thread's after the join
  std::size_t next_ = 0;              // fragment to work on
  std::int32_t epoch_ = 0;
  LatencyHistogram correction_times_;
};

}  // namespace loopsift
