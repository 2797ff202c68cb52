// SPDX-License-Identifier: MIT
#include "firmware_app/service_manager.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace loopsift {

ServiceManager::ServiceManager() {
  const char* path = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  if (path == nullptr || (path[0] != '/' && path[0] != '@')) return;
  const std::size_t length = std::strlen(path);
  if (length >= sizeof(address.sun_path)) return;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path, length);
  if (path[0] == '@') address.sun_path[0] = '\0';  // the abstract name space
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0) return;
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
    ::close(socket_);
    socket_ = -1;
    return;
  }
  if (const char* interval_us = std::getenv("WATCHDOG_USEC"))
    interval_ns_ = std::strtoll(interval_us, nullptr, 10) * 1000;
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceManager::notify(const char* message) const {
  if (socket_ >= 0) (void)::send(socket_, message, std::strlen(message), MSG_NOSIGNAL);
}

void ServiceManager::keep_alive(std::int64_t now_ns) {
  if (interval_ns_ <= 0 || now_ns - told_ns_ < interval_ns_ / 2) return;
  told_ns_ = now_ns;
  notify("WATCHDOG=1");
}

}  // namespace loopsift
