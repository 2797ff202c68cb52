// SPDX-License-Identifier: MIT
// Signs of life for a service manager that speaks sd_notify (systemd): a datagram to the socket that
// NOTIFY_SOCKET names. Without one all of it does nothing. Thread: one. Allocates only when constructed.
#pragma once
#include <cstdint>
#include <string>

namespace loopsift {

class ServiceManager {
 public:
  /// Reads NOTIFY_SOCKET and WATCHDOG_USEC.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// Whether a service manager listens.
  [[nodiscard]] bool present() const { return socket_ >= 0; }
  /// One message, such as "READY=1". Never waits.
  void notify(const char* message) const;
  /// Tells it that the program lives, at half the interval that it asked for. Call as often as you like, and
  /// only while what matters works.
  void keep_alive(std::int64_t now_ns);

 private:
  int socket_ = -1;
  std::int64_t interval_ns_ = 0;  // 0: it does not watch
  std::int64_t told_ns_ = 0;
};

}  // namespace loopsift
