// SPDX-License-Identifier: MIT
// A V4L2 device that is not there: the system calls of one node, answered from a script. It behaves as the
// kernel documents (buffers go round, streaming off takes them back) and misbehaves on request.
#pragma once
#include <linux/videodev2.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/v4l2/video_system.hpp"

namespace loopsift::test {

/// One thing that happens while streaming.
struct VideoEvent {
  enum class Kind { kFrame, kSilence, kPollError, kTakeError };
  Kind kind = Kind::kFrame;
  int error_number = 0;          ///< kPollError, kTakeError: what the call fails with
  bool poll_error_flag = false;  ///< kTakeError: poll says POLLERR, not POLLIN
  std::vector<std::uint8_t> bytes;
  std::int64_t bytes_used = -1;  ///< what the device claims; −1: the bytes that there are
  std::uint32_t sequence = 0;
  std::int64_t timestamp_ns = 0;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
};

struct FakeControl {
  std::uint32_t id;
  std::string name;
  std::int32_t min, max;
  std::uint32_t type = V4L2_CTRL_TYPE_INTEGER;
  std::uint32_t flags = 0;
};

class FakeVideo final : public VideoSystem {
 public:
  // The device: 8 × 4 pixels of Y16 unless changed.
  std::string path = "/dev/video0";
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<std::uint32_t> formats{V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_Y16};
  std::vector<FakeControl> controls;
  std::uint32_t buffers_at_most = 32;
  std::uint32_t buffer_bytes = 0;  ///< 0: the image's
  std::uint32_t rate_capability = V4L2_CAP_TIMEPERFRAME;
  v4l2_fract interval{0, 0};  ///< what it answers to any rate; 0: what was asked
  /// What it makes of the format it is asked for.
  void (*adjust)(v4l2_pix_format* format) = nullptr;

  std::vector<VideoEvent> events;
  bool repeats = false;  ///< after the last event comes the first
  std::int64_t now = 1'000'000'000;

  /// From the `nth` call of `request` on (1: the next), it fails `times` times.
  void fail(unsigned long request, int error_number, int nth = 1, int times = 1);
  int open_error = 0, map_error = 0;

  // What the program has done.
  std::vector<std::pair<std::uint32_t, std::int32_t>> controls_set;
  int open_nodes = 0, mapped_buffers = 0, stream_starts = 0;
  bool streaming = false;
  [[nodiscard]] int buffers_with_device() const;
  [[nodiscard]] bool all_given_back() const { return open_nodes == 0 && mapped_buffers == 0 && !streaming; }
  [[nodiscard]] const v4l2_pix_format& format() const { return format_; }

  int open(const char* wanted) override;
  void close(int fd) override;
  int ioctl(int fd, unsigned long request, void* argument) override;
  int map(int fd, std::size_t bytes, std::int64_t offset, void** memory) override;
  void unmap(void* memory, std::size_t bytes) override;
  int poll(int fd, int timeout_ms) override;
  std::int64_t now_ns() override { return now; }

 private:
  struct Failure {
    int error_number, calls_before, times;
  };
  struct Buffer {
    std::vector<std::uint8_t> bytes;
    bool with_device = false;
  };

  int answer(unsigned long request, void* argument);
  int describe_format(v4l2_fmtdesc* description) const;
  int describe_size(v4l2_frmsizeenum* size) const;
  int set_format(v4l2_format* format);
  int set_rate(v4l2_streamparm* parameters) const;
  int describe_control(v4l2_queryctrl* query) const;
  int request_buffers(v4l2_requestbuffers* request);
  int query_buffer(v4l2_buffer* head) const;
  int queue(const v4l2_buffer& head);
  int take(v4l2_buffer* head);
  int stream(bool on);

  std::map<unsigned long, Failure> failures_;
  v4l2_pix_format format_{};
  std::vector<Buffer> buffers_;
  std::size_t next_event_ = 0, next_buffer_ = 0;
};

}  // namespace loopsift::test
