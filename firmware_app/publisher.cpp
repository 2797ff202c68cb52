// SPDX-License-Identifier: MIT
#include "firmware_app/publisher.hpp"

#include <algorithm>
#include <chrono>

#include "firmware_app/publisher_thread.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kPoseSlots = 64;        // two seconds of frames
constexpr std::size_t kCorrectionSlots = 16;  // corrections come at most once per new fragment
constexpr std::size_t kLoopSlots = 1024;      // decisions come in bursts when a list is walked again
constexpr std::size_t kHealthSlots = 4;       // one a second
constexpr std::size_t kRequestSlots = 16;     // a subscriber waits for what it asked for
constexpr std::size_t kCommandSlots = 16;
constexpr std::size_t kLoopInSlots = 64;  // until the next fragment closes
constexpr std::size_t kAckSlots = 32;
constexpr std::size_t kBufferBytes = 65'536;  // the largest message, a chunk of the map, is about 8 kB

}  // namespace

std::int64_t wall_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

Publisher::Impl::Impl(const LcmSettings& lcm_settings, Arena& arena, const GraphLimits& limits)
    : settings(lcm_settings),
      poses("publisher/poses", kPoseSlots, arena),
      corrections("publisher/corrections", kCorrectionSlots, arena),
      loops("publisher/loops", kLoopSlots, arena),
      health("publisher/health", kHealthSlots, arena),
      requests("publisher/requests", kRequestSlots, arena),
      commands("publisher/commands", kCommandSlots, arena),
      loops_in("publisher/loops in", kLoopInSlots, arena),
      acks_heard("publisher/answers", kAckSlots, arena),
      acks_taker("publisher/answers taker", kAckSlots, arena),
      acks_back("publisher/answers back", kAckSlots, arena),
      graph(limits, arena),
      buffer(arena.carve<std::byte>("publisher/buffer", kBufferBytes)),
      loop_table(arena.carve<LoopRecord>("publisher/loop table", kLoopTable)),
      pacer(lcm_settings.map_rate_mib_s * 1024 * 1024) {
  for (std::size_t i = 0; i < channels.size(); ++i) channels[i] = settings.prefix + kChannelNames[i];
}

/// Odom lies in map as it is until the first correction; also, LCM's first publish makes a lock on the heap.
void Publisher::Impl::send_first_update() {
  fill(&update_message, CorrectionRecord{});
  send(Channel::kUpdate, update_message);
}

Publisher::Publisher(const LcmSettings& settings, Arena& arena, const GraphLimits& limits)
    : impl_(std::make_unique<Impl>(settings, arena, limits)) {}

Publisher::~Publisher() { stop(); }

Status Publisher::start(const FragmentStore* store, ThreadMonitor* monitor) {
  Impl& p = *impl_;
  if (!p.settings.enabled) return {};
  reserve(&p.update_message);
  reserve(&p.loop_message);
  reserve(&p.ack_message);
  p.store = store;
  p.monitor = monitor;
  p.run_id = wall_clock_us();
  p.gate = CommandGate(p.run_id, static_cast<std::int64_t>(p.settings.max_command_age_s * 1e6));
  p.lcm = lcm_create(p.settings.url.c_str());
  if (p.lcm == nullptr)
    return Error{
        ErrorCode::kIo,
        "LCM cannot be opened at " + p.settings.url +
            "; nothing is published. For udpm:// a multicast route is needed: ip link set lo multicast on; "
            "ip route add 224.0.0.0/4 dev lo. For another provider set lcm.url; to do without set "
            "lcm.enabled = false"};
  p.send_first_update();
  p.listen();
  p.publish_thread = std::thread([&p] {
    ThreadTenure tenure(p.monitor);
    tenure.seal_heap();
    p.run();
  });
  return {};
}

void Publisher::stop(std::int64_t last_words_ns) {
  Impl& p = *impl_;
  p.last_words_ns = last_words_ns;
  if (p.lcm == nullptr) return;
  p.deaf = true;
  if (p.listen_thread.joinable()) p.listen_thread.join();
  p.stopping = true;
  p.wake.post();
  p.publish_thread.join();
  lcm_destroy(p.lcm);
  p.lcm = nullptr;
}

bool Publisher::running() const { return impl_->lcm != nullptr; }
bool Publisher::publish(const PoseRecord& record) { return impl_->queue(impl_->poses, record); }
bool Publisher::publish(const CorrectionRecord& record) { return impl_->queue(impl_->corrections, record); }
bool Publisher::publish(const LoopRecord& record) { return impl_->queue(impl_->loops, record); }
bool Publisher::publish(const RunHealth& health) { return impl_->queue(impl_->health, health); }

void Publisher::publish(const PoseGraph& graph, Span<const Fragment> fragments,
                        Span<const Se3> T_map_fragment, std::int64_t timestamp_ns, std::int32_t epoch) {
  if (impl_->lcm == nullptr) return;
  impl_->graph.put(graph, fragments, T_map_fragment, timestamp_ns, epoch);
  impl_->wake.post();
}

bool Publisher::take(Command* command) { return impl_->commands.pop(command); }

bool Publisher::take(OutsideLoop* loop) { return impl_->loops_in.pop(loop); }

void Publisher::acknowledge(AckFrom from, const AckRecord& record) {
  impl_->queue(from == AckFrom::kBack ? impl_->acks_back : impl_->acks_taker, record);
}

void Publisher::set_paused(bool paused) { impl_->paused = paused; }

std::int64_t Publisher::sent(Channel channel) const {
  return impl_->sent[static_cast<std::size_t>(channel)].load();
}
std::int64_t Publisher::failed() const { return impl_->failed.load(); }
std::int64_t Publisher::commands_obeyed() const { return impl_->obeyed.load(); }
std::int64_t Publisher::commands_refused() const { return impl_->refused.load(); }

std::vector<PoolFigures> Publisher::pools() const {
  const Impl& p = *impl_;
  return {p.poses.figures(),    p.corrections.figures(), p.loops.figures(), p.requests.figures(),
          p.commands.figures(), p.loops_in.figures(),    p.graph.figures()};
}

}  // namespace loopsift
