// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <string>

#include "loopsift/client/subscriber.hpp"
#include "tools/loopsift_tool/bus/health_screen.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"

namespace loopsift::tool {
namespace {

using Clock = std::chrono::steady_clock;
constexpr const char* kHome = "\033[H\033[J";  // the terminal's, emptied

struct MonitorOptions {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string prefix;
  double seconds = std::numeric_limits<double>::infinity();
  bool once = false;
};

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

std::string pose_line(const client::Subscriber& loopsift) {
  const auto pose = loopsift.pose();
  if (!pose) return "no pose yet\n";
  const auto& p = pose->T_map_body.trans;
  char text[160];
  std::snprintf(text, sizeof text, "pose       %.2f %.2f %.2f m, heading %.0f°, known to %.3f m\n", p[0],
                p[1], p[2], pose->T_map_body.yaw() * 57.29577951308232,
                std::sqrt(pose->covariance[0] + pose->covariance[7] + pose->covariance[14]));
  return text;
}

int monitor(const MonitorOptions& options) {
  lcm::LCM lcm(options.url);
  if (!lcm.good())
    return fail({ErrorCode::kIo, options.url +
                                     ": LCM cannot be opened. For udpm:// a multicast route is needed: ip "
                                     "link set lo multicast on; ip route add 224.0.0.0/4 dev lo"});
  client::SubscriberOptions listening;
  listening.prefix = options.prefix;
  listening.want_map = false;
  const client::Subscriber loopsift(lcm, listening);
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  const Clock::time_point started = Clock::now();
  Clock::time_point shown = started, came = started;
  double uptime_s = -1;
  while (seconds_since(started) < options.seconds) {
    if (lcm.handleTimeout(200) < 0) return fail({ErrorCode::kIo, options.url + ": LCM cannot receive"});
    const bool fresh = loopsift.health() && loopsift.health()->uptime_s != uptime_s;
    if (fresh) came = Clock::now();
    if (fresh) uptime_s = loopsift.health()->uptime_s;
    if (!fresh && seconds_since(shown) < 1) continue;
    shown = Clock::now();
    const std::string screen =
        loopsift.health()
            ? health_screen(*loopsift.health(), seconds_since(came)) + "\n" + pose_line(loopsift)
            : "nothing heard on " + options.prefix + "LOOPSIFT_HEALTH yet\n";
    std::printf("%s%s%s", terminal ? kHome : "", screen.c_str(), terminal ? "" : "\n");
    std::fflush(stdout);
    if (options.once && loopsift.health()) return kExitDone;
  }
  return loopsift.health() ? kExitDone : kExitOther;
}

}  // namespace

void add_monitor_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<MonitorOptions>();
  CLI::App* command = app.add_subcommand(
      "monitor", "Shows how a running loopsift feels, once a second, until it is interrupted");
  command->add_option("--url", options->url, "LCM provider, as lcm.url of the program")
      ->capture_default_str();
  command->add_option("--prefix", options->prefix, "before each channel's name, as lcm.prefix");
  command->add_option("--seconds", options->seconds, "end after so long; exit 1 if nothing was heard")
      ->check(CLI::PositiveNumber);
  command->add_flag("--once", options->once, "end after the first report");
  command->callback([options, exit_code] { *exit_code = monitor(*options); });
}

}  // namespace loopsift::tool
