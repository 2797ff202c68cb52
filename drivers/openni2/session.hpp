// SPDX-License-Identifier: MIT
// OpenNI2's life in this process, and news of one device. Set-up only.
#pragma once
#include <openni2/OpenNI.h>

#include <atomic>
#include <string>

#include "core/base/result.hpp"

namespace loopsift::openni2 {

/// OpenNI2 is initialised while any Session lives; it looks for devices anew when the first one begins.
///
/// It remembers every thread that has called it, and asks after all of them (pthread_kill) when a new one
/// calls: that crashes once the stack of one that has ended is gone. glibc keeps 40 MB of ended threads'
/// stacks, so a program that opens and closes cameras again and again gives its threads small stacks by
/// default (loopsift does), and lets whoever calls OpenNI2 live as long as it can.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  /// Whether OpenNI2 found its drivers.
  [[nodiscard]] const Status& status() const { return status_; }
  /// Keeps OpenNI2 until the process is gone, for two faults of its shutdown. It waits for a driver's thread
  /// with the lock that the thread needs in order to tell of a device: a driver that has told of an unplugged
  /// one will tell of its return, too. And it unloads the driver of recordings while a cancelled thread still
  /// runs there.
  static void keep();

 private:
  Status status_;
};

/// What OpenNI2 says about its last failure, on one line; empty when nothing.
[[nodiscard]] std::string last_error();

/// Hears when the device with this URI is unplugged or fails, and when a recording is over. OpenNI2 calls on
/// threads of its own; only flags are set there.
class DeviceWatch final : public openni::OpenNI::DeviceDisconnectedListener,
                          public openni::OpenNI::DeviceStateChangedListener {
 public:
  /// Within a Session.
  explicit DeviceWatch(std::string uri);
  ~DeviceWatch() override;
  DeviceWatch(const DeviceWatch&) = delete;
  DeviceWatch& operator=(const DeviceWatch&) = delete;

  [[nodiscard]] bool is_gone() const { return gone_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool has_failed() const { return failed_.load(std::memory_order_relaxed); }
  [[nodiscard]] bool is_over() const { return over_.load(std::memory_order_relaxed); }

 private:
  void onDeviceDisconnected(const openni::DeviceInfo* device) override;
  void onDeviceStateChanged(const openni::DeviceInfo* device, openni::DeviceState state) override;

  const std::string uri_;
  std::atomic<bool> gone_{false}, failed_{false}, over_{false};
};

}  // namespace loopsift::openni2
