// SPDX-License-Identifier: MIT
#include "firmware_app/settings.hpp"

#include <algorithm>

#include "firmware_app/camera_file.hpp"
#include "firmware_app/driver_options.hpp"
#include "firmware_app/option_table.hpp"
#include "firmware_app/stage_options.hpp"

namespace loopsift {
namespace {

constexpr int kMaxViews = 65535;  // what the scorer numbers in 16 bits

// One function per section, one line per key: {key, member, comment, {min, max}}.

OptionSection run_section(RunSettings& s) {
  const auto rate = by_name(&s.rate, {{"realtime", Rate::kRealtime}, {"max", Rate::kMax}});
  const auto level = by_name(&s.log_level, {{"debug", LogLevel::kDebug},
                                            {"info", LogLevel::kInfo},
                                            {"warning", LogLevel::kWarning},
                                            {"error", LogLevel::kError}});
  return {"run",
          "What to do. The command line's --source, --odometry, --out and --rate come before these.",
          {
              {"source", &s.source, "depth camera or recording, a URI as in --help"},
              {"odometry", &s.odometry, "builtin, file:TRAJECTORY or lcm:CHANNEL"},
              {"out", &s.out, "folder for the results; empty: none are written"},
              {"rate", rate, "realtime: a recording at its own pace, late frames dropped; max: every frame"},
              {"log_level", level, "least severe message that is shown"},
          }};
}

OptionSection camera_section(CameraSettings& s) {
  return {
      "camera",
      "The depth camera. A zero is replaced by what the source says about itself.",
      {
          {"fx", &s.model.fx, "focal length, pixels", {0, 1e5}},
          {"fy", &s.model.fy, "focal length, pixels", {0, 1e5}},
          {"cx", &s.model.cx, "principal point, pixels, pixel centres at integers", {0, 1e5}},
          {"cy", &s.model.cy, "principal point, pixels, pixel centres at integers", {0, 1e5}},
          {"width", &s.model.width, "pixels", {0, 8192}},
          {"height", &s.model.height, "pixels", {0, 8192}},
          {"depth_scale", &s.depth_scale, "raw depth units per metre", {0, 1e6}},
          {"file", &s.file, "the sensor's calibration (docs/calibration.md); empty: none"},
          {"color_source", &s.color_source, "URI of another camera for the colour; empty: the source's own"},
          {"min_depth_m", &s.min_depth_m, "nearer measurements are not used", {0, 100}},
          {"max_depth_m", &s.max_depth_m, "farther measurements are not used", {0, 100}},
          {"noise_floor_m",
           &s.noise_floor_m,
           "a measurement's σ: floor + slope · (depth − 0.4 m)²",
           {1e-6, 1}},
          {"noise_slope_per_m", &s.noise_slope_per_m, "with what the calibration leaves over", {0, 1}},
      }};
}

OptionSection replay_section(ReplaySettings& s) {
  return {"replay",
          "Recordings.",
          {
              {"rate_hz", &s.rate_hz, "of recordings without time stamps; 0: the usual for them", {0, 1000}},
          }};
}

OptionSection source_section(RetryOptions& s) {
  constexpr OptionRange kMilliseconds{1, 1e6};
  return {
      "source",
      "Cameras that are not there, or are lost while a run goes on. Recordings are never opened again.",
      {
          {"first_retry_limit", &s.first_retry_limit, "tries more to open a camera at the start", {0, 1e6}},
          {"retry_limit",
           &s.retry_limit,
           "tries in a row, without a frame, until a lost camera is given up; 0: at once; -1: never",
           {-1, 1e6}},
          {"retry_first_ms", &s.retry_first_ms, "before the first try; doubles with each …", kMilliseconds},
          {"retry_max_ms", &s.retry_max_ms, "… up to this", kMilliseconds},
          {"stall_periods",
           &s.stall_periods,
           "frame periods without a frame, then a camera is closed and opened again; 0: never",
           {0, 1e6}},
      }};
}

OptionSection record_section(RecordOptions& s) {
  return {"record",
          "The frames that a run sees, kept to be replayed (--record DIR).",
          {
              {"folder", &s.folder, "a new one; recording.klg and camera.txt are made in it; empty: none"},
              {"max_mib", &s.max_mib, "on disk; then the recording ends, and the run goes on", {1, 1 << 30}},
              {"jpeg_quality", &s.jpeg_quality, "of colour; depth is kept as it is", {1, 100}},
          }};
}

OptionSection lcm_section(LcmSettings& s) {
  return {
      "lcm",
      "Where poses and corrections are published.",
      {
          {"enabled", &s.enabled, "publish at all"},
          {"url", &s.url, "LCM provider; ttl=0 stays on this computer"},
          {"prefix", &s.prefix, "put before every channel name"},
          {"map_rate_mib_s", &s.map_rate_mib_s, "at most, for the map's surfels and graph", {0.01, 10000}},
          {"max_command_age_s",
           &s.max_command_age_s,
           "commands whose time is farther from this host's clock are refused; 0: any time will do",
           {0, 1e6}},
          {"slew_m_per_s",
           &s.slew.max_m_per_s,
           "how fast POSE may move to where a correction has it; 0: it jumps",
           {0, 1000}},
          {"slew_rad_per_s", &s.slew.max_rad_per_s, "the same for rotation", {0, 1000}},
      }};
}

OptionSection memory_section(MemorySettings& s) {
  return {"memory",
          "Memory is fixed before the first frame; --print-budget shows what it is used for.",
          {
              {"cap_mib", &s.cap_mib, "refuse to start when the budget is larger", {1, 1 << 20}},
              {"back_heap_mib",
               &s.back_heap_mib,
               "of the heap for registration, solves and lists of loops, a quarter more is kept for gaps; "
               "what needs "
               "more is refused",
               {4, 1 << 20}},
          }};
}

OptionSection threads_section(ThreadSettings& s) {
  constexpr OptionRange kPriority{0, 98}, kCore{-1, 4095};
  return {"threads",
          "How the threads run. Without the rights for it: normal scheduling, and a warning.",
          {
              {"realtime", &s.realtime, "SCHED_FIFO, from cameras and at rate realtime"},
              {"lock_memory", &s.lock_memory, "no page of the program is ever swapped out"},
              {"capture_priority", &s.capture_priority, "of SCHED_FIFO; 0: normal scheduling", kPriority},
              {"front_priority", &s.front_priority, "tracking and fusion", kPriority},
              {"publish_priority", &s.publish_priority, "messages", kPriority},
              {"capture_core", &s.capture_core, "the only processor it runs on; -1: any", kCore},
              {"front_core", &s.front_core, "the same of tracking and fusion", kCore},
              {"back_core", &s.back_core, "the same of loops and sifting", kCore},
              {"publish_core", &s.publish_core, "the same of messages", kCore},
          }};
}

OptionSection watchdog_section(WatchdogSettings& s) {
  constexpr OptionRange kMilliseconds{0.1, 1e6}, kSeconds{0.1, 1e5};
  return {"watchdog",
          "When a thread is late (counted), and when it hangs.",
          {
              {"capture_deadline_ms", &s.capture_deadline_ms, "waiting for one frame", kMilliseconds},
              {"front_deadline_ms", &s.front_deadline_ms, "tracking and fusing one frame", kMilliseconds},
              {"publish_deadline_ms", &s.publish_deadline_ms, "sending what has come up", kMilliseconds},
              {"back_deadline_ms", &s.back_deadline_ms, "loops of one new piece of the map", kMilliseconds},
              {"front_hung_s", &s.front_hung_s, "then the service manager may restart the program", kSeconds},
              {"back_hung_s", &s.back_hung_s, "then no further loops are looked for", kSeconds},
              {"no_source_s", &s.no_source_s, "without a frame: no source", kSeconds},
              {"stop_s", &s.stop_s, "that a stop by signal waits for loops in work", kSeconds},
          }};
}

void append(OptionTable more, OptionTable* table) {
  for (OptionSection& section : more) table->push_back(std::move(section));
}

/// In the order of the data's way through the program.
OptionTable bind(Settings& s) {
  OptionTable table = {run_section(s.run), camera_section(s.camera), source_section(s.retry),
                       record_section(s.record), replay_section(s.replay)};
  append(driver_sections(s.source), &table);
  append({lcm_odometry_section(s.lcm_odometry)}, &table);
  append(front_end_sections(s.front_end, s.trajectory_odometry), &table);
  append({store_section(s.store)}, &table);
  append(back_end_sections(s.back_end), &table);
  append({lcm_section(s.lcm), memory_section(s.memory), threads_section(s.threads),
          watchdog_section(s.watchdog)},
         &table);
  return table;
}

/// What no single key shows to be wrong. After finalize().
void check_together(const Settings& s, std::vector<std::string>* problems) {
  const auto check = [&](const Status& status) {
    if (!status) problems->push_back(status.error().message);
  };
  if (s.run.odometry != "builtin" && s.run.odometry.rfind("file:", 0) != 0 &&
      s.run.odometry.rfind("lcm:", 0) != 0)
    problems->push_back("run.odometry: \"" + s.run.odometry +
                        "\" is none of builtin, file:TRAJECTORY, lcm:CHANNEL");
  if (s.camera.min_depth_m >= s.camera.max_depth_m) {
    problems->push_back("camera.min_depth_m must be less than camera.max_depth_m");
  } else {
    check(validate(s.front_end.frame));
  }
  check(validate(s.front_end.odometry));
  check(validate(s.front_end.fragment));
  check(validate(s.front_end.model));
  check(validate(s.store));
  check(validate(s.back_end.proposal));
  if (s.store.max_views > kMaxViews)
    problems->push_back("store.max_fragments times fragment.views_per_fragment must be at most " +
                        std::to_string(kMaxViews));
  if (s.lcm.enabled && s.lcm.url.find("://") == std::string::npos)
    problems->push_back("lcm.url: \"" + s.lcm.url + "\" is no provider such as " + LcmSettings{}.url +
                        "; to publish nothing set lcm.enabled = false");
}

}  // namespace

Expected<Settings> load_settings(const std::string& path, const std::vector<std::string>& assignments) {
  Settings settings;
  const OptionTable table = bind(settings);
  std::vector<std::string> problems;
  if (!path.empty()) read_toml_file(path, table, &problems);
  for (const std::string& assignment : assignments) assign(assignment, table, &problems);
  if (!settings.camera.file.empty())
    read_camera_file(settings.camera.file, &settings.source.calibration, &problems);
  finalize(&settings);
  check_together(settings, &problems);
  if (problems.empty()) return settings;
  std::string message;
  for (const std::string& problem : problems) message += (message.empty() ? "" : "\n") + problem;
  return Error{ErrorCode::kUsage, message};
}

void finalize(Settings* settings) {
  Settings& s = *settings;
  FrameOptions& frame = s.front_end.frame;
  OdometryOptions& odometry = s.front_end.odometry;
  FragmentOptions& fragment = s.front_end.fragment;
  PosteriorOptions& posterior = s.back_end.posterior;
  s.source.camera = s.camera.model;
  s.source.depth_scale = s.camera.depth_scale;
  s.source.color_source = s.camera.color_source;
  s.source.rate_hz = s.replay.rate_hz;
  frame.min_depth_m = posterior.min_depth_m = s.camera.min_depth_m;
  frame.max_depth_m = posterior.max_depth_m = s.camera.max_depth_m;
  odometry.noise_floor_m = fragment.noise_floor_m = s.camera.noise_floor_m;
  odometry.noise_slope = fragment.noise_slope = s.camera.noise_slope_per_m;
  s.lcm_odometry.stream.max_gap_s = s.trajectory_odometry.max_gap_s;
  s.lcm_odometry.stream.noise = static_cast<const MotionNoise&>(s.trajectory_odometry);
  s.back_end.proposal.max_fragments = posterior.max_fragments = s.store.max_fragments;
  posterior.max_views_per_fragment = fragment.views_per_fragment;
  s.store.max_views = s.store.max_fragments * fragment.views_per_fragment;
  s.store.max_view_pixels = posterior.max_view_width * posterior.max_view_height;
}

Status check_views(const Settings& settings, const PinholeCamera& camera) {
  if (camera.width <= 0 || camera.height <= 0)
    return Error{ErrorCode::kUsage,
                 "the source gives colour alone; name a depth camera as the source, and this one as "
                 "camera.color_source"};
  const PosteriorOptions& posterior = settings.back_end.posterior;
  const int step = settings.front_end.fragment.view_step;
  const PinholeCamera view = camera.subsampled(step, step / 2);
  if (view.width <= posterior.max_view_width && view.height <= posterior.max_view_height) return {};
  const auto steps = [](int pixels, int most) { return (pixels + most - 1) / most; };
  const int fitting = std::max(steps(camera.width, posterior.max_view_width),
                               steps(camera.height, posterior.max_view_height));
  return Error{ErrorCode::kUsage,
               "fragment.view_step = " + std::to_string(step) + " makes views of " +
                   std::to_string(view.width) + " x " + std::to_string(view.height) +
                   " pixels, larger than posterior.max_view_width and max_view_height; set it to " +
                   std::to_string(fitting)};
}

std::string to_toml(const Settings& settings) {
  Settings copy = settings;
  return "# loopsift settings: every key with its unit, its range and its value.\n\n" + to_toml(bind(copy));
}

}  // namespace loopsift
