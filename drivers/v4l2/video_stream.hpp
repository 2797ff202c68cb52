// SPDX-License-Identifier: MIT
// Memory-mapped streaming from a device: a fixed number of the kernel's buffers goes round between the device
// and the reader. In: a device, what to ask it for. Out: filled buffers, in order. One thread. Set-up
// allocates; take() and give_back() do not.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/base/span.hpp"
#include "drivers/v4l2/negotiation.hpp"
#include "drivers/v4l2/v4l2_options.hpp"

namespace loopsift {

/// A frame in the device's memory, the reader's until it is given back.
struct FilledBuffer {
  std::uint32_t index = 0;
  Span<const std::uint8_t> bytes;  ///< what the device has written
  std::uint32_t count = 0;         ///< the device's frame number
  std::int64_t timestamp_ns = 0;   ///< monotonic clock; 0: the device gives none
  bool damaged = false;            ///< the device itself says that it is
};

enum class Take {
  kFilled,
  kTimeout,    ///< nothing came
  kRestarted,  ///< an I/O error; the stream was started again, what was under way is gone
  kLost,       ///< the device is gone or does not recover
};

class VideoStream {
 public:
  /// Consecutive I/O errors that a restart may mend.
  static constexpr int kMostRestarts = 3;

  /// Starts streaming. Errors as the calls they come from; the device is closed again.
  [[nodiscard]] static Expected<std::unique_ptr<VideoStream>> start(VideoDevice device,
                                                                    const StreamFormat& format, int buffers);
  ~VideoStream();
  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;

  [[nodiscard]] const VideoDevice& device() const { return device_; }
  [[nodiscard]] const StreamFormat& format() const { return format_; }
  /// The next frame, waiting for at most timeout_ms. kLost stays.
  [[nodiscard]] Take take(int timeout_ms, FilledBuffer* filled);
  /// To the device again; if that fails the next take() says kLost.
  void give_back(const FilledBuffer& filled);
  /// The system's error behind kRestarted or kLost, an errno value.
  [[nodiscard]] int error_number() const { return error_number_; }

 private:
  VideoStream(VideoDevice device, const StreamFormat& format) : device_(std::move(device)), format_(format) {}
  [[nodiscard]] Status request_buffers(int count);
  [[nodiscard]] Status map_buffer(std::uint32_t index);
  [[nodiscard]] int queue(std::uint32_t index);
  [[nodiscard]] int stream_on();
  void stream_off();
  [[nodiscard]] Take recover(int error_number);
  [[nodiscard]] Take lose(int error_number);

  struct Mapped {
    void* memory;
    std::size_t bytes;
  };

  VideoDevice device_;
  StreamFormat format_;
  std::vector<Mapped> buffers_;
  bool streaming_ = false, lost_ = false;
  int restarts_ = 0;  // since the last frame
  int error_number_ = 0;
};

}  // namespace loopsift
