// SPDX-License-Identifier: MIT
#include "drivers/v4l2/video_stream.hpp"

#include <linux/videodev2.h>
#include <poll.h>

#include <cerrno>

namespace loopsift {
namespace {

constexpr int kFewestBuffers = 2;  // one is filled while the other is read

v4l2_buffer buffer_head(std::uint32_t index) {
  v4l2_buffer head{};
  head.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  head.memory = V4L2_MEMORY_MMAP;
  head.index = index;
  return head;
}

std::int64_t timestamp_ns(const v4l2_buffer& head) {
  if ((head.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return 0;
  return std::int64_t{head.timestamp.tv_sec} * 1'000'000'000 + std::int64_t{head.timestamp.tv_usec} * 1000;
}

}  // namespace

Expected<std::unique_ptr<VideoStream>> VideoStream::start(VideoDevice device, const StreamFormat& format,
                                                          int buffers) {
  std::unique_ptr<VideoStream> stream(new VideoStream(std::move(device), format));
  if (Status ready = stream->request_buffers(buffers); !ready) return ready.error();
  if (const int result = stream->stream_on(); result < 0)
    return stream->device_.system_error("cannot start streaming", result);
  return stream;
}

VideoStream::~VideoStream() {
  stream_off();
  for (const Mapped& buffer : buffers_) device_.system().unmap(buffer.memory, buffer.bytes);
}

Status VideoStream::request_buffers(int count) {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(count);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int result = device_.ioctl(VIDIOC_REQBUFS, &request); result < 0)
    return device_.system_error("gives no buffers", result);
  if (request.count < kFewestBuffers) {
    return device_.error(ErrorCode::kCapacity, "gives only " + std::to_string(request.count) +
                                                   " buffers; at least " + std::to_string(kFewestBuffers) +
                                                   " are needed");
  }
  buffers_.reserve(request.count);
  for (std::uint32_t k = 0; k < request.count; ++k)
    if (Status mapped = map_buffer(k); !mapped) return mapped;
  return {};
}

Status VideoStream::map_buffer(std::uint32_t index) {
  v4l2_buffer head = buffer_head(index);
  if (const int result = device_.ioctl(VIDIOC_QUERYBUF, &head); result < 0)
    return device_.system_error("does not describe its buffers", result);
  if (head.length < format_.image_bytes()) {
    return device_.error(ErrorCode::kUnsupported, "its buffers of " + std::to_string(head.length) +
                                                      " bytes hold no image of " +
                                                      std::to_string(format_.image_bytes()));
  }
  Mapped buffer{nullptr, head.length};
  if (const int result = device_.system().map(device_.fd(), head.length, head.m.offset, &buffer.memory);
      result < 0)
    return device_.system_error("its buffers cannot be mapped", result);
  buffers_.push_back(buffer);
  return {};
}

int VideoStream::queue(std::uint32_t index) {
  v4l2_buffer head = buffer_head(index);
  return device_.ioctl(VIDIOC_QBUF, &head);
}

int VideoStream::stream_on() {
  for (std::uint32_t k = 0; k < buffers_.size(); ++k)
    if (const int result = queue(k); result < 0) return result;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  const int result = device_.ioctl(VIDIOC_STREAMON, &type);
  streaming_ = result >= 0;
  return result;
}

// Also takes every buffer back from the device.
void VideoStream::stream_off() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (streaming_) (void)device_.ioctl(VIDIOC_STREAMOFF, &type);  // of a device that is gone: fails, no matter
  streaming_ = false;
}

Take VideoStream::lose(int error_number) {
  lost_ = true;
  error_number_ = error_number;
  return Take::kLost;
}

Take VideoStream::recover(int error_number) {
  if (++restarts_ > kMostRestarts) return lose(error_number);
  error_number_ = error_number;
  stream_off();
  const int result = stream_on();
  return result < 0 ? lose(-result) : Take::kRestarted;
}

Take VideoStream::take(int timeout_ms, FilledBuffer* filled) {
  if (lost_) return Take::kLost;
  const int events = device_.system().poll(device_.fd(), timeout_ms);
  if (events < 0) return lose(-events);
  if (events == 0) return Take::kTimeout;
  v4l2_buffer head = buffer_head(0);
  const int result = device_.ioctl(VIDIOC_DQBUF, &head);
  // Poll says an error, too, when no buffer is with the device: only the call tells what is the matter.
  if (result == -EAGAIN) return (events & POLLERR) != 0 ? recover(EIO) : Take::kTimeout;
  if (result == -EIO) return recover(EIO);
  if (result < 0) return lose(-result);
  if (head.index >= buffers_.size() || head.bytesused > buffers_[head.index].bytes) return lose(EPROTO);
  restarts_ = 0;
  filled->index = head.index;
  filled->bytes = {static_cast<const std::uint8_t*>(buffers_[head.index].memory), head.bytesused};
  filled->count = head.sequence;
  filled->timestamp_ns = timestamp_ns(head);
  filled->damaged = (head.flags & V4L2_BUF_FLAG_ERROR) != 0;
  return Take::kFilled;
}

void VideoStream::give_back(const FilledBuffer& filled) {
  if (const int result = queue(filled.index); result < 0) (void)lose(-result);
}

}  // namespace loopsift
