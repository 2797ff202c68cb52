// SPDX-License-Identifier: MIT
// Runs in the guest: the drivers against real kernel devices that need no hardware.
//   guest_check devices
//   guest_check vivid NODE      kernel's test camera: Y16 and YUYV, a format it has not, ten unplugs
//   guest_check loopback NODE   v4l2loopback: depth of known content, pixel by pixel
//   guest_check libcamera       vimc through libcamera, opened three times
//   guest_check paired DEPTH_NODE   depth from v4l2loopback with libcamera's colour
// Prints what it found; exit code 1 at the first thing that is not as it should be.
#include <atomic>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/base/heap_watch.hpp"
#include "core/base/steady_time.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/list_devices.hpp"
#include "drivers/v4l2/controls.hpp"
#include "drivers/v4l2/video_device.hpp"
#include "tests/system/guest/loopback_writer.hpp"

namespace loopsift {
namespace {

constexpr int kTimeoutMs = 20000;  // emulated, on a machine that may be busy
constexpr int kWidth = 640, kHeight = 480;

void require(bool holds, const std::string& what) {
  if (holds) return;
  std::printf("FAILED: %s\n", what.c_str());
  std::exit(1);
}

SourceOptions usual_options() {
  SourceOptions options;
  options.camera = {kWidth, kHeight, 570, 570, 319.5F, 239.5F};
  return options;
}

std::unique_ptr<FrameSource> open(const std::string& uri, const SourceOptions& options) {
  auto source = open_source(uri, options);
  require(source.ok(), source.ok() ? "" : source.error().message);
  return std::move(*source);
}

/// A source's frames, in buffers that fit.
class Reader {
 public:
  explicit Reader(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {
    const SourceInfo& info = source_->info();
    depth_.resize(static_cast<std::size_t>(info.camera.width) * static_cast<std::size_t>(info.camera.height));
    color_.resize(static_cast<std::size_t>(info.color_width) * static_cast<std::size_t>(info.color_height));
    frame_.depth_buffer = {depth_.data(), depth_.size()};
    frame_.color_buffer = {color_.data(), color_.size()};
  }
  ReadStatus read() {
    const HeapSeal seal(&heap_calls_, HeapMode::kCount);
    return source_->read(frame_, kTimeoutMs);
  }
  /// The next good frame; bad ones are counted.
  const RawFrame& next() {
    ReadStatus status = ReadStatus::kBad;
    while ((status = read()) == ReadStatus::kBad) ++bad_;
    require(status == ReadStatus::kFrame, "no frame came: " + source_->message());
    return frame_;
  }
  [[nodiscard]] FrameSource& source() { return *source_; }
  [[nodiscard]] int bad() const { return bad_; }
  [[nodiscard]] std::int64_t heap_calls() const { return heap_calls_.load(); }

 private:
  std::unique_ptr<FrameSource> source_;
  std::vector<std::uint16_t> depth_;
  std::vector<Rgb8> color_;
  RawFrame frame_;
  std::atomic<std::int64_t> heap_calls_{0};
  int bad_ = 0;
};

/// Reads `count` frames after the first and prints rate and gaps. Times must be the host's, and reading must
/// make no heap call.
void stream(Reader& reader, int count) {
  std::printf("%s\n", reader.source().info().description.c_str());
  const RawFrame& frame = reader.next();
  const std::int64_t first_calls = reader.heap_calls(), first_ns = frame.timestamp_ns, first = frame.sequence;
  std::int64_t last_ns = first_ns, oldest_ns = 0;
  for (int k = 0; k < count; ++k) {
    (void)reader.next();
    require(frame.timestamp_ns > last_ns, "a time stamp that does not go forward");
    require(frame.timestamp_ns <= steady_now_ns(), "a time stamp in the future");
    last_ns = frame.timestamp_ns;
    oldest_ns = std::max(oldest_ns, frame.captured_ns - frame.timestamp_ns);
  }
  std::printf("  %d frames at %.2f Hz, %" PRId64
              " dropped by the device, %d bad, at most %.1f ms old, "
              "%" PRId64 " heap calls\n",
              count, 1e9 * count / static_cast<double>(last_ns - first_ns), frame.sequence - first - count,
              reader.bad(), 1e-6 * static_cast<double>(oldest_ns), reader.heap_calls() - first_calls);
  require(reader.heap_calls() == first_calls, "reading a frame makes heap calls");
}

void check_devices() {
  for (const DeviceInfo& device : list_devices()) {
    std::printf("%s  %s\n", device.uri.c_str(), device.name.c_str());
    for (const std::string& format : device.formats) std::printf("    %s\n", format.c_str());
  }
}

// vivid plays an unplugged camera when it is told to; the node comes back once nobody has it open.
void unplug_and_replug(const std::string& node) {
  constexpr int kTimes = 10;
  for (int k = 0; k < kTimes; ++k) {
    Reader reader(open("v4l2:" + node + "?format=Y16", usual_options()));
    (void)reader.next();
    {
      const auto device = VideoDevice::open(kernel_video_system(), node);
      require(device.ok(), "a second opening for the control");
      const Status set = set_controls(*device, {"disconnect=0"});
      require(set.ok(), set.ok() ? "" : set.error().message);
    }
    ReadStatus status = ReadStatus::kFrame;
    for (int frames = 0; frames < 10 && status != ReadStatus::kLost; ++frames) status = reader.read();
    require(status == ReadStatus::kLost, "an unplugged camera is lost");
    if (k == 0) std::printf("  unplugged: %s\n", reader.source().message().c_str());
  }
  std::printf("  unplugged and opened again %d times\n", kTimes);
}

void check_vivid(const std::string& node) {
  {
    Reader depth(open("v4l2:" + node + "?format=Y16", usual_options()));
    stream(depth, 40);
  }
  {
    Reader color(open("v4l2:" + node + "?format=YUYV", usual_options()));
    stream(color, 40);
  }
  const SourceOptions options = usual_options();
  const auto refused = open_source("v4l2:" + node + "?format=Z16", options);
  require(!refused.ok(), "vivid has no Z16");
  std::printf("  refused: %s\n", refused.error().message.c_str());
  unplug_and_replug(node);
}

void check_loopback(const std::string& node) {
  const test::LoopbackWriter writer(node, kWidth, kHeight);
  require(writer.is_open(), "v4l2loopback takes Y16");
  Reader reader(open("v4l2:" + node, usual_options()));
  stream(reader, 10);
  constexpr int kFrames = 30;
  for (int k = 0; k < kFrames; ++k) {
    const RawFrame& frame = reader.next();
    const int number = frame.depth(0, 0);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        require(frame.depth(x, y) == test::loopback_pixel(number, x, y), "a pixel is not what was written");
  }
  std::printf("  %d frames of %d x %d equal in every pixel\n", kFrames, kWidth, kHeight);
}

void check_libcamera() {
  for (int k = 0; k < 3; ++k) {
    Reader color(open("libcamera:0", usual_options()));
    stream(color, k == 0 ? 30 : 5);
    const SourceOptions options = usual_options();
    const auto again = open_source("libcamera:0", options);
    require(!again.ok(), "a camera is had once at a time");
    if (k == 0) std::printf("  while it is open: %s\n", again.error().message.c_str());
  }
  std::printf("  opened three times\n");
}

void check_paired(const std::string& node) {
  const test::LoopbackWriter writer(node, kWidth, kHeight);
  require(writer.is_open(), "v4l2loopback takes Y16");
  SourceOptions options = usual_options();
  options.color_source = "libcamera:0";
  Reader reader(open("v4l2:" + node, options));
  int with_color = 0;
  constexpr int kFrames = 40;
  for (int k = 0; k < kFrames; ++k) with_color += reader.next().color.empty() ? 0 : 1;
  std::printf("%s\n  %d of %d depth images have colour within half a frame\n",
              reader.source().info().description.c_str(), with_color, kFrames);
  require(with_color > 0, "no image found its colour");
}

int run(const std::string& what, const std::string& node) {
  if (what == "devices") {
    check_devices();
  } else if (what == "vivid") {
    check_vivid(node);
  } else if (what == "loopback") {
    check_loopback(node);
  } else if (what == "libcamera") {
    check_libcamera();
  } else if (what == "paired") {
    check_paired(node);
  } else {
    std::printf("usage: guest_check devices | vivid NODE | loopback NODE | libcamera | paired NODE\n");
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace loopsift

int main(int argc, char** argv) { return loopsift::run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : ""); }
