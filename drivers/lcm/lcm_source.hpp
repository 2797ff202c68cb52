// SPDX-License-Identifier: MIT
// The driver of `lcm:CHANNEL`: images that another program publishes as bot_core.images_t.
//
// In: messages with a depth image (DEPTH_MM, DEPTH_MM_ZIPPED) and, where there is one, a colour image (LEFT;
// RGB, GRAY, MJPEG) that is registered to it. Out: RawFrames in millimetres. The message does not carry the
// camera: fx, fy, cx, cy come from the settings, else those of a Kinect (525 pixels at 640 × 480). Time
// stamps are the senders' (LcmInOptions::host_clock). A message that repeats or precedes the one before is a
// kBad frame; one that goes back by a second or more is the end of this source (kLost): its sender has
// started anew.
//
// Threads: the reader's, and one that receives, because LCM allocates; it decodes from LCM's buffer straight
// into the frame that the reader lends it. read() makes no heap call.
#pragma once
#include <lcm/lcm.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "core/base/semaphore.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/lcm/images_decoder.hpp"
#include "drivers/lcm/open_lcm.hpp"

namespace loopsift {

/// As open_lcm(channel, options), on an LCM of the caller's, which it takes over.
[[nodiscard]] Expected<std::unique_ptr<FrameSource>> open_lcm(lcm_t* lcm, const std::string& channel,
                                                              const SourceOptions& options);

class LcmSource final : public FrameSource {
 public:
  /// `lcm` becomes this object's.
  LcmSource(lcm_t* lcm, std::string channel, SourceInfo info, std::int64_t clock_offset_ns);
  ~LcmSource() override;
  LcmSource(const LcmSource&) = delete;
  LcmSource& operator=(const LcmSource&) = delete;

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override { return message_; }

 private:
  // Receiving thread.
  void hear();
  void receive(const lcm_recv_buf_t& received);
  [[nodiscard]] RawFrame* claim();
  void give_back(ReadStatus status, const char* problem);
  [[nodiscard]] ReadStatus check_time(std::int64_t utime_us, const char** problem);
  [[nodiscard]] ReadStatus fill(const ImagesMessage& message, RawFrame* frame, const char** problem);

  lcm_t* lcm_;
  const std::string channel_;
  const SourceInfo info_;
  const std::int64_t clock_offset_ns_;
  Semaphore lent_or_stop_, given_back_;
  std::atomic<RawFrame*> lent_{nullptr};  // to the receiving thread, which takes it out while it writes
  std::atomic<bool> stopping_{false};
  std::thread thread_;

  // The receiving thread's while it holds a frame, else the reader's.
  ReadStatus status_ = ReadStatus::kTimeout;
  std::string message_;

  // Receiving thread's.
  ImagesDecoder decoder_;
  std::int64_t last_utime_us_ = -1, sequence_ = 0;
};

}  // namespace loopsift
