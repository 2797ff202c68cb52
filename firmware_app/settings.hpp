// SPDX-License-Identifier: MIT
// Everything that can be set, with its default. In: a TOML file and `key=value` assignments. Out: Settings,
// or all problems in one message. An option of a stage is a member of that stage's options struct and one
// line in settings.cpp; config/default.toml is to_toml(Settings{}) word for word (`loopsift --check-config`).
// Thread: set-up only; afterwards read-only. Allocates.
#pragma once
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/fragment/front_end.hpp"
#include "core/geometry/camera.hpp"
#include "core/odometry/trajectory_odometry.hpp"
#include "core/pipeline/back_end.hpp"
#include "core/pipeline/slew.hpp"
#include "drivers/frame_source.hpp"
#include "firmware_app/given_odometry.hpp"
#include "firmware_app/record_options.hpp"
#include "firmware_app/retry_options.hpp"

namespace loopsift {

enum class Rate {
  kRealtime,  ///< recordings are played at their time stamps; frames are dropped when we are late
  kMax,       ///< as fast as we can; nothing is dropped, the same input gives the same output
};

enum class LogLevel { kDebug, kInfo, kWarning, kError };

struct RunSettings {
  std::string source;  ///< URI of the depth camera or recording; empty: must come from elsewhere
  std::string odometry = "builtin";  ///< "builtin", "file:PATH" or "lcm:CHANNEL"
  std::string out;                   ///< folder for the results; empty: none are written
  Rate rate = Rate::kRealtime;
  LogLevel log_level = LogLevel::kInfo;
};

struct CameraSettings {
  PinholeCamera model;       ///< members that are 0 are taken from the source
  double depth_scale = 0;    ///< raw units per metre; 0: from the source
  std::string file;          ///< the sensor's calibration (camera_file.hpp); empty: none
  std::string color_source;  ///< URI of the camera that gives the colour; empty: the source itself
  float min_depth_m = FrameOptions{}.min_depth_m;
  float max_depth_m = FrameOptions{}.max_depth_m;
  float noise_floor_m = OdometryOptions{}.noise_floor_m;  ///< σ(z) as in OdometryOptions
  float noise_slope_per_m = OdometryOptions{}.noise_slope;
};

struct ReplaySettings {
  double rate_hz = 0;  ///< of recordings without time stamps; 0: what the source takes for usual
};

struct LcmSettings {
  bool enabled = true;
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string prefix;             ///< put before every channel name
  double map_rate_mib_s = 16;     ///< at most, for the map's chunks
  double max_command_age_s = 10;  ///< how far a command's time may be from this host's clock; 0: any
  SlewOptions slew;               ///< of POSE after a correction
};

struct MemorySettings {
  int cap_mib = 256;
  int back_heap_mib = 20;  ///< what the back thread may hold of the heap: registration, solves, its lists
};

/// How the threads run. Priorities are SCHED_FIFO's, 0 is normal scheduling; a core of −1 is any.
struct ThreadSettings {
  bool realtime = true;     ///< ask for SCHED_FIFO; only for live sources and at rate realtime
  bool lock_memory = true;  ///< keep all pages in memory
  int capture_priority = 30;
  int front_priority = 20;
  int publish_priority = 10;
  int capture_core = -1;
  int front_core = -1;
  int back_core = -1;
  int publish_core = -1;
};

/// When a thread is late, and when it is given up.
struct WatchdogSettings {
  double capture_deadline_ms = 100;  ///< from asking the source for a frame to having it
  double front_deadline_ms = 33;     ///< one frame
  double publish_deadline_ms = 33;   ///< all messages of one wake-up
  double back_deadline_ms = 5000;    ///< one new piece of the map
  double front_hung_s = 10;          ///< one frame; past it the service manager gets no sign of life
  double back_hung_s = 120;          ///< in one step or before it; past it the back thread is disabled
  double no_source_s = 2;            ///< without a frame
  double stop_s = 1.0;               ///< that a stop by signal waits for the back thread
};

struct Settings {
  RunSettings run;
  CameraSettings camera;
  ReplaySettings replay;
  RetryOptions retry;
  RecordOptions record;
  SourceOptions source;  ///< the drivers' own sections; finalize() fills in the rest
  FrontEndOptions front_end;
  TrajectoryOdometryOptions trajectory_odometry;
  LcmOdometryOptions lcm_odometry;
  StoreOptions store;
  BackEndOptions back_end;
  LcmSettings lcm;
  MemorySettings memory;
  ThreadSettings threads;
  WatchdogSettings watchdog;
};

/// Defaults, then the file (path may be empty), then the assignments `section.key=value` in order. An Error
/// of kUsage lists every problem, one a line: unknown keys with the nearest valid one, wrong types, values
/// out of range, contradictions.
[[nodiscard]] Expected<Settings> load_settings(const std::string& path,
                                               const std::vector<std::string>& assignments);

/// Copies what one key says to every struct that needs it: the camera's model to the source, its depth range
/// and noise to the stages, store.max_fragments to scorer and proposer, the size and number of views to the
/// store. load_settings does it last; who fills a Settings by hand does it before use.
void finalize(Settings* settings);

/// Whether the views of this camera fit the scorer's; an Error of kUsage says which key to set to what.
[[nodiscard]] Status check_views(const Settings& settings, const PinholeCamera& camera);

/// Every key with its comment and value, as TOML.
[[nodiscard]] std::string to_toml(const Settings& settings);

}  // namespace loopsift
