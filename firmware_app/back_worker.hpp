// SPDX-License-Identifier: MIT
// The back thread: takes closed fragments from the front thread, lets the BackEnd work on them, and hands
// corrections back. The front thread never waits for it, except where the caller asks to (rate `max`, where
// the same input must give the same output). Capacity: fragments wait in their store, so none is refused
// here; at most kCorrections corrections wait to be taken — a further one is left out, as the next one says
// all that it said.
#pragma once
#include <atomic>
#include <cstdint>
#include <thread>

#include "core/base/arena.hpp"
#include "core/base/latency_histogram.hpp"
#include "core/base/semaphore.hpp"
#include "core/base/spsc_ring.hpp"
#include "core/fragment/fragment_store.hpp"
#include "core/pipeline/back_end.hpp"
#include "firmware_app/publisher.hpp"

namespace loopsift {

class BackWorker {
 public:
  static constexpr std::size_t kCorrections = 4;

  /// All must outlive this.
  BackWorker(BackEnd& back_end, const FragmentStore& store, Publisher& publisher, Arena& arena);
  ~BackWorker();
  BackWorker(const BackWorker&) = delete;
  BackWorker& operator=(const BackWorker&) = delete;

  void start();

  // Front thread.
  /// A fragment closed with the frame of this time stamp. Never waits, never allocates.
  void submit(std::int64_t timestamp_ns);
  /// Waits until all submitted fragments are done.
  void wait_until_idle();
  /// The next correction, if there is one. Its epoch counts from 1; the fields about the newest pose are the
  /// caller's.
  [[nodiscard]] bool take(CorrectionRecord* correction);
  /// Works off what is submitted, sifts all loops once more (BackEnd::finish) and ends the thread.
  void finish();

  // Any thread.
  [[nodiscard]] std::int64_t loops_proposed() const { return loops_proposed_; }
  [[nodiscard]] std::int64_t loops_accepted() const { return loops_accepted_; }
  /// Fragments submitted and not done.
  [[nodiscard]] std::int64_t backlog() const { return submitted_ - done_; }
  /// From the arrival of a deciding frame to its correction being ready. After finish().
  [[nodiscard]] const LatencyHistogram& correction_times() const { return correction_times_; }

 private:
  void run();
  void process(std::size_t fragment);
  void announce(bool changed, std::int64_t deciding_since_ns);
  void publish_graph(std::int32_t epoch);
  void publish_decisions(std::int64_t timestamp_ns);

  BackEnd& back_end_;
  const FragmentStore& store_;
  Publisher& publisher_;
  SpscRing<CorrectionRecord> corrections_;
  CorrectionRecord scratch_;  // of the back thread: too large for its stack
  Semaphore work_, idle_;
  std::thread thread_;
  std::atomic<std::int64_t> submitted_{0}, done_{0};
  std::atomic<std::int64_t> submitted_at_ns_{0}, newest_timestamp_ns_{0};
  std::atomic<std::int64_t> loops_proposed_{0}, loops_accepted_{0};
  std::atomic<bool> finishing_{false};
  std::vector<Decision> announced_;  // last published decision of each loop
  bool undelivered_ = false;         // scratch_ found the ring full; read by the front thread after the join
  std::int32_t epoch_ = 0;
  LatencyHistogram correction_times_;
};

}  // namespace loopsift
