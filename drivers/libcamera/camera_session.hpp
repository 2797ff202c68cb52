// SPDX-License-Identifier: MIT
// One libcamera camera from acquiring to letting go: configuration, buffers, requests going round. In: a
// camera's index or id. Out: its images as they lie in the camera's buffers, one at a time. Threads: open,
// take, give_back and the destructor belong to one reader; libcamera calls back from a thread of its own,
// which only passes the number of a request on; a third thread queues requests again, because libcamera
// allocates there. take() and give_back() allocate nothing.
#pragma once
#include <libcamera/libcamera.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.hpp"
#include "drivers/libcamera/camera_images.hpp"
#include "drivers/libcamera/libcamera_options.hpp"
#include "drivers/libcamera/request_handover.hpp"

namespace loopsift {

/// libcamera's manager, of which a process may have one at a time: shared by all that hold one. Null if it
/// does not start. Any thread.
[[nodiscard]] std::shared_ptr<libcamera::CameraManager> shared_camera_manager();
/// What the camera calls itself: its model, else its id.
[[nodiscard]] std::string camera_name(const libcamera::Camera& camera);

class CameraSession final : public CameraImages {
 public:
  /// Errors: no such camera, in use, a format that it has not or we do not read, no buffers.
  [[nodiscard]] static Expected<std::unique_ptr<CameraSession>> open(const std::string& which,
                                                                     const LibcameraOptions& options);
  ~CameraSession() override;
  CameraSession(const CameraSession&) = delete;
  CameraSession& operator=(const CameraSession&) = delete;

  [[nodiscard]] Take take(int timeout_ms, TakenImage* taken) override;
  void give_back(const TakenImage& taken) override;
  [[nodiscard]] const libcamera::StreamConfiguration& stream() const { return configuration_->at(0); }
  [[nodiscard]] const libcamera::Camera& camera() const { return *camera_; }

 private:
  struct Mapping {
    void* memory;
    std::size_t bytes;
  };
  struct Slot {
    std::unique_ptr<libcamera::Request> request;
    libcamera::FrameBuffer* buffer;
    CameraImage image;
  };

  explicit CameraSession(std::shared_ptr<libcamera::CameraManager> manager) : manager_(std::move(manager)) {}
  [[nodiscard]] Error error(ErrorCode code, const std::string& what) const;
  [[nodiscard]] Status acquire(const std::string& which);
  [[nodiscard]] Status configure(const LibcameraOptions& options);
  [[nodiscard]] Status choose_format(const std::string& name);
  [[nodiscard]] Status allocate();
  [[nodiscard]] Status add_request(libcamera::FrameBuffer* buffer);
  [[nodiscard]] Status map(const libcamera::FrameBuffer& buffer, CameraImage* image);
  [[nodiscard]] Status start(double rate_hz);
  [[nodiscard]] bool is_short(const Slot& slot) const;
  void completed(libcamera::Request* request);
  void disconnected() { completed_->end(); }
  void queue_again();

  std::string which_;
  std::shared_ptr<libcamera::CameraManager> manager_;
  std::shared_ptr<libcamera::Camera> camera_;  // acquired, once set
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  const StreamPixelFormat* pixels_ = nullptr;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::vector<Mapping> mappings_;
  std::vector<Slot> slots_;
  std::unique_ptr<RequestHandover> completed_;  // to the reader
  std::unique_ptr<RequestHandover> read_;       // to the thread that queues them again
  std::thread queueing_;
  std::size_t cancelled_ = 0;  // requests that the camera gave up; all: nothing can come
};

}  // namespace loopsift
