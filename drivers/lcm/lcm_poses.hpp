// SPDX-License-Identifier: MIT
// Poses that another program publishes as bot_core.pose_t. In: messages. Out: a call for each that is sound,
// on a thread of its own, which lives as long as this object. What cannot be decoded, or is no pose (NaN, a
// quaternion of no length), is counted and left out.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "core/geometry/se3.hpp"
#include "drivers/lcm/lcm_in_options.hpp"

namespace loopsift {

class LcmPoses {
 public:
  /// Time stamp in nanoseconds: the sender's, or of this host's monotonic clock.
  using Sink = std::function<void(std::int64_t timestamp_ns, const Se3& T_local_body)>;

  /// Errors: LCM cannot be opened. Waits for no message.
  [[nodiscard]] static Expected<std::unique_ptr<LcmPoses>> open(const std::string& channel,
                                                                const LcmInOptions& options, Sink sink);
  virtual ~LcmPoses() = default;
  /// Messages left out. Any thread.
  [[nodiscard]] virtual std::int64_t bad() const = 0;
};

/// The pose that a message holds, if it is one.
[[nodiscard]] bool parse_pose(const void* bytes, std::size_t size, std::int64_t* utime_us, Se3* T_local_body);

}  // namespace loopsift
