// SPDX-License-Identifier: MIT
// Depth of one source, colour of another. In: two sources whose time stamps count from the same moment. Out:
// the depth frames, each with the colour frame whose time stamp lies within half a frame period of its own —
// the period of the faster of the two, so that there is never a nearer one to wait for.
//
// Policy. Depth decides: each depth frame is handed on, with colour or without. Colour that is not there yet
// is waited for, up to most of a depth frame's period, while the colour source gives frames at all. Colour
// that fits no depth frame, comes twice or is corrupt is dropped and counted. A colour source that ends or is
// lost leaves depth alone.
//
// Thread: one reader. read() takes nothing but what the two sources take; colour is decoded into the caller's
// buffer, and copied once only where it came before the depth frame that it belongs to.
#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/frame_source.hpp"

namespace loopsift {

struct PairCounts {
  std::int64_t paired = 0;    ///< depth frames with colour
  std::int64_t missing = 0;   ///< depth frames without
  std::int64_t unused = 0;    ///< colour frames that fit no depth frame
  std::int64_t repeated = 0;  ///< colour frames with the time stamp of the one before
  std::int64_t bad = 0;       ///< colour frames that could not be used
};

class PairedSource final : public FrameSource {
 public:
  /// kUsage when one is live and the other recorded, or `color` has no colour.
  [[nodiscard]] static Expected<std::unique_ptr<FrameSource>> create(std::unique_ptr<FrameSource> depth,
                                                                     std::unique_ptr<FrameSource> color);

  PairedSource(std::unique_ptr<FrameSource> depth, std::unique_ptr<FrameSource> color);
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] ReadStatus read(RawFrame& frame, int timeout_ms) override;
  [[nodiscard]] const std::string& message() const override { return message_; }
  [[nodiscard]] const PairCounts& counts() const { return counts_; }

 private:
  enum class Fit { kTooEarly, kPair, kTooLate };
  [[nodiscard]] Fit fit(std::int64_t color_ns, std::int64_t depth_ns) const;
  [[nodiscard]] bool find_color(const RawFrame& frame);
  [[nodiscard]] bool take_ahead(const RawFrame& frame, bool* found);
  [[nodiscard]] bool read_color(const RawFrame& frame, std::int64_t deadline_ns);
  void keep_ahead();
  void note(std::string_view problem);

  std::unique_ptr<FrameSource> depth_, color_;
  SourceInfo info_;
  std::int64_t window_ns_;             // half a period of the faster source
  std::int64_t patience_ns_;           // how long colour is waited for
  RawFrame color_frame_;               // the colour frame read last, in the caller's buffer
  std::vector<std::uint16_t> unused_;  // depth of a colour source that has some
  std::vector<Rgb8> ahead_;            // a colour frame for a later depth frame
  std::int64_t ahead_ns_ = 0, last_color_ns_ = 0;
  bool has_ahead_ = false, has_last_color_ = false, color_over_ = false;
  int silent_frames_ = 0;  // depth frames since the colour source gave a frame
  PairCounts counts_;
  std::string message_;
};

}  // namespace loopsift
