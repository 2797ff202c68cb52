// SPDX-License-Identifier: MIT
// A subscriber who comes late: lcm_late_join URL FILE LIMIT_S [MALFORMED] rebuilds all state, writes the map
// to FILE, sends so many malformed commands, which must change nothing, has the program save its own map, and
// ends it. Prints what came and how long it took. Exit 0 when all was complete within the limit.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

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
  for (int attempt = 0; attempt < 15; ++attempt) {
    const std::int32_t number = loopsift.send(command);
    for (const auto sent = Clock::now(); seconds_since(sent) < 2;) {
      lcm.handleTimeout(50);
      const auto answer = loopsift.answer(number);
      if (answer && answer->status == ack_t::DONE) return true;
    }
  }
  return false;
}

/// Until all that the program has is here, or the limit.
bool completed(lcm::LCM& lcm, client::Subscriber& loopsift, double limit_s) {
  const auto started = Clock::now();
  while (!(loopsift.complete() && loopsift.pose()) && seconds_since(started) < limit_s) {
    lcm.handleTimeout(20);
    loopsift.poll();
  }
  return loopsift.complete();
}

/// Nothing changes any more: no frame comes in, and the back thread has nothing to do.
bool stands_still(lcm::LCM& lcm, client::Subscriber& loopsift, double limit_s) {
  const auto started = Clock::now();
  const auto still = [&loopsift] {
    return loopsift.health()->paused != 0 && loopsift.health()->back_backlog == 0;
  };
  while (!still() && seconds_since(started) < limit_s) lcm.handleTimeout(20);
  const double uptime_s = loopsift.health()->uptime_s;  // once more: what was sent before it is in by then
  while (loopsift.health()->uptime_s == uptime_s && seconds_since(started) < limit_s) lcm.handleTimeout(20);
  return still() && completed(lcm, loopsift, limit_s);
}

std::vector<std::uint8_t> malformed(std::mt19937& random, std::int64_t run) {
  command_t command{};
  command.run = run + 1;  // right in form, but for another run
  command.sender = 5;
  command.number = 1;
  command.command = command_t::FINISH;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(command.getEncodedSize()));
  command.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  switch (random() % 4) {
    case 0:
      bytes.resize(random() % 100'000);
      break;
    case 1:
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
      break;
    case 2:
      bytes[random() % 8] ^= 0x40;
      break;
    default:
      break;
  }
  return bytes;
}

/// Health that came after now; what it says about commands.
std::int64_t commands_obeyed(lcm::LCM& lcm, const client::Subscriber& loopsift) {
  const double uptime_s = loopsift.health()->uptime_s;
  for (const auto began = Clock::now(); seconds_since(began) < 5 && loopsift.health()->uptime_s == uptime_s;)
    lcm.handleTimeout(50);
  return loopsift.health()->commands_obeyed;
}

/// Whether the program is as it was after them.
bool survives(lcm::LCM& lcm, client::Subscriber& loopsift, int messages) {
  const std::int64_t before = commands_obeyed(lcm, loopsift);
  std::mt19937 random(9);
  for (int i = 0; i < messages; ++i) {
    const std::vector<std::uint8_t> bytes = malformed(random, loopsift.run());
    lcm.publish("LOOPSIFT_COMMAND", bytes.data(), static_cast<unsigned int>(bytes.size()));
    lcm.handleTimeout(0);
  }
  const std::int64_t obeyed = commands_obeyed(lcm, loopsift);
  std::printf("%d malformed commands: %ld obeyed, %ld refused by then, run %s\n", messages,
              static_cast<long>(obeyed - before), static_cast<long>(loopsift.health()->commands_refused),
              loopsift.runs_seen() == 1 ? "the same" : "ANOTHER");
  return obeyed == before && loopsift.runs_seen() == 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: lcm_late_join URL FILE LIMIT_S [MALFORMED]\n");
    return 2;
  }
  const auto started = Clock::now();
  lcm::LCM lcm(argv[1]);
  if (!lcm.good()) return 1;
  client::Subscriber loopsift(lcm);
  const double limit_s = std::atof(argv[3]);
  const bool complete = completed(lcm, loopsift, limit_s);
  const double elapsed_s = seconds_since(started);
  std::size_t surfels = 0;
  loopsift.map().for_each_surfel([&surfels](const client::Surfel&, std::int32_t) { ++surfels; });
  std::printf(
      "%s after %.2f s: %zu fragments, %zu surfels, %zu nodes, %zu edges, %zu loops, epoch %d, %ld chunks\n",
      complete ? "complete" : "NOT complete", elapsed_s, loopsift.map().graph().fragments.size(), surfels,
      loopsift.map().graph().nodes.size(), loopsift.map().graph().edges.size(), loopsift.loops().size(),
      loopsift.corrections().empty() ? 0 : loopsift.corrections().back().epoch,
      static_cast<long>(loopsift.map().chunks_received()));
  const bool still =
      complete && obeyed(lcm, loopsift, command_t::PAUSE) && stands_still(lcm, loopsift, limit_s);
  if (!client::write_ply(argv[2], loopsift.map())) return 1;
  const bool survived = argc < 5 || (complete && survives(lcm, loopsift, std::atoi(argv[4])));
  const bool saved = obeyed(lcm, loopsift, command_t::SAVE);
  const bool finished = obeyed(lcm, loopsift, command_t::FINISH);
  std::printf("stood still: %d, saved: %d, finished: %d, refused: %ld\n", still ? 1 : 0, saved ? 1 : 0,
              finished ? 1 : 0, static_cast<long>(loopsift.refused()));
  return still && survived && saved ? 0 : 1;
}
