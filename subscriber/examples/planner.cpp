// SPDX-License-Identifier: MIT
// planner X Y [URL]: drives to a place in map, as far as printing what it would command goes. Ends on
// arrival.
#include <cstdio>
#include <cstdlib>

#include "loopsift/client/subscriber.hpp"
#include "planner.hpp"

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: planner X Y [URL]    metres in map\n");
    return 2;
  }
  lcm::LCM lcm(argc > 3 ? argv[3] : "");
  if (!lcm.good()) return 1;
  loopsift::client::SubscriberOptions options;
  options.want_map = false;
  loopsift::client::Subscriber loopsift(lcm, options);
  loopsift::example::Planner planner;
  planner.set_goal({std::atof(argv[1]), std::atof(argv[2]), 0});

  std::int64_t planned_utime = 0;
  while (lcm.handleTimeout(100) >= 0) {
    loopsift.poll();
    const auto pose = loopsift.pose();
    if (!pose || pose->utime == planned_utime) continue;
    const double dt_s = planned_utime == 0 ? 0.0 : static_cast<double>(pose->utime - planned_utime) * 1e-6;
    planned_utime = pose->utime;
    if (!pose->anchored) {  // where the goal lies from here is not known
      std::printf("lost its place: waits for a loop\n");
      continue;
    }
    const auto command = planner.update(pose->T_odom_body, loopsift.T_map_odom(), dt_s);
    std::printf("epoch %d: forward %.2f m/s, yaw %.2f rad/s, position known to %.3f m\n", pose->epoch,
                command.forward_m_s, command.yaw_rad_s,
                std::sqrt(pose->covariance[0] + pose->covariance[7] + pose->covariance[14]));
    if (command.forward_m_s == 0 && command.yaw_rad_s == 0) return 0;
  }
  return 1;
}
