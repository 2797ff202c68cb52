// SPDX-License-Identifier: MIT
#include "firmware_app/publisher_commands.hpp"

#include <algorithm>
#include <cstdlib>
#include <loopsift/command_t.hpp>

namespace loopsift {
namespace {

using Verdict = CheckedCommand::Verdict;
static_assert(CheckedCommand::kMaxObjects == std::size(command_t{}.object));
static_assert(ChunkWindow::kChunks == 8 * sizeof command_t{}.chunks[0]);
static_assert(command_t::GRAPH == kGraphObject && command_t::LOOPS == kLoopsObject &&
              command_t::STATE == kStateObject);

/// Why the objects of a RESEND, or their absence, are wrong; null when they are right.
const char* objects_problem(const command_t& message, std::int32_t fragment_count) {
  if (message.command != command_t::RESEND)
    return message.n_objects == 0 ? nullptr : "only RESEND names objects";
  if (message.n_objects < 1 || message.n_objects > CheckedCommand::kMaxObjects)
    return "n_objects is not 1 to 32";
  for (int k = 0; k < message.n_objects; ++k) {
    if (message.object[k] < kStateObject || message.object[k] >= fragment_count)
      return "an object is neither a fragment that is there nor GRAPH, LOOPS, STATE";
    if (message.first_chunk[k] < 0) return "a first_chunk is negative";
  }
  return nullptr;
}

ChunkWindow window_of(const command_t& message, int k) {
  ChunkWindow window;
  window.object = message.object[k];
  window.first = message.first_chunk[k];
  for (int bit = 0; bit < ChunkWindow::kChunks; ++bit)
    if ((message.chunks[k][bit / 8] >> (bit % 8) & 1) != 0) window.set(bit);
  return window;
}

}  // namespace

CheckedCommand CommandGate::check(const void* data, std::size_t size, std::int64_t now_us,
                                  std::int32_t fragment_count) {
  CheckedCommand checked;
  command_t message;
  const int expected = message.getEncodedSize();
  if (size != static_cast<std::size_t>(expected) || message.decode(data, 0, expected) != expected)
    return checked;  // kIgnore
  const auto refuse = [&checked](const char* reason) {
    checked.verdict = Verdict::kRefuse;
    checked.reason = reason;
    return checked;
  };
  checked.command = {message.sender, message.number, static_cast<CommandKind>(message.command)};
  if (message.sender == 0) return refuse("sender is 0");
  if (message.command < command_t::SAVE || message.command > command_t::FINISH)
    return refuse("no such command");
  if (message.run != 0 && message.run != run_) return refuse("meant for another run");
  // Compared without a difference that could overflow.
  if (max_age_us_ > 0 && (message.utime < now_us - max_age_us_ || message.utime > now_us + max_age_us_))
    return refuse("too old, or the clocks differ: see lcm.max_command_age_s");
  if (const char* problem = objects_problem(message, fragment_count)) return refuse(problem);

  Sender& from = sender(message.sender, now_us);
  if (message.number < 1 || message.number < from.last_number)
    return refuse("number is not above the last one");
  checked.verdict = message.number == from.last_number ? Verdict::kRepeat : Verdict::kObey;
  from.last_number = message.number;
  checked.window_count = message.n_objects;
  for (int k = 0; k < message.n_objects; ++k)
    checked.windows[static_cast<std::size_t>(k)] = window_of(message, k);
  return checked;
}

CommandGate::Sender& CommandGate::sender(std::int64_t id, std::int64_t now_us) {
  auto found = std::find_if(senders_.begin(), senders_.end(), [id](const Sender& s) { return s.id == id; });
  if (found == senders_.end()) {
    found = std::min_element(senders_.begin(), senders_.end(),
                             [](const Sender& a, const Sender& b) { return a.heard_us < b.heard_us; });
    *found = {id, 0, 0};
  }
  found->heard_us = now_us;
  return *found;
}

}  // namespace loopsift
