// SPDX-License-Identifier: MIT
// What a camera delivers, live: one line a second, or a picture.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/base/steady_time.hpp"
#include "drivers/frame_source.hpp"
#include "drivers/replay/image_file.hpp"
#include "firmware_app/settings.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/frame_statistics.hpp"

namespace loopsift::tool {
namespace {

constexpr int kTimeoutMs = 100;
constexpr std::int64_t kSecond_ns = 1000000000;
constexpr int kPictureFrame = 10;  // cameras find their exposure first

struct ViewOptions {
  std::string source, config, png, json;
  std::vector<std::string> assignments;
  int frames = 0;
  double seconds = 0;
};

struct Buffers {
  explicit Buffers(const SourceInfo& info)
      : depth(static_cast<std::size_t>(info.camera.width) * static_cast<std::size_t>(info.camera.height)),
        color(static_cast<std::size_t>(info.color_width) * static_cast<std::size_t>(info.color_height)) {
    frame.depth_buffer = depth;
    frame.color_buffer = color;
  }
  std::vector<std::uint16_t> depth;
  std::vector<Rgb8> color;
  RawFrame frame;
};

void print_head(const SourceInfo& info) {
  std::printf("%s\n", info.description.c_str());
  if (info.camera.width > 0)
    std::printf("depth %dx%d, fx %.1f fy %.1f cx %.1f cy %.1f, %g mm\n", info.camera.width,
                info.camera.height, static_cast<double>(info.camera.fx), static_cast<double>(info.camera.fy),
                static_cast<double>(info.camera.cx), static_cast<double>(info.camera.cy),
                1000 * info.depth_unit_m);
  if (info.color_width > 0) std::printf("colour %dx%d\n", info.color_width, info.color_height);
  std::printf("%7s %6s %6s | %6s %6s %6s %6s | %6s | %6s %5s %7s %7s %6s\n", "frames", "Hz", "by stamp",
              "valid%", "near m", "median", "far m", "bright", "missed", "bad", "no color", "backward",
              "gaps");
}

void print_line(const FrameFigures& f) {
  std::printf("%7lld %6.1f %8.1f | %6.1f %6.2f %6.2f %6.2f | %6.1f | %6lld %5lld %8lld %8lld %6lld\n",
              static_cast<long long>(f.frames), f.rate_hz, f.stamp_rate_hz, 100 * f.valid_share, f.near_m,
              f.median_m, f.far_m, f.brightness, static_cast<long long>(f.missed),
              static_cast<long long>(f.bad), static_cast<long long>(f.without_color),
              static_cast<long long>(f.stamp_faults), static_cast<long long>(f.stamp_gaps));
  std::fflush(stdout);
}

nlohmann::ordered_json to_json(const FrameFigures& f, int timeouts) {
  return {{"frames", f.frames},
          {"bad", f.bad},
          {"timeouts", timeouts},
          {"without_color", f.without_color},
          {"missed", f.missed},
          {"stamp_faults", f.stamp_faults},
          {"stamp_gaps", f.stamp_gaps},
          {"rate_hz", f.rate_hz},
          {"stamp_rate_hz", f.stamp_rate_hz},
          {"valid_share", f.valid_share},
          {"near_m", f.near_m},
          {"median_m", f.median_m},
          {"far_m", f.far_m},
          {"brightness", f.brightness}};
}

/// One source, watched until the limits of the options, its end or its loss.
class Viewing {
 public:
  Viewing(FrameSource& source, const ViewOptions& options)
      : source_(source),
        options_(options),
        buffers_(source.info()),
        second_(source.info()),
        total_(source.info()),
        last_(source.info()) {}

  Status go() {
    print_head(source_.info());
    const std::int64_t start_ns = steady_now_ns();
    std::int64_t line_ns = start_ns + kSecond_ns;
    ReadStatus status = ReadStatus::kTimeout;
    while (!is_enough(start_ns) && status != ReadStatus::kEnd && status != ReadStatus::kLost) {
      status = read();
      if (steady_now_ns() < line_ns) continue;
      print_line(second_.take());
      line_ns += kSecond_ns;
    }
    std::printf("in all:\n");
    figures_ = total_.take();
    print_line(figures_);
    if (status == ReadStatus::kLost)
      return Error{ErrorCode::kIo, options_.source + ": the source was lost: " + source_.message()};
    if (figures_.frames == 0)
      return Error{ErrorCode::kIo, options_.source + ": gave no usable frame" + complaint()};
    return {};
  }
  Status write() {
    const Status json = write_json(options_.json, to_json(figures_, timeouts_));
    if (options_.png.empty() || !json.ok()) return json;
    return write_png_rgb(options_.png,
                         FramePicture(buffers_.frame, source_.info().depth_unit_m, last_.take()).view());
  }

 private:
  [[nodiscard]] bool is_enough(std::int64_t start_ns) const {
    const double passed_s = static_cast<double>(steady_now_ns() - start_ns) * 1e-9;
    return (options_.frames > 0 && frames_ >= options_.frames) ||
           (options_.seconds > 0 && passed_s >= options_.seconds);
  }
  [[nodiscard]] std::string complaint() const { return complaint_.empty() ? "" : ": " + complaint_; }

  ReadStatus read() {
    const ReadStatus status = source_.read(buffers_.frame, kTimeoutMs);
    if (!source_.message().empty()) complaint_ = source_.message();
    if (status == ReadStatus::kTimeout) ++timeouts_;
    if (status == ReadStatus::kBad) {
      second_.add_bad();
      total_.add_bad();
    }
    if (status != ReadStatus::kFrame) return status;
    ++frames_;
    (void)last_.take();
    for (FrameStatistics* statistics : {&second_, &total_, &last_})
      statistics->add(buffers_.frame, steady_now_ns());
    return status;
  }

  FrameSource& source_;
  const ViewOptions& options_;
  Buffers buffers_;
  FrameStatistics second_, total_, last_;  // since the last line; of all; of the last frame
  FrameFigures figures_;
  int frames_ = 0, timeouts_ = 0;
  std::string complaint_;
};

int view(ViewOptions options) {
  if (!options.png.empty() && options.frames == 0) options.frames = kPictureFrame;
  if (!options.source.empty()) options.assignments.push_back("run.source=" + options.source);
  const auto settings = load_settings(options.config, options.assignments);
  if (!settings) return fail(settings.error());
  options.source = settings->run.source;
  if (options.source.empty()) return fail({ErrorCode::kUsage, "no source: name one with --source URI"});
  const auto source = open_source(options.source, settings->source);
  if (!source) return fail_to_open_source(source.error());
  Viewing viewing(**source, options);
  if (const Status seen = viewing.go(); !seen.ok()) return fail(seen.error());
  const Status written = viewing.write();
  return written.ok() ? kExitDone : fail(written.error());
}

}  // namespace

void add_view_command(CLI::App& app, int* exit_code) {
  const auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand(
      "view",
      "Shows what a source delivers, a line a second: rate by arrival and by time stamp, share "
      "and range of depth, brightness of colour, and what is missing or wrong");
  command->add_option("--source", options->source, "as loopsift --source")->type_name("URI");
  command->add_option("--config", options->config, "settings of loopsift: camera and drivers are used")
      ->type_name("FILE");
  command
      ->add_option("--set", options->assignments,
                   "change one of them, as in --set camera.file=config/cameras/xtion.toml; repeatable")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command->add_option("--frames", options->frames, "stop after so many; 0: at the end of the source")
      ->check(CLI::Range(0, std::numeric_limits<int>::max()));
  command->add_option("--seconds", options->seconds, "stop after so long; 0: no limit")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--png", options->png,
                   "write the last frame as a picture: depth (near red, far blue) beside colour; without "
                   "--frames the tenth")
      ->type_name("FILE");
  command->add_option("--json", options->json, "write the figures to this file")->type_name("FILE");
  command->callback([options, exit_code] { *exit_code = view(*options); });
}

}  // namespace loopsift::tool
