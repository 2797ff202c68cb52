// SPDX-License-Identifier: MIT
#include "firmware_app/publisher.hpp"

#include <lcm/lcm.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>

#include "core/base/semaphore.hpp"
#include "core/base/spsc_ring.hpp"
#include "firmware_app/publisher_messages.hpp"

namespace loopsift {
namespace {

constexpr std::size_t kPoseSlots = 64;        // two seconds of frames
constexpr std::size_t kCorrectionSlots = 4;   // each ~100 kB; corrections come at most once per new fragment
constexpr std::size_t kLoopSlots = 1024;      // decisions come in bursts when a list is walked again
constexpr std::size_t kBufferBytes = 65'536;  // the largest message, a full correction, is below 60 kB

/// A ring of records with its counters. publish side: push(); publish thread: pop().
template <class Record>
class RecordQueue {
 public:
  RecordQueue(const char* name, std::size_t capacity, Arena& arena)
      : name_(name), ring_(arena.carve<Record>(std::string("publisher/") + name, capacity)) {}

  bool push(const Record& record) {
    if (!ring_.try_push(record)) {
      refused_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    high_water_ = std::max(high_water_, static_cast<std::int64_t>(ring_.size()));
    return true;
  }
  bool pop(Record* record) { return ring_.try_pop(record); }
  [[nodiscard]] PoolFigures figures() const {
    return {"publisher/" + std::string(name_), static_cast<std::int64_t>(ring_.capacity()), high_water_,
            refused_.load()};
  }

 private:
  const char* name_;
  SpscRing<Record> ring_;
  std::int64_t high_water_ = 0;  // pushing thread
  std::atomic<std::int64_t> refused_{0};
};

}  // namespace

struct Publisher::Impl {
  Impl(const LcmSettings& lcm_settings, Arena& arena)
      : settings(lcm_settings),
        poses("poses", kPoseSlots, arena),
        corrections("corrections", kCorrectionSlots, arena),
        loops("loops", kLoopSlots, arena),
        buffer(arena.carve<std::byte>("publisher/buffer", kBufferBytes)),
        scratch(arena.carve<CorrectionRecord>("publisher/scratch", 1)) {
    for (std::size_t i = 0; i < channels.size(); ++i) channels[i] = settings.prefix + kChannelNames[i];
  }

  template <class Record>
  bool queue(RecordQueue<Record>& queue, const Record& record) {
    if (lcm == nullptr || !queue.push(record)) return false;
    wake.post();
    return true;
  }

  void run();
  void send_first_update();
  void send_all();
  void send_corrections();
  void send(const PoseRecord& record);
  void send(const CorrectionRecord& record);
  void send(const LoopRecord& record);
  template <class Message>
  void send(Channel channel, const Message& message);

  LcmSettings settings;
  std::array<std::string, kChannelNames.size()> channels;
  RecordQueue<PoseRecord> poses;
  RecordQueue<CorrectionRecord> corrections;
  RecordQueue<LoopRecord> loops;
  Span<std::byte> buffer;
  Span<CorrectionRecord> scratch;  // too large for a small stack

  lcm_t* lcm = nullptr;  // set before the thread starts, cleared after it ended
  std::thread thread;
  Semaphore wake;
  std::atomic<bool> stopping{false};
  std::array<std::atomic<std::int64_t>, kChannelNames.size()> sent{};
  std::atomic<std::int64_t> failed{0};

  // Publish thread only.
  BodyVelocity velocity;
  bot_core::pose_t pose_message{};
  correction_t correction_message{};
  bot_frames::update_t update_message{};
  loop_t loop_message{};
};

/// Odom lies in map as it is until the first correction; also, LCM's first publish makes a lock on the heap.
void Publisher::Impl::send_first_update() {
  scratch[0].timestamp_ns = 0;
  scratch[0].T_map_odom = Se3();
  fill(&update_message, scratch[0]);
  send(Channel::kUpdate, update_message);
}

void Publisher::Impl::run() {
  while (!stopping.load()) {
    wake.wait();
    send_all();
  }
  send_all();
}

void Publisher::Impl::send_all() {
  PoseRecord pose;
  while (poses.pop(&pose)) {
    send_corrections();  // those queued before this pose go out before it
    send(pose);
  }
  send_corrections();
  LoopRecord loop;
  while (loops.pop(&loop)) send(loop);
}

void Publisher::Impl::send_corrections() {
  while (corrections.pop(scratch.data())) send(scratch[0]);
}

void Publisher::Impl::send(const PoseRecord& record) {
  const Se3 T_odom_body = in_body_axes(record.T_odom_camera);
  velocity.update(record.timestamp_ns, T_odom_body);
  fill(&pose_message, record.timestamp_ns, T_odom_body, velocity.value());
  send(Channel::kPoseOdom, pose_message);
  fill(&pose_message, record.timestamp_ns, in_body_axes(record.T_map_odom) * T_odom_body, velocity.value());
  send(Channel::kPose, pose_message);
}

void Publisher::Impl::send(const CorrectionRecord& record) {
  fill(&correction_message, record);
  send(Channel::kCorrection, correction_message);
  fill(&update_message, record);
  send(Channel::kUpdate, update_message);
}

void Publisher::Impl::send(const LoopRecord& record) {
  fill(&loop_message, record);
  send(Channel::kLoop, loop_message);
}

template <class Message>
void Publisher::Impl::send(Channel channel, const Message& message) {
  const auto index = static_cast<std::size_t>(channel);
  const int bytes = message.encode(buffer.data(), 0, static_cast<int>(buffer.size()));
  const bool ok = bytes > 0 && lcm_publish(lcm, channels[index].c_str(), buffer.data(),
                                           static_cast<unsigned int>(bytes)) == 0;
  (ok ? sent[index] : failed).fetch_add(1, std::memory_order_relaxed);
}

Publisher::Publisher(const LcmSettings& settings, Arena& arena)
    : impl_(std::make_unique<Impl>(settings, arena)) {}

Publisher::~Publisher() { stop(); }

Status Publisher::start() {
  Impl& p = *impl_;
  if (!p.settings.enabled) return {};
  reserve(&p.correction_message);
  reserve(&p.update_message);
  reserve(&p.loop_message);
  p.lcm = lcm_create(p.settings.url.c_str());
  if (p.lcm == nullptr)
    return Error{
        ErrorCode::kIo,
        "LCM cannot be opened at " + p.settings.url +
            "; nothing is published. For udpm:// a multicast route is needed: ip link set lo multicast on; "
            "ip route add 224.0.0.0/4 dev lo. For another provider set lcm.url; to do without set "
            "lcm.enabled = false"};
  p.send_first_update();
  p.thread = std::thread([&p] { p.run(); });
  return {};
}

void Publisher::stop() {
  Impl& p = *impl_;
  if (p.lcm == nullptr) return;
  p.stopping = true;
  p.wake.post();
  p.thread.join();
  lcm_destroy(p.lcm);
  p.lcm = nullptr;
}

bool Publisher::running() const { return impl_->lcm != nullptr; }
bool Publisher::publish(const PoseRecord& record) { return impl_->queue(impl_->poses, record); }
bool Publisher::publish(const CorrectionRecord& record) { return impl_->queue(impl_->corrections, record); }
bool Publisher::publish(const LoopRecord& record) { return impl_->queue(impl_->loops, record); }

std::int64_t Publisher::sent(Channel channel) const {
  return impl_->sent[static_cast<std::size_t>(channel)].load();
}
std::int64_t Publisher::failed() const { return impl_->failed.load(); }

std::vector<PoolFigures> Publisher::pools() const {
  return {impl_->poses.figures(), impl_->corrections.figures(), impl_->loops.figures()};
}

}  // namespace loopsift
