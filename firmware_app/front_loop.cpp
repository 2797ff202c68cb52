// SPDX-License-Identifier: MIT
#include "firmware_app/front_loop.hpp"

#include <cstdio>
#include <cstring>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

constexpr int kReadTimeout_ms = 100;

template <class T>
void count(std::atomic<T>* counter) {  // one thread writes
  counter->store(counter->load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

}  // namespace

FrontLoop::FrontLoop(const Parts& parts, const SlewOptions& slew, bool lockstep, std::size_t max_poses,
                     RunFigures* figures, Arena& arena)
    : parts_(parts),
      lockstep_(lockstep),
      figures_(*figures),
      poses_(arena.carve<OdometryPose>("pipeline/poses", max_poses)),
      notes_("pipeline/notes", kNotes, arena),
      slew_(slew) {}

ReadStatus FrontLoop::run(const RunControl& control, ThreadMonitor* monitor, ThreadTenure* tenure) {
  while (!control.stop && !control.finish) {
    RawFrame* frame = nullptr;
    const ReadStatus status = parts_.queue.next(&frame, kReadTimeout_ms);
    switch (status) {
      case ReadStatus::kFrame:
        if (!control.paused) take(*frame, monitor);
        parts_.queue.release(frame);
        tenure->seal_heap();
        break;
      case ReadStatus::kBad:
        note_skipped();
        break;
      case ReadStatus::kTimeout:
        break;
      case ReadStatus::kEnd:
      case ReadStatus::kLost:
        return status;
    }
  }
  return ReadStatus::kTimeout;
}

void FrontLoop::take(const RawFrame& raw, ThreadMonitor* monitor) {
  const std::int64_t start_ns = steady_now_ns();
  const Fragment* closed = nullptr;
  {
    const WorkSpan span(monitor);
    const FrontEndResult result =
        parts_.given == nullptr
            ? parts_.front_end.process(raw)
            : parts_.front_end.process(
                  raw,
                  parts_.given->track(FrameId{static_cast<std::int32_t>(raw.sequence)}, raw.timestamp_ns));
    closed = result.closed;
    apply_corrections();
    const bool lost = result.tracking.status == TrackingStatus::kLost;
    if (result.tracking.status == TrackingStatus::kFirst) begin_piece(result.frame);
    if (!lost) keep(result, raw.captured_ns > 0 ? raw.captured_ns : start_ns);
    if (lost) status_.lost_reason = result.tracking.reason;
    count(lost ? &status_.lost : &status_.tracked);
    note_state(result);
    status_.newest_lost = lost;
    note_times(result, start_ns, raw);
  }
  if (closed != nullptr) hand_over(raw.timestamp_ns);
  if (status_.frames == 0) first_timestamp_ns_ = raw.timestamp_ns;
  last_timestamp_ns_ = raw.timestamp_ns;
  status_.newest_timestamp_ns = raw.timestamp_ns;
  figures_.sequence_duration_s = static_cast<double>(last_timestamp_ns_ - first_timestamp_ns_) * 1e-9;
  count(&status_.frames);
}

void FrontLoop::keep(const FrontEndResult& result, std::int64_t captured_ns) {
  T_odom_camera_ = result.tracking.T_odom_camera;
  const double dt_s = 1e-9 * static_cast<double>(result.timestamp_ns - last_timestamp_ns_);
  const Se3& T_map_odom = slew_.follow(T_map_odom_, T_odom_camera_, status_.frames == 0 ? 0.0 : dt_s);
  const std::size_t n = status_.poses.load(std::memory_order_relaxed);
  if (n < poses_.size()) {
    poses_[n] = {result.timestamp_ns, T_odom_camera_};
    status_.poses.store(n + 1, std::memory_order_release);
  } else {
    count(&status_.poses_refused);
  }
  (void)parts_.publisher.publish(PoseRecord{result.timestamp_ns, T_odom_camera_, T_map_odom, status_.epoch,
                                            result.tracking.information, captured_ns, piece_,
                                            status_.anchored});
}

void FrontLoop::begin_piece(FrameId frame) {
  status_.anchored = piece_ < 0;  // the map begins with the first one
  piece_ = frame.value;
}

void FrontLoop::hand_over(std::int64_t timestamp_ns) {
  count(&status_.fragments);
  if (lockstep_) {
    parts_.back_worker.wait_until_idle();  // a fragment's work is always done when the next one closes
    apply_corrections();
  }
  parts_.back_worker.submit(timestamp_ns);
}

void FrontLoop::close_last() {
  if (parts_.front_end.finish() == nullptr) return;
  count(&status_.fragments);
  parts_.back_worker.submit(last_timestamp_ns_);
}

// At a frame boundary: what the back thread found becomes the pose's correction.
void FrontLoop::apply_corrections() {
  const BackWorker& back = parts_.back_worker;
  if (lockstep_ && back.backlog() > 0 && !back.disabled() && !back.ended())
    return;  // when it comes must not depend on timing
  while (parts_.back_worker.take(&correction_)) {
    correction_.timestamp_ns = last_timestamp_ns_;
    correction_.T_odom_camera = T_odom_camera_;
    correction_.T_map_odom_before = T_map_odom_;
    status_.epoch = correction_.epoch;
    if (correction_.piece == piece_) {
      T_map_odom_ = correction_.T_map_odom;
      if (!status_.anchored.exchange(correction_.anchored)) slew_.jump_to(T_map_odom_);
    } else {  // the back thread has not seen the present piece yet
      correction_.T_map_odom = T_map_odom_;
      correction_.anchored = status_.anchored;
    }
    (void)parts_.publisher.publish(correction_);
  }
}

void FrontLoop::note_times(const FrontEndResult& result, std::int64_t start_ns, const RawFrame& raw) {
  const std::int64_t now = steady_now_ns();
  figures_[Stage::kOdometry].record_ns(result.times.odometry_ns);
  figures_[Stage::kFusion].record_ns(result.times.fusion_ns);
  figures_[Stage::kFrame].record_ns(result.times.preprocess_ns + result.times.odometry_ns +
                                    result.times.fusion_ns);
  figures_[Stage::kCaptureToPose].record_ns(now - (raw.captured_ns > 0 ? raw.captured_ns : start_ns));
}

// When tracking is lost, and when a new piece of the trajectory starts.
void FrontLoop::note_state(const FrontEndResult& result) {
  const auto frame = static_cast<long long>(status_.frames.load(std::memory_order_relaxed));
  char text[160];
  if (result.tracking.status == TrackingStatus::kLost && !status_.newest_lost) {
    std::snprintf(text, sizeof text, "tracking lost at frame %lld: %s", frame,
                  to_string(result.tracking.reason));
    note(text);
  } else if (result.tracking.status == TrackingStatus::kFirst && !status_.anchored) {
    std::snprintf(text, sizeof text,
                  "frame %lld starts a new piece of the map, which a loop must join to the rest", frame);
    note(text);
  } else if (result.tracking.status == TrackingStatus::kTracked && status_.newest_lost) {
    std::snprintf(text, sizeof text, "tracking again at frame %lld", frame);
    note(text);
  }
}

void FrontLoop::note_skipped() {
  char text[256];
  std::snprintf(text, sizeof text, "frame skipped: %.200s", parts_.queue.message());
  note(text);
}

void FrontLoop::note(const char* text) {
  Note note;
  std::strncpy(note.text.data(), text, note.text.size() - 1);
  (void)notes_.push(note);  // a full ring: enough of them are waiting to be told
}

std::vector<PoolFigures> FrontLoop::pools() const {
  return {{"pipeline/poses", static_cast<std::int64_t>(poses_.size()),
           static_cast<std::int64_t>(status_.poses.load()), status_.poses_refused.load()},
          notes_.figures()};
}

}  // namespace loopsift
