// SPDX-License-Identifier: MIT
// Frames kept as they come, to be replayed: DIR/recording.klg and DIR/camera.txt
// (`replay:klg:DIR/recording.klg`). Depth is stored losslessly (zlib), colour as JPEG. In: frames from the
// capture thread, which never waits: a frame that finds all kWaiting slots full is left out and counted. Out:
// a file that is whole after every frame, so that a run may be cut off. When RecordOptions::max_mib are
// written, or the disk is full, the file ends there, which is said once; the run goes on. Threads: capture
// offers, one of its own writes (normal scheduling; it allocates).
#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/result.hpp"
#include "core/base/semaphore.hpp"
#include "core/base/spsc_ring.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/record_options.hpp"

namespace loopsift {

struct RecorderCounts {
  std::atomic<std::int64_t> written{0};   ///< frames in the file
  std::atomic<std::int64_t> left_out{0};  ///< that came while all slots were full
  std::atomic<std::int64_t> bytes{0};     ///< of the file
  std::atomic<bool> full{false};          ///< nothing more is written
};

class FrameRecorder {
 public:
  static constexpr std::size_t kWaiting = 8;

  /// Carves the slots, none when options.folder is empty. Opens nothing.
  FrameRecorder(const RecordOptions& options, const SourceInfo& info, Arena& arena);
  ~FrameRecorder() { (void)finish(); }
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  /// Makes the folder and the files and starts the thread; does nothing without a folder. Errors: the folder
  /// cannot be made, there is a recording in it already.
  [[nodiscard]] Status start();
  /// Capture thread. Never waits, never allocates.
  void offer(const RawFrame& frame);
  /// Writes what waits and ends the thread. After the capture thread's end. What there is to say; empty:
  /// nothing was recorded.
  std::string finish();
  [[nodiscard]] const RecorderCounts& counts() const { return counts_; }

 private:
  struct Slot {
    std::int64_t timestamp_ns;
    bool has_color;
  };
  void run();
  void write(std::size_t slot);
  [[nodiscard]] bool put(const void* bytes, std::size_t size, std::int64_t offset) const;
  void stop_writing(const std::string& why);

  const RecordOptions options_;
  const SourceInfo info_;
  const std::size_t depth_pixels_, color_pixels_;
  Span<Slot> slots_;
  Span<std::uint16_t> depth_;
  Span<Rgb8> color_;
  SpscRing<std::uint32_t> free_, ready_;
  Semaphore ready_or_end_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
  RecorderCounts counts_;
  bool begun_ = false;  // capture thread: a frame was offered that the file can begin with

  // Writing thread's.
  int file_ = -1;
  std::vector<std::uint8_t> entry_;
};

}  // namespace loopsift
