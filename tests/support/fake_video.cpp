// SPDX-License-Identifier: MIT
#include "tests/support/fake_video.hpp"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace loopsift::test {
namespace {

constexpr int kDescriptor = 7;
constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::int64_t kPage = 4096;

std::uint32_t bytes_per_pixel(std::uint32_t code) {
  return code == V4L2_PIX_FMT_GREY ? 1 : (code == V4L2_PIX_FMT_RGB24 || code == V4L2_PIX_FMT_BGR24 ? 3 : 2);
}

}  // namespace

void FakeVideo::fail(unsigned long request, int error_number, int nth, int times) {
  failures_[request] = {error_number, nth - 1, times};
}

int FakeVideo::buffers_with_device() const {
  return static_cast<int>(
      std::count_if(buffers_.begin(), buffers_.end(), [](const Buffer& b) { return b.with_device; }));
}

int FakeVideo::open(const char* wanted) {
  if (path != wanted) return -ENOENT;
  if (open_error != 0) return -open_error;
  ++open_nodes;
  return kDescriptor;
}

void FakeVideo::close(int /*fd*/) {
  --open_nodes;
  streaming = false;
}

int FakeVideo::ioctl(int fd, unsigned long request, void* argument) {
  if (fd != kDescriptor || open_nodes == 0) return -EBADF;
  const auto failure = failures_.find(request);
  if (failure != failures_.end() && failure->second.times > 0) {
    if (failure->second.calls_before == 0) {
      --failure->second.times;
      return -failure->second.error_number;
    }
    --failure->second.calls_before;
  }
  return answer(request, argument);
}

int FakeVideo::answer(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto* capability = static_cast<v4l2_capability*>(argument);
      std::memcpy(capability->card, "Fake camera", 12);
      capability->capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      capability->device_caps = capabilities;
      return 0;
    }
    case VIDIOC_ENUM_FMT:
      return describe_format(static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return describe_size(static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_G_FMT:
      static_cast<v4l2_format*>(argument)->fmt.pix = format_;
      return 0;
    case VIDIOC_S_FMT:
      return set_format(static_cast<v4l2_format*>(argument));
    case VIDIOC_G_PARM:
      static_cast<v4l2_streamparm*>(argument)->parm.capture.capability = rate_capability;
      return 0;
    case VIDIOC_S_PARM:
      return set_rate(static_cast<v4l2_streamparm*>(argument));
    case VIDIOC_QUERYCTRL:
      return describe_control(static_cast<v4l2_queryctrl*>(argument));
    case VIDIOC_S_CTRL: {
      const auto* control = static_cast<const v4l2_control*>(argument);
      controls_set.emplace_back(control->id, control->value);
      return 0;
    }
    case VIDIOC_REQBUFS:
      return request_buffers(static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return query_buffer(static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return queue(*static_cast<const v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return take(static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      return stream(true);
    case VIDIOC_STREAMOFF:
      return stream(false);
    default:
      return -ENOTTY;
  }
}

int FakeVideo::describe_format(v4l2_fmtdesc* description) const {
  if (description->index >= formats.size()) return -EINVAL;
  description->pixelformat = formats[description->index];
  return 0;
}

int FakeVideo::describe_size(v4l2_frmsizeenum* size) const {
  if (size->index > 1) return -EINVAL;
  size->type = V4L2_FRMSIZE_TYPE_DISCRETE;
  size->discrete = size->index == 0 ? v4l2_frmsize_discrete{640, 480} : v4l2_frmsize_discrete{8, 4};
  return 0;
}

// As the kernel's drivers do, an unknown format becomes one that there is.
int FakeVideo::set_format(v4l2_format* format) {
  v4l2_pix_format& pixels = format->fmt.pix;
  if (std::find(formats.begin(), formats.end(), pixels.pixelformat) == formats.end())
    pixels.pixelformat = formats.front();
  pixels.field = V4L2_FIELD_NONE;
  pixels.bytesperline = pixels.width * bytes_per_pixel(pixels.pixelformat);
  pixels.sizeimage = pixels.bytesperline * pixels.height;
  if (adjust != nullptr) adjust(&pixels);
  format_ = pixels;
  return 0;
}

int FakeVideo::set_rate(v4l2_streamparm* parameters) const {
  if (interval.numerator != 0) parameters->parm.capture.timeperframe = interval;
  return 0;
}

int FakeVideo::describe_control(v4l2_queryctrl* query) const {
  const std::uint32_t after = query->id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
  for (const FakeControl& control : controls) {  // listed with rising numbers
    if (control.id <= after) continue;
    query->id = control.id;
    query->type = control.type;
    query->flags = control.flags;
    query->minimum = control.min;
    query->maximum = control.max;
    std::memset(query->name, 0, sizeof query->name);
    std::memcpy(query->name, control.name.data(), std::min(control.name.size(), sizeof query->name));
    return 0;
  }
  return -EINVAL;
}

int FakeVideo::request_buffers(v4l2_requestbuffers* request) {
  request->count = std::min(request->count, buffers_at_most);
  buffers_.assign(request->count, {});
  for (Buffer& buffer : buffers_) buffer.bytes.resize(buffer_bytes != 0 ? buffer_bytes : format_.sizeimage);
  return 0;
}

int FakeVideo::query_buffer(v4l2_buffer* head) const {
  if (head->index >= buffers_.size()) return -EINVAL;
  head->length = static_cast<std::uint32_t>(buffers_[head->index].bytes.size());
  head->m.offset = static_cast<std::uint32_t>(head->index * kPage);
  return 0;
}

int FakeVideo::map(int /*fd*/, std::size_t /*bytes*/, std::int64_t offset, void** memory) {
  if (map_error != 0) return -map_error;
  ++mapped_buffers;
  *memory = buffers_[static_cast<std::size_t>(offset / kPage)].bytes.data();
  return 0;
}

void FakeVideo::unmap(void* /*memory*/, std::size_t /*bytes*/) { --mapped_buffers; }

int FakeVideo::queue(const v4l2_buffer& head) {
  if (head.index >= buffers_.size() || buffers_[head.index].with_device) return -EINVAL;
  buffers_[head.index].with_device = true;
  return 0;
}

int FakeVideo::stream(bool on) {
  streaming = on;
  if (on) ++stream_starts;
  for (Buffer& buffer : buffers_)
    if (!on) buffer.with_device = false;
  return 0;
}

int FakeVideo::poll(int /*fd*/, int timeout_ms) {
  if (repeats && next_event_ == events.size()) next_event_ = 0;
  const bool due = next_event_ < events.size();
  if (!due || events[next_event_].kind == VideoEvent::Kind::kSilence) {
    next_event_ += due ? 1 : 0;
    now += timeout_ms * kNsPerMs;
    return 0;
  }
  const VideoEvent& event = events[next_event_];
  if (event.kind != VideoEvent::Kind::kPollError) return event.poll_error_flag ? POLLERR : POLLIN;
  ++next_event_;
  return -event.error_number;
}

int FakeVideo::take(v4l2_buffer* head) {
  const VideoEvent& event = events[next_event_++];
  if (event.kind == VideoEvent::Kind::kTakeError) return -event.error_number;
  if (!streaming || buffers_with_device() == 0) return -EINVAL;
  while (!buffers_[next_buffer_ % buffers_.size()].with_device) ++next_buffer_;
  const std::size_t index = next_buffer_++ % buffers_.size();
  Buffer& buffer = buffers_[index];
  std::copy_n(event.bytes.begin(), std::min(event.bytes.size(), buffer.bytes.size()), buffer.bytes.begin());
  buffer.with_device = false;
  head->index = static_cast<std::uint32_t>(index);
  head->bytesused = static_cast<std::uint32_t>(
      event.bytes_used >= 0 ? static_cast<std::size_t>(event.bytes_used) : event.bytes.size());
  head->sequence = event.sequence;
  head->timestamp.tv_sec = event.timestamp_ns / 1'000'000'000;
  head->timestamp.tv_usec = event.timestamp_ns % 1'000'000'000 / 1000;
  head->flags = event.flags;
  return 0;
}

}  // namespace loopsift::test
