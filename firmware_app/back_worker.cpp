// SPDX-License-Identifier: MIT
#include "firmware_app/back_worker.hpp"

#include <algorithm>
#include <cstring>
#include <new>

#include <spdlog/spdlog.h>

#include "core/base/steady_time.hpp"
#include "core/pipeline/results.hpp"

namespace loopsift {
namespace {

constexpr int kBlocksPerNode = 4;  // of the graph's factor: one of the odometry, the rest of loops and fill

LoopDecision to_message(Decision decision) {
  switch (decision) {
    case Decision::kAccepted:
      return LoopDecision::kAccepted;
    case Decision::kRevoked:
      return LoopDecision::kRevoked;
    case Decision::kPending:
    case Decision::kRejected:
      break;
  }
  return LoopDecision::kRejected;
}

LoopRecord to_message(const SiftedLoop& sifted, std::int64_t timestamp_ns) {
  LoopRecord record;
  record.timestamp_ns = timestamp_ns;
  record.id = sifted.loop.id.value;
  record.fragment_i = sifted.loop.i.value;
  record.fragment_j = sifted.loop.j.value;
  record.T_i_j = sifted.loop.T_i_j;
  record.single_dmp = sifted.single_score;
  record.rank = sifted.rank;
  if (sifted.rank >= 0) {
    record.tested_dmp = sifted.tested_score;
    record.best_dmp_before = sifted.best_score_before;
  }
  record.decision = to_message(sifted.decision);
  std::strncpy(record.reason.data(), to_string(sifted.reason), record.reason.size() - 1);
  record.frame_decided = sifted.frame_decided;
  return record;
}

}  // namespace

BackWorker::BackWorker(BackEnd& back_end, const FragmentStore& store, Publisher& publisher, Arena& arena,
                       const BackWorkerOptions& options)
    : options_(options),
      back_end_(back_end),
      store_(store),
      publisher_(publisher),
      corrections_("back/corrections", kCorrections, arena),
      saves_("back/saves", kSaves, arena),
      covariance_(&arena, options.max_nodes, kBlocksPerNode * options.max_nodes) {
  back_end_.stop_on(&quick_);
}

BackWorker::~BackWorker() {
  if (thread_.joinable()) finish();
}

void BackWorker::start() {
  thread_ = std::thread([this] {
    const ThreadTenure tenure(options_.monitor);
    run();
  });
}

void BackWorker::submit(std::int64_t timestamp_ns) {
  newest_timestamp_ns_ = timestamp_ns;
  submitted_at_ns_ = steady_now_ns();
  ++submitted_;
  work_.post();
}

void BackWorker::wait_until_idle() {
  while (backlog() > 0 && !disabled_ && !quick_) idle_.wait();
}

bool BackWorker::take(CorrectionRecord* correction) {
  if (corrections_.pop(correction)) return true;
  if (thread_.joinable() || !undelivered_) return false;
  *correction = scratch_;  // the last word, which found the ring full
  undelivered_ = false;
  return true;
}

void BackWorker::finish() {
  request_end(Ending::kThorough);
  join();
}

void BackWorker::request_end(Ending ending) {
  if (ending == Ending::kQuick) quick_ = true;
  ending_ = true;
  work_.post();
  idle_.post();
}

bool BackWorker::request_save(const Command& command) {
  if (disabled_ || !saves_.push(command)) return false;
  work_.post();
  return true;
}

void BackWorker::abandon() {
  disabled_ = true;
  idle_.post();
}

void BackWorker::run() {
  {
    const HeapFence fence(options_.heap_bytes, options_.heap_bytes / 8 * 7, &heap_figures_);
    while (!disabled_) {
      work_.wait();
      save_what_is_asked();
      work_off();
      save_what_is_asked();
      if (ending_ && (quick_ || next_ >= static_cast<std::size_t>(submitted_.load()))) break;
    }
    if (!quick_) finish_thoroughly();
  }
  idle_.post();
  ended_ = true;
}

void BackWorker::work_off() {
  while (next_ < static_cast<std::size_t>(submitted_.load()) && !disabled_ && !quick_) process(next_++);
}

/// Past the fence's end there is no telling what BackEnd had half done: the thread disables itself.
template <class Work>
void BackWorker::guarded(Work&& work) {
  try {
    const WorkSpan span(options_.monitor);
    work();
  } catch (const std::bad_alloc&) {
    disabled_ = true;
  }
}

// Sifting goes on until there is nothing left to do or its share for one fragment is used up; in real time
// also until a slice of time is over, the next fragment waits, or the run ends and all loops are sifted once
// more. What is left then is done with the next fragment, or at the end. A correction leaves as soon as it is
// there.
void BackWorker::process(std::size_t fragment) {
  const std::int64_t since_ns = submitted_at_ns_;
  const std::int64_t slice_end_ns = since_ns + static_cast<std::int64_t>(options_.slice_s * 1e9);
  guarded([&] { (void)back_end_.add_fragment(store_.fragments()[fragment]); });
  take_outside_loops();
  bool more = true;
  for (int k = 0; k < options_.steps_per_fragment && more && !disabled_ && !quick_; ++k) {
    guarded([&] {
      const int before = back_end_.sifter().epoch();
      more = back_end_.work(1);
      if (back_end_.sifter().epoch() != before && !disabled_) announce(true, since_ns);
    });
    if (options_.realtime && (backlog() > 1 || ending_ || steady_now_ns() > slice_end_ns)) break;
  }
  guarded([&] {
    loops_proposed_ = static_cast<std::int64_t>(back_end_.sifter().records().size());
    if (!disabled_) announce(false, since_ns);
  });
  ++done_;
  idle_.post();
}

// Loops of other programs wait in the publisher until a fragment closes.
void BackWorker::take_outside_loops() {
  if (disabled_) return;
  guarded([&] {
    OutsideLoop loop;
    while (publisher_.take(&loop)) outside_loops_.add(loop);
    const std::vector<Loop> loops = outside_loops_.resolve(
        store_.fragments().first(static_cast<std::size_t>(back_end_.fragment_count())));
    if (!loops.empty()) back_end_.add_loops({loops.data(), loops.size()});
  });
}

void BackWorker::save_what_is_asked() {
  Command command;
  while (!disabled_ && saves_.pop(&command)) {
    const WorkSpan span(options_.monitor);
    Status saved = Error{ErrorCode::kCapacity, "not enough memory left for it (memory.back_heap_mib)"};
    if (!options_.save) {
      saved = Error{ErrorCode::kUsage, "the run was started without a folder for results (--out)"};
    } else if (Status written; within_fence([&] { written = options_.save(); })) {
      saved = written;
    }
    publisher_.acknowledge(Publisher::AckFrom::kBack,
                           saved.ok() ? answer(command, AckStatus::kDone, "saved")
                                      : answer(command, AckStatus::kRefused, saved.error().message.c_str()));
  }
}

void BackWorker::finish_thoroughly() {
  take_outside_loops();
  if (disabled_) return;
  if (outside_loops_.left_out() > 0)
    spdlog::warn("{} loops of other programs fit no two pieces of the map", outside_loops_.left_out());
  if (back_end_.registrations_refused() > 0)
    spdlog::warn(
        "{} times a fragment was not registered to all that it could have been: memory ran out "
        "(memory.back_heap_mib)",
        back_end_.registrations_refused());
  const auto go_on = [this] {
    if (options_.monitor != nullptr) options_.monitor->get_on(steady_now_ns());
    return !quick_ && !disabled_;
  };
  guarded([&] {
    if (!back_end_.finish(go_on))
      spdlog::warn("sifting all loops once more {}: {} loops were not decided, and the map stays as it was",
                   quick_ ? "was broken off" : "ran past sifter.finish_limit_s",
                   back_end_.sifter().unfinished());
    if (!disabled_) announce(true, steady_now_ns());
  });
}

void BackWorker::announce(bool changed, std::int64_t deciding_since_ns) {
  loops_accepted_ = static_cast<std::int64_t>(back_end_.sifter().accepted().size());
  publish_decisions(newest_timestamp_ns_);
  publish_graph(epoch_ + (changed ? 1 : 0));
  if (!changed) {
    if (undelivered_) undelivered_ = !corrections_.push(scratch_);
    return;
  }
  scratch_.epoch = ++epoch_;
  scratch_.frame_decided = back_end_.sifter().newest_frame();
  scratch_.T_map_odom = back_end_.T_map_odom();
  scratch_.piece = back_end_.piece().value;
  scratch_.anchored = back_end_.anchored();
  put_covariance(&scratch_);
  undelivered_ = !corrections_.push(scratch_);
  correction_times_.record_ns(steady_now_ns() - deciding_since_ns);
}

/// Of the newest keyframe; what came after it is the publisher's to add.
void BackWorker::put_covariance(CorrectionRecord* correction) {
  const PoseGraph graph = back_end_.sifter().graph();
  const int newest = static_cast<int>(graph.nodes.size()) - 1;
  Matrix6d covariance;
  const bool known = covariance_.compute(graph, newest, &covariance);
  correction->covariance = known ? covariance : CorrectionRecord().covariance;
  correction->covariance_timestamp_ns = newest >= 0 ? graph.nodes.back().timestamp_ns : 0;
}

void BackWorker::publish_graph(std::int32_t epoch) {
  if (!publisher_.running() || back_end_.fragment_count() == 0) return;
  const Span<const Fragment> fragments = store_.fragments();
  const std::vector<Se3> poses = map_poses(back_end_, fragments);
  publisher_.publish(back_end_.sifter().graph(), fragments, poses, newest_timestamp_ns_, epoch);
}

void BackWorker::publish_decisions(std::int64_t timestamp_ns) {
  const Span<const SiftedLoop> records = back_end_.sifter().records();
  announced_.resize(records.size());
  for (std::size_t k = 0; k < records.size(); ++k) {
    const SiftedLoop& record = records[k];
    const Announced now{record.loop.id, record.decision, record.revisions};
    if (record.decision == Decision::kPending || now == announced_[k]) continue;
    announced_[k] = now;
    (void)publisher_.publish(to_message(record, timestamp_ns));
  }
  SiftedLoop dropped;
  while (back_end_.sifter().take_dropped(&dropped)) {
    LoopRecord message = to_message(dropped, timestamp_ns);
    message.decision = LoopDecision::kDropped;
    std::strncpy(message.reason.data(), "no place for it (sifter.max_loops)", message.reason.size() - 1);
    message.frame_decided = back_end_.sifter().newest_frame();
    (void)publisher_.publish(message);
  }
}

}  // namespace loopsift
