// SPDX-License-Identifier: MIT
#include "drivers/openni2/session.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

namespace loopsift::openni2 {
namespace {

std::mutex& life_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

std::string last_error() {
  std::string text = openni::OpenNI::getExtendedError();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

Session::Session() {
  const std::lock_guard lock(life_mutex());
  if (openni::OpenNI::initialize() == openni::STATUS_OK) return;
  status_ = Error{ErrorCode::kIo, "OpenNI2 does not start: " + last_error() +
                                      " (its drivers are named in /etc/openni2/OpenNI.ini)"};
}

Session::~Session() {
  const std::lock_guard lock(life_mutex());
  if (status_.ok()) openni::OpenNI::shutdown();
}

void Session::keep() {
  static const auto* to_the_end =
      new Session;  // never deleted: the end of the process must not shut down either
  (void)to_the_end;
}

DeviceWatch::DeviceWatch(std::string uri) : uri_(std::move(uri)) {
  (void)openni::OpenNI::addDeviceDisconnectedListener(this);  // fails only for a listener that is there
  (void)openni::OpenNI::addDeviceStateChangedListener(this);
}

DeviceWatch::~DeviceWatch() {
  openni::OpenNI::removeDeviceDisconnectedListener(this);
  openni::OpenNI::removeDeviceStateChangedListener(this);
}

void DeviceWatch::onDeviceDisconnected(const openni::DeviceInfo* device) {
  if (uri_ == device->getUri()) gone_ = true;
}

void DeviceWatch::onDeviceStateChanged(const openni::DeviceInfo* device, openni::DeviceState state) {
  if (uri_ != device->getUri()) return;
  if (state == openni::DEVICE_STATE_ERROR) failed_ = true;
  if (state == openni::DEVICE_STATE_EOF) over_ = true;
}

}  // namespace loopsift::openni2
