// SPDX-License-Identifier: MIT
#include "core/pipeline/settings.hpp"

#include "core/pipeline/option_table.hpp"

namespace loopsift {
namespace {

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
  return {"camera",
          "The depth camera. A zero is replaced by what the source says about itself.",
          {
              {"fx", &s.model.fx, "focal length, pixels", {0, 1e5}},
              {"fy", &s.model.fy, "focal length, pixels", {0, 1e5}},
              {"cx", &s.model.cx, "principal point, pixels, pixel centres at integers", {0, 1e5}},
              {"cy", &s.model.cy, "principal point, pixels, pixel centres at integers", {0, 1e5}},
              {"width", &s.model.width, "pixels", {0, 8192}},
              {"height", &s.model.height, "pixels", {0, 8192}},
              {"depth_scale", &s.depth_scale, "raw depth units per metre", {0, 1e6}},
              {"min_depth_m", &s.min_depth_m, "nearer measurements are not used", {0, 100}},
              {"max_depth_m", &s.max_depth_m, "farther measurements are not used", {0, 100}},
          }};
}

OptionSection replay_section(ReplaySettings& s) {
  return {"replay",
          "Recordings.",
          {
              {"rate_hz", &s.rate_hz, "of recordings without time stamps; 0: the usual for them", {0, 1000}},
          }};
}

OptionSection lcm_section(LcmSettings& s) {
  return {"lcm",
          "Where poses and corrections are published.",
          {
              {"enabled", &s.enabled, "publish at all"},
              {"url", &s.url, "LCM provider; ttl=0 stays on this computer"},
              {"prefix", &s.prefix, "put before every channel name"},
          }};
}

OptionSection memory_section(MemorySettings& s) {
  return {"memory",
          "Memory is fixed before the first frame; --print-budget shows what it is used for.",
          {
              {"cap_mib", &s.cap_mib, "refuse to start when the budget is larger", {1, 1 << 20}},
          }};
}

OptionTable bind(Settings& s) {
  return {run_section(s.run), camera_section(s.camera), replay_section(s.replay), lcm_section(s.lcm),
          memory_section(s.memory)};
}

/// What no single key shows to be wrong.
void check_together(const Settings& s, std::vector<std::string>* problems) {
  if (s.run.odometry != "builtin" && s.run.odometry.rfind("file:", 0) != 0 &&
      s.run.odometry.rfind("lcm:", 0) != 0)
    problems->push_back("run.odometry: \"" + s.run.odometry +
                        "\" is none of builtin, file:TRAJECTORY, lcm:CHANNEL");
  if (s.camera.min_depth_m >= s.camera.max_depth_m)
    problems->push_back("camera.min_depth_m must be less than camera.max_depth_m");
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
  check_together(settings, &problems);
  if (problems.empty()) return settings;
  std::string message;
  for (const std::string& problem : problems) message += (message.empty() ? "" : "\n") + problem;
  return Error{ErrorCode::kUsage, message};
}

std::string to_toml(const Settings& settings) {
  Settings copy = settings;
  return "# loopsift settings: every key with its unit, its range and its value.\n\n" + to_toml(bind(copy));
}

}  // namespace loopsift
