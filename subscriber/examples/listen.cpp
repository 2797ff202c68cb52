// SPDX-License-Identifier: MIT
// listen [URL]: one line a second about the pose, the map and how the program feels; with a second argument,
// writes the map there once it is complete, and ends.
#include <chrono>
#include <cstdio>

#include "loopsift/client/map_ply.hpp"
#include "loopsift/client/subscriber.hpp"

int main(int argc, char** argv) {
  lcm::LCM lcm(argc > 1 ? argv[1] : "");
  if (!lcm.good()) return 1;
  loopsift::client::Subscriber loopsift(lcm);
  auto told = std::chrono::steady_clock::now();
  while (lcm.handleTimeout(50) >= 0) {
    loopsift.poll();
    if (argc > 2 && loopsift.complete()) return loopsift::client::write_ply(argv[2], loopsift.map()) ? 0 : 1;
    if (std::chrono::steady_clock::now() - told < std::chrono::seconds(1)) continue;
    told = std::chrono::steady_clock::now();
    const auto pose = loopsift.pose();
    if (!pose) {
      std::printf("no pose yet\n");
      continue;
    }
    const auto& p = pose->T_map_body.trans;
    std::printf("at %.2f %.2f %.2f m in map, %zu corrections, %zu loops, map of %zu fragments %s\n", p[0],
                p[1], p[2], loopsift.corrections().size(), loopsift.loops().size(),
                loopsift.map().graph().fragments.size(),
                loopsift.map().complete() ? "complete" : "on its way");
    std::fflush(stdout);
  }
  return 1;
}
