// SPDX-License-Identifier: MIT
// The gate for what comes in over LCM: bytes from anyone in, checked commands out. Nothing that fails a check
// has any effect but a count and, where its sender can be told, an answer. Thread: the one that receives.
// check() never allocates.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware_app/publisher_records.hpp"
#include "firmware_app/publisher_wanted.hpp"

namespace loopsift {

/// A command that passed, with what a RESEND asks for.
struct CheckedCommand {
  static constexpr int kMaxObjects = 32;

  enum class Verdict {
    kObey,    ///< new, in order, and meant for this run
    kRepeat,  ///< its sender's last one once more: was obeyed already
    kRefuse,  ///< `reason` says why; command says whom to answer
    kIgnore,  ///< cannot be decoded: nobody to answer
  };
  Verdict verdict = Verdict::kIgnore;
  const char* reason = "";
  Command command;
  std::array<ChunkWindow, kMaxObjects> windows;  ///< the first window_count are valid
  int window_count = 0;
};

class CommandGate {
 public:
  /// run: this run's number. max_age_us: how far a command's time may be from the host's clock; 0: any.
  CommandGate(std::int64_t run, std::int64_t max_age_us) : run_(run), max_age_us_(max_age_us) {}

  /// now_us: the host's clock. fragment_count: fragments that can be had now.
  [[nodiscard]] CheckedCommand check(const void* data, std::size_t size, std::int64_t now_us,
                                     std::int32_t fragment_count);

 private:
  struct Sender {
    std::int64_t id = 0;
    std::int32_t last_number = 0;
    std::int64_t heard_us = 0;
  };
  [[nodiscard]] Sender& sender(std::int64_t id, std::int64_t now_us);

  std::int64_t run_, max_age_us_;
  std::array<Sender, 32> senders_;  // the one not heard for longest makes room for a new one
};

}  // namespace loopsift
