// SPDX-License-Identifier: MIT
#include "firmware_app/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "tests/support/temporary_folder.hpp"

namespace loopsift {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// Stands for systemd: a datagram socket, and the two variables.
class ServiceManagerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = folder_ / "notify";
    std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
    socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    ASSERT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  void TearDown() override {
    close(socket_);
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
  }
  std::string received() const {
    char text[256];
    const ssize_t size = recv(socket_, text, sizeof(text), 0);
    return size < 0 ? "" : std::string(text, static_cast<std::size_t>(size));
  }
  test::TemporaryFolder folder_;
  int socket_ = -1;
};

TEST_F(ServiceManagerTest, HearsWhatItIsTold) {
  const ServiceManager manager;
  EXPECT_TRUE(manager.present());
  manager.notify("READY=1");
  EXPECT_EQ(received(), "READY=1");
}

TEST_F(ServiceManagerTest, GetsSignsOfLifeAtHalfItsInterval) {
  setenv("WATCHDOG_USEC", "4000000", 1);
  ServiceManager manager;
  manager.keep_alive(10 * kSecond_ns);
  EXPECT_EQ(received(), "WATCHDOG=1");
  manager.keep_alive(11 * kSecond_ns);
  EXPECT_EQ(received(), "");
  manager.keep_alive(12 * kSecond_ns);
  EXPECT_EQ(received(), "WATCHDOG=1");
}

TEST_F(ServiceManagerTest, ThatDoesNotWatchGetsNone) {
  ServiceManager manager;
  manager.keep_alive(10 * kSecond_ns);
  EXPECT_EQ(received(), "");
}

TEST(NoServiceManager, IsQuietlyNotTold) {
  unsetenv("NOTIFY_SOCKET");
  ServiceManager manager;
  EXPECT_FALSE(manager.present());
  manager.notify("READY=1");
  manager.keep_alive(kSecond_ns);
  setenv("NOTIFY_SOCKET", "/nowhere/at/all", 1);
  EXPECT_FALSE(ServiceManager().present());
  setenv("NOTIFY_SOCKET", std::string(300, 'x').insert(0, "/").c_str(), 1);
  EXPECT_FALSE(ServiceManager().present()) << "longer than a socket's name can be";
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace loopsift
