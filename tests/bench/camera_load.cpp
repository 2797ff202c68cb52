// SPDX-License-Identifier: MIT
// camera_load [DRIVER...]: prints a row for each driver that the build has (default: all). LCM needs a bus:
//   tests/system/private_bus.sh BUILD/tests/bench/camera_load
#include "tests/bench/camera_load.hpp"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <thread>

#include "core/base/heap_watch.hpp"
#include "core/base/steady_time.hpp"

namespace loopsift::bench {
namespace {

constexpr int kWarmUp = 15, kFrames = 300;

double cpu_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// False when the source ends.
bool read_one(FrameSource& source, RawFrame* frame) {
  ReadStatus status = ReadStatus::kTimeout;
  while (status == ReadStatus::kTimeout || status == ReadStatus::kBad) status = source.read(*frame, 1000);
  return status == ReadStatus::kFrame;
}

}  // namespace

const Picture& picture() {
  static const Picture made = [] {
    Picture room;
    const auto source = open_source("synth:room?frames=1", SourceOptions());
    RawFrame frame;
    frame.depth_buffer = room.depth.pixels;
    frame.color_buffer = room.color.pixels;
    if (!source.ok() || (*source)->read(frame, 0) != ReadStatus::kFrame) std::printf("no picture\n");
    return room;
  }();
  return made;
}

SourceOptions usual_options() {
  SourceOptions options;
  options.camera = {kWidth, kHeight, 525, 525, 319.5F, 239.5F};
  return options;
}

void Pace::wait() {
  const std::int64_t now_ns = steady_now_ns();
  if (due_ns_ > now_ns) std::this_thread::sleep_for(std::chrono::nanoseconds(due_ns_ - now_ns));
  due_ns_ = std::max(due_ns_, now_ns - kPeriod_ns) + kPeriod_ns;
}

void measure(const std::string& name, FrameSource& source, double decoding_s,
             const std::function<void()>& each) {
  test::FrameBuffers buffers(source.info());
  std::atomic<std::int64_t> heap_calls{0}, library_calls{0};
  Load load;
  std::int64_t first_ns = 0;
  double before_s = 0;
  for (int k = -kWarmUp; k < kFrames; ++k) {
    each();
    if (k == 0) {
      first_ns = steady_now_ns();
      before_s = cpu_s(CLOCK_PROCESS_CPUTIME_ID);
      heap_calls = library_calls = 0;
      load.thread_s = 0;
    }
    const double thread_before_s = cpu_s(CLOCK_THREAD_CPUTIME_ID);
    bool read = false;
    {
      const HeapSeal seal(&heap_calls, HeapMode::kCount, &library_calls);
      read = read_one(source, &buffers.frame);
    }
    load.thread_s += (cpu_s(CLOCK_THREAD_CPUTIME_ID) - thread_before_s) / kFrames;
    if (!read) return print_skipped(name, source.message());
  }
  load.rate_hz = 1e9 * kFrames / static_cast<double>(steady_now_ns() - first_ns);
  load.process_s = (cpu_s(CLOCK_PROCESS_CPUTIME_ID) - before_s) / kFrames;
  load.decoding_s = decoding_s;
  load.heap_calls = static_cast<double>(heap_calls) / kFrames;
  load.library_heap_calls = static_cast<double>(library_calls) / kFrames;
  print(name, load);
}

void print(const std::string& name, const Load& load) {
  const auto percent = [](double seconds) { return 100 * seconds * 1e9 / static_cast<double>(kPeriod_ns); };
  std::printf("%-38s %5.1f %8.2f %8.2f %8.2f %8.2f %7.2f %7.2f\n", name.c_str(), load.rate_hz,
              percent(load.thread_s), percent(load.process_s), percent(load.decoding_s),
              percent(load.process_s - load.decoding_s), load.heap_calls, load.library_heap_calls);
  std::fflush(stdout);
}

void print_skipped(const std::string& name, const std::string& why) {
  std::printf("%-38s skipped: %s\n", name.c_str(), why.c_str());
}

double cost_s(const std::function<void()>& call) {
  constexpr int kCalls = 100;
  call();
  const double before_s = cpu_s(CLOCK_THREAD_CPUTIME_ID);
  for (int k = 0; k < kCalls; ++k) call();
  return (cpu_s(CLOCK_THREAD_CPUTIME_ID) - before_s) / kCalls;
}

}  // namespace loopsift::bench

int main(int argc, char** argv) {
  using namespace loopsift::bench;
  const std::map<std::string, void (*)()> drivers = {
#ifdef LOOPSIFT_HAVE_OPENNI2
      {"openni2", load_openni2},
#endif
#ifdef LOOPSIFT_HAVE_V4L2
      {"v4l2", load_v4l2},
#endif
#ifdef LOOPSIFT_HAVE_LIBCAMERA
      {"libcamera", load_libcamera},
#endif
      {"lcm", load_lcm},
      {"record", load_recorder},
  };
  std::printf("%d x %d at 30 Hz; %% of a core, heap calls a frame\n", kWidth, kHeight);
  std::printf("%-38s %5s %8s %8s %8s %8s %7s %7s\n", "", "Hz", "reading", "process", "decoding", "beyond",
              "heap", "library");
  (void)picture();
  for (const auto& [name, load] : drivers) {
    bool wanted = argc == 1;
    for (int k = 1; k < argc; ++k) wanted = wanted || name == argv[k];
    if (wanted) load();
  }
  return 0;
}
