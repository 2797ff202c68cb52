// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_thread.hpp"

#include <algorithm>
#include <limits>

namespace loopsift {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;
constexpr std::int64_t kMapTick_ns = 2 * kMillisecond_ns;  // between looks at the pacer while chunks wait
constexpr std::int64_t kGraphPeriod_ns = 5000 * kMillisecond_ns;  // of graphs without a new correction

Matrix6d unknown_covariance() { return Matrix6d::Constant(std::numeric_limits<double>::quiet_NaN()); }

}  // namespace

void Publisher::Impl::run() {
  while (!stopping.load()) {
    if (wanted.empty() && !graph_held_back) {
      wake.wait();
    } else {
      (void)wake.wait_until(steady_now_ns() + (wanted.empty() ? kGraphPeriod_ns / 10 : kMapTick_ns));
    }
    work();
  }
  last_words();
}

void Publisher::Impl::work() {
  const WorkSpan span(monitor);
  send_poses();
  send_loops();
  obey_requests();
  send_acks();
  send_health();
  follow_store();
  follow_graph();
  send_map();
}

void Publisher::Impl::last_words() {
  const std::int64_t until_ns = steady_now_ns() + last_words_ns.load();
  graph_epoch_sent = -1;  // the last graph goes out at once
  work();
  while (!wanted.empty() && steady_now_ns() < until_ns) {
    (void)wake.wait_until(steady_now_ns() + kMapTick_ns);
    send_map();
  }
}

void Publisher::Impl::send_poses() {
  PoseRecord pose;
  while (poses.pop(&pose)) {
    send_corrections();  // those queued before this pose go out before it
    send(pose);
  }
  send_corrections();
}

void Publisher::Impl::send_corrections() {
  while (corrections.pop(&correction)) send(correction);
}

void Publisher::Impl::send_loops() {
  LoopRecord loop;
  while (loops.pop(&loop)) {
    const auto id = static_cast<std::size_t>(loop.id);
    if (loop.id >= 0 && id < loop_table.size()) {
      for (; loop_count <= loop.id; ++loop_count) loop_table[static_cast<std::size_t>(loop_count)].id = -1;
      if (loop_table[id].id < 0) ++loops_decided;
      loop_table[id] = loop;
    }
    send(loop);
  }
}

void Publisher::Impl::send_acks() {
  AckRecord ack;
  for (RecordQueue<AckRecord>* answers : {&acks_heard, &acks_taker, &acks_back}) {
    while (answers->pop(&ack)) {
      fill(&ack_message, ack);
      ack_message.utime = wall_clock_us();
      ack_message.run = run_id;
      send(Channel::kAck, ack_message);
    }
  }
}

void Publisher::Impl::send_health() {
  RunHealth newest;
  bool any = false;
  while (health.pop(&newest)) any = true;
  if (!any) return;
  fill(&health_message, newest);
  health_message.loops_decided = loops_decided;
  health_message.graph_version = graph.newest().version;
  std::int64_t all = 0;
  for (const auto& count : sent) all += count.load(std::memory_order_relaxed);
  health_message.messages_sent = all;
  health_message.messages_failed = failed.load(std::memory_order_relaxed);
  health_message.commands_obeyed = obeyed.load(std::memory_order_relaxed);
  health_message.commands_refused = refused.load(std::memory_order_relaxed);
  health_message.paused = paused.load(std::memory_order_relaxed) ? 1 : 0;
  health_message.utime = wall_clock_us();
  health_message.run = run_id;
  send(Channel::kHealth, health_message);
}

void Publisher::Impl::obey_requests() {
  while (requests.pop(&request)) {
    bool room = true;
    for (int k = 0; k < request.window_count; ++k) {
      const ChunkWindow& window = request.windows[static_cast<std::size_t>(k)];
      if (window.object == kStateObject) {
        send_state();
      } else if (window.object == kLoopsObject) {
        room = wanted.add_all(kLoopsObject, loop_count) && room;
      } else {
        room = wanted.add(window) && room;
      }
    }
    fill(&ack_message,
         answer(request.command, room ? AckStatus::kDone : AckStatus::kRefused,
                room ? "on its way" : "too much is waiting already: ask again for what is missing"));
    ack_message.utime = wall_clock_us();
    ack_message.run = run_id;
    send(Channel::kAck, ack_message);
  }
}

void Publisher::Impl::send_state() {
  send(Channel::kUpdate, update_message);
  if (correction_message.epoch > 0) send(Channel::kCorrection, correction_message);
  if (health_message.run != 0) send(Channel::kHealth, health_message);
}

void Publisher::Impl::follow_store() {
  if (store == nullptr) return;
  const Span<const Fragment> closed = store->fragments();
  std::int32_t known = fragment_count.load(std::memory_order_relaxed);
  for (; known < static_cast<std::int32_t>(closed.size()); ++known)
    (void)wanted.add_all(known, chunk_count(closed[static_cast<std::size_t>(known)]));
  fragment_count.store(known, std::memory_order_relaxed);
}

void Publisher::Impl::follow_graph() {
  if (graph.update()) graph_held_back = true;
  if (!graph_held_back) return;
  const std::int64_t now_ns = steady_now_ns();
  const bool interrupted = wanted.remove(kGraphObject);  // chunks of an older version are of no use
  const bool corrected = graph.newest().epoch != graph_epoch_sent;
  if (!interrupted && !corrected && now_ns - graph_sent_ns < kGraphPeriod_ns) return;
  (void)wanted.add_all(kGraphObject, graph.newest().chunk_count());
  graph_epoch_sent = graph.newest().epoch;
  graph_sent_ns = now_ns;
  graph_held_back = false;
}

void Publisher::Impl::send_map() {
  std::int32_t object = 0, chunk = 0;
  while (pacer.allows(steady_now_ns()) && wanted.next(&object, &chunk))
    pacer.spend(send_chunk(object, chunk));
}

int Publisher::Impl::send_chunk(std::int32_t object, std::int32_t chunk) {
  if (object == kLoopsObject) {
    const LoopRecord& loop = loop_table[static_cast<std::size_t>(chunk)];
    if (loop.id >= 0) send(loop);
    return static_cast<int>(sizeof loop);
  }
  if (object == kGraphObject) {
    const GraphSnapshot& newest = graph.newest();
    if (newest.version == 0 || chunk >= newest.chunk_count()) return 0;
    fill(&graph_message, newest, chunk);
    graph_message.utime = newest.timestamp_ns / 1000;
    graph_message.run = run_id;
    return send(Channel::kGraph, graph_message);
  }
  const Fragment& fragment = store->fragments()[static_cast<std::size_t>(object)];
  if (chunk >= chunk_count(fragment)) return 0;
  fill(&fragment_message, fragment, chunk);
  fragment_message.run = run_id;
  return send(Channel::kFragment, fragment_message);
}

void Publisher::Impl::send(const PoseRecord& record) {
  const Se3 T_odom_body = in_body_axes(record.T_odom_camera);
  velocity.update(record.timestamp_ns, T_odom_body);
  covariance.add(record.timestamp_ns, record.T_odom_camera, record.information);
  fill(&pose_message, record.timestamp_ns, T_odom_body, velocity.value());
  send(Channel::kPoseOdom, pose_message);
  if (record.anchored) {
    fill(&pose_message, record.timestamp_ns, in_body_axes(record.T_map_odom) * T_odom_body, velocity.value());
    send(Channel::kPose, pose_message);
  }
  fill(&full_pose_message, record, record.anchored ? covariance.newest() : unknown_covariance());
  full_pose_message.captured_utime = wall_clock_us() - (steady_now_ns() - record.captured_ns) / 1000;
  full_pose_message.run = run_id;
  send(Channel::kFullPose, full_pose_message);
}

void Publisher::Impl::send(const CorrectionRecord& record) {
  covariance.correct(record.covariance_timestamp_ns, record.covariance);
  fill(&correction_message, record, record.anchored ? covariance.newest() : unknown_covariance());
  correction_message.run = run_id;
  send(Channel::kCorrection, correction_message);
  if (!record.anchored) return;
  fill(&update_message, record);
  send(Channel::kUpdate, update_message);
}

void Publisher::Impl::send(const LoopRecord& record) {
  fill(&loop_message, record);
  loop_message.run = run_id;
  send(Channel::kLoop, loop_message);
}

/// Bytes that were handed to LCM.
template <class Message>
int Publisher::Impl::send(Channel channel, const Message& message) {
  const auto index = static_cast<std::size_t>(channel);
  const int bytes = message.encode(buffer.data(), 0, static_cast<int>(buffer.size()));
  const bool ok = bytes > 0 && lcm_publish(lcm, channels[index].c_str(), buffer.data(),
                                           static_cast<unsigned int>(bytes)) == 0;
  (ok ? sent[index] : failed).fetch_add(1, std::memory_order_relaxed);
  return std::max(bytes, 0);
}

template int Publisher::Impl::send(Channel, const bot_frames::update_t&);

}  // namespace loopsift
