// SPDX-License-Identifier: MIT
// The listening thread of the publisher. Not a real-time one: LCM allocates when it receives.
#include "firmware_app/publisher_loop_in.hpp"
#include "firmware_app/publisher_thread.hpp"

namespace loopsift {
namespace {

constexpr int kHearTimeout_ms = 100;
constexpr std::int64_t kNothingToHear_ns = 100'000'000;
constexpr int kWaitingCommands = 64;  // in LCM, while one is looked at

}  // namespace

void Publisher::Impl::listen() {
  const auto handler = [](const lcm_recv_buf_t* received, const char* /*channel*/, void* self) {
    static_cast<Impl*>(self)->receive(*received);
  };
  const std::string channel = settings.prefix + kCommandChannel;
  lcm_subscription_t* subscription = lcm_subscribe(lcm, channel.c_str(), handler, this);
  if (subscription == nullptr) return;
  lcm_subscription_set_queue_capacity(subscription, kWaitingCommands);
  const auto loop_handler = [](const lcm_recv_buf_t* received, const char* /*channel*/, void* self) {
    static_cast<Impl*>(self)->receive_loop(*received);
  };
  const std::string loop_channel = settings.prefix + kLoopInChannel;
  lcm_subscribe(lcm, loop_channel.c_str(), loop_handler, this);
  listen_thread = std::thread([this] { hear(); });
}

void Publisher::Impl::hear() const {
  Semaphore never;
  while (!deaf.load())
    if (lcm_handle_timeout(lcm, kHearTimeout_ms) < 0)  // a provider that only writes
      (void)never.wait_until(steady_now_ns() + kNothingToHear_ns);
}

void Publisher::Impl::receive(const lcm_recv_buf_t& received) {
  const CheckedCommand checked = gate.check(received.data, received.data_size, wall_clock_us(),
                                            fragment_count.load(std::memory_order_relaxed));
  const auto answer_with = [&](AckStatus status, const char* message) {
    queue(acks_heard, answer(checked.command, status, message));
  };
  switch (checked.verdict) {
    case CheckedCommand::Verdict::kIgnore:
      refused.fetch_add(1, std::memory_order_relaxed);
      return;
    case CheckedCommand::Verdict::kRefuse:
      refused.fetch_add(1, std::memory_order_relaxed);
      return answer_with(AckStatus::kRefused, checked.reason);
    case CheckedCommand::Verdict::kRepeat:
      return answer_with(AckStatus::kDone, "was heard before");
    case CheckedCommand::Verdict::kObey:
      break;
  }
  const bool taken = checked.command.kind == CommandKind::kResend ? queue(requests, checked)
                                                                  : queue(commands, checked.command);
  (taken ? obeyed : refused).fetch_add(1, std::memory_order_relaxed);
  if (!taken) answer_with(AckStatus::kRefused, "too many commands are waiting");
}

void Publisher::Impl::receive_loop(const lcm_recv_buf_t& received) {
  OutsideLoop loop;
  if (!parse_loop_in(received.data, received.data_size, &loop) || !loops_in.push(loop))
    refused.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace loopsift
