// SPDX-License-Identifier: MIT
// A subscriber who comes late: lcm_late_join URL FILE LIMIT_S rebuilds all state, writes the map to FILE, has
// the program save its own, and ends it. Prints what came and how long it took. Exit 0 when all was complete
// within the limit.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "loopsift/client/map_ply.hpp"
#include "loopsift/client/subscriber.hpp"

namespace {

using namespace loopsift;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

/// Sends a command until it is answered by DONE.
bool obeyed(lcm::LCM& lcm, client::Subscriber& loopsift, std::int8_t command) {
  for (int attempt = 0; attempt < 40; ++attempt) {
    const std::int32_t number = loopsift.send(command);
    for (const auto sent = Clock::now(); seconds_since(sent) < 0.5;) {
      lcm.handleTimeout(50);
      const auto answer = loopsift.answer(number);
      if (answer && answer->status == ack_t::DONE) return true;
    }
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: lcm_late_join URL FILE LIMIT_S\n");
    return 2;
  }
  const auto started = Clock::now();
  lcm::LCM lcm(argv[1]);
  if (!lcm.good()) return 1;
  client::Subscriber loopsift(lcm);
  while (!(loopsift.complete() && loopsift.pose()) && seconds_since(started) < std::atof(argv[3])) {
    lcm.handleTimeout(20);
    loopsift.poll();
  }
  const double elapsed_s = seconds_since(started);
  const bool complete = loopsift.complete();
  std::size_t surfels = 0;
  loopsift.map().for_each_surfel([&surfels](const client::Surfel&, std::int32_t) { ++surfels; });
  std::printf(
      "%s after %.2f s: %zu fragments, %zu surfels, %zu nodes, %zu edges, %zu loops, epoch %d, %ld chunks\n",
      complete ? "complete" : "NOT complete", elapsed_s, loopsift.map().graph().fragments.size(), surfels,
      loopsift.map().graph().nodes.size(), loopsift.map().graph().edges.size(), loopsift.loops().size(),
      loopsift.corrections().empty() ? 0 : loopsift.corrections().back().epoch,
      static_cast<long>(loopsift.map().chunks_received()));
  if (!client::write_ply(argv[2], loopsift.map())) return 1;
  const bool saved = obeyed(lcm, loopsift, command_t::SAVE);
  const bool finished = obeyed(lcm, loopsift, command_t::FINISH);
  std::printf("saved: %d, finished: %d, refused: %ld\n", saved ? 1 : 0, finished ? 1 : 0,
              static_cast<long>(loopsift.refused()));
  return complete && saved ? 0 : 1;
}
