// SPDX-License-Identifier: MIT
// RunHealth as a message. Thread: publish. Allocates when the message is made, never when it is filled.
#pragma once
#include <loopsift/health_t.hpp>

#include "firmware_app/run_health.hpp"

namespace loopsift {

/// A message with room for every name.
[[nodiscard]] health_t make_health_message();
/// What RunHealth says; utime, run and the publisher's own counts are left to the caller.
void fill(health_t* message, const RunHealth& health);

}  // namespace loopsift
