// SPDX-License-Identifier: MIT
// What a camera costs: a source read at 30 Hz, as the capture thread reads it, with the processor time of the
// reading thread and of the whole process (the driver's and its library's threads, and whatever stands in for
// the camera in this process) and the heap calls of the reading thread.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "drivers/frame_source.hpp"
#include "tests/support/sequence_writer.hpp"

namespace loopsift::bench {

constexpr int kWidth = 640, kHeight = 480;
constexpr std::int64_t kPeriod_ns = 33'333'333;

/// One frame of a rendered room.
struct Picture {
  test::DepthImage depth{kWidth, kHeight};
  test::ColorImage color{kWidth, kHeight};
};
[[nodiscard]] const Picture& picture();

/// Fixed intrinsics for cameras that do not tell theirs.
[[nodiscard]] SourceOptions usual_options();

/// Sleeps until the next frame of a camera that has no clock of its own is due.
class Pace {
 public:
  void wait();

 private:
  std::int64_t due_ns_ = 0;
};

/// Reads ten seconds of frames and prints a row. `each` runs before every read and is not counted.
/// decoding_s: what decoding alone takes of each frame, to be taken off.
void measure(const std::string& name, FrameSource& source, double decoding_s,
             const std::function<void()>& each);
/// The row itself; times in seconds of processor time a frame.
struct Load {
  double rate_hz = 0, thread_s = 0, process_s = 0, decoding_s = 0;
  double heap_calls = 0, library_heap_calls = 0;  ///< a frame
};
void print(const std::string& name, const Load& load);
void print_skipped(const std::string& name, const std::string& why);

/// Seconds of processor time that one call takes.
[[nodiscard]] double cost_s(const std::function<void()>& call);

// One per driver, each in a file of its own.
void load_lcm();
void load_openni2();
void load_v4l2();
void load_libcamera();
void load_recorder();

}  // namespace loopsift::bench
