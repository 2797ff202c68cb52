// SPDX-License-Identifier: MIT
// A bad link between two buses: lcm_relay PORT_A PORT_B LOSS passes LCM's datagrams between two ports of the
// usual multicast group, in both directions, and loses each IP packet of 1480 bytes that they are made of
// with probability LOSS (a datagram is lost with any of them). Until SIGTERM; then prints what it passed and
// lost.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

namespace {

volatile std::sig_atomic_t stop_requested = 0;
void request_stop(int /*signal*/) { stop_requested = 1; }

constexpr const char* kGroup = "239.255.76.67";
constexpr std::size_t kPacketBytes = 1480;

sockaddr_in address(const char* host, int port) {
  sockaddr_in made{};
  made.sin_family = AF_INET;
  made.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, host, &made.sin_addr);
  return made;
}

/// Hears the group at a port.
int open_ear(int port) {
  const int ear = socket(AF_INET, SOCK_DGRAM, 0);
  const int on = 1, bytes = 4 << 20;
  setsockopt(ear, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  setsockopt(ear, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on);
  setsockopt(ear, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes);
  const sockaddr_in any = address("0.0.0.0", port);
  if (bind(ear, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) std::perror("bind");
  ip_mreq request{};
  inet_pton(AF_INET, kGroup, &request.imr_multiaddr);
  if (setsockopt(ear, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) != 0) std::perror("join");
  return ear;
}

/// Speaks to it; bound, so that what it says is known when it is heard again.
int open_mouth(in_port_t* own_port) {
  const int mouth = socket(AF_INET, SOCK_DGRAM, 0);
  const sockaddr_in any = address("0.0.0.0", 0);
  if (bind(mouth, reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) std::perror("bind");
  sockaddr_in bound{};
  socklen_t size = sizeof bound;
  getsockname(mouth, reinterpret_cast<sockaddr*>(&bound), &size);
  *own_port = bound.sin_port;
  const unsigned char ttl = 0;
  setsockopt(mouth, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  return mouth;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: lcm_relay PORT_A PORT_B LOSS\n");
    return 2;
  }
  std::signal(SIGTERM, request_stop);
  const std::array<int, 2> ports = {std::atoi(argv[1]), std::atoi(argv[2])};
  const double loss = std::atof(argv[3]);
  std::array<in_port_t, 2> own{};
  std::array<int, 2> mouths{};
  std::array<pollfd, 2> ears{};
  for (std::size_t side = 0; side < 2; ++side) {
    ears[side] = {open_ear(ports[side]), POLLIN, 0};
    mouths[side] = open_mouth(&own[side]);
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform;
  const auto survives = [&](std::size_t bytes) {
    for (std::size_t sent = 0; sent < bytes; sent += kPacketBytes)
      if (uniform(random) < loss) return false;
    return true;
  };
  std::printf("listening\n");
  std::fflush(stdout);
  long passed = 0, lost = 0;
  std::vector<char> datagram(65'536);
  while (stop_requested == 0) {
    if (poll(ears.data(), ears.size(), 100) <= 0) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      if ((ears[side].revents & POLLIN) == 0) continue;
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t bytes = recvfrom(ears[side].fd, datagram.data(), datagram.size(), 0,
                                     reinterpret_cast<sockaddr*>(&from), &size);
      if (bytes <= 0 || from.sin_port == own[0] || from.sin_port == own[1]) continue;
      if (!survives(static_cast<std::size_t>(bytes))) {
        ++lost;
        continue;
      }
      const sockaddr_in to = address(kGroup, ports[1 - side]);
      sendto(mouths[1 - side], datagram.data(), static_cast<std::size_t>(bytes), 0,
             reinterpret_cast<const sockaddr*>(&to), sizeof to);
      ++passed;
    }
  }
  std::printf("%ld datagrams passed, %ld lost\n", passed, lost);
  return 0;
}
