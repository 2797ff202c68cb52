// SPDX-License-Identifier: MIT
#include "drivers/libcamera/camera_session.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <mutex>

#include "core/base/steady_time.hpp"

namespace loopsift {
namespace {

// A whole number is an index, anything else a camera's id.
std::shared_ptr<libcamera::Camera> find_camera(libcamera::CameraManager& manager, const std::string& which) {
  std::size_t index = 0;
  const char* const end = which.data() + which.size();
  const auto read = std::from_chars(which.data(), end, index);
  if (read.ec != std::errc() || read.ptr != end) return manager.get(which);
  const std::vector<std::shared_ptr<libcamera::Camera>> cameras = manager.cameras();
  return index < cameras.size() ? cameras[index] : nullptr;
}

std::string offer(const libcamera::StreamConfiguration& stream) {
  std::string text;
  for (const libcamera::PixelFormat& format : stream.formats().pixelformats())
    text += (text.empty() ? "" : ", ") + format.toString();
  return text.empty() ? "nothing" : text;
}

std::string readable_formats() {
  std::string text;
  for (const StreamPixelFormat& known : known_stream_formats())
    text += (text.empty() ? "" : ", ") + known.format.toString();
  return text;
}

YuvRange range_of(const libcamera::StreamConfiguration& stream) {
  const bool full = stream.colorSpace && stream.colorSpace->range == libcamera::ColorSpace::Range::Full;
  return full ? YuvRange::kFull : YuvRange::kLimited;
}

// The manager lives while anyone has a lease; making and ending it exclude each other.
class ManagerLease {
 public:
  ManagerLease() {
    const std::lock_guard<std::mutex> lock(mutex);
    if (leases++ > 0) return;
    if (std::getenv("LIBCAMERA_LOG_LEVELS") == nullptr) libcamera::logSetTarget(libcamera::LoggingTargetNone);
    running = std::make_unique<libcamera::CameraManager>();
    if (running->start() != 0) running.reset();
  }
  ~ManagerLease() {
    const std::lock_guard<std::mutex> lock(mutex);
    if (--leases > 0 || !running) return;
    running->stop();
    running.reset();
  }
  ManagerLease(const ManagerLease&) = delete;
  ManagerLease& operator=(const ManagerLease&) = delete;
  [[nodiscard]] libcamera::CameraManager* manager() const { return running.get(); }

 private:
  static inline std::mutex mutex;
  static inline int leases = 0;
  static inline std::unique_ptr<libcamera::CameraManager> running;
};

}  // namespace

std::shared_ptr<libcamera::CameraManager> shared_camera_manager() {
  const auto lease = std::make_shared<ManagerLease>();
  return {lease, lease->manager()};
}

std::string camera_name(const libcamera::Camera& camera) {
  const auto model = camera.properties().get(libcamera::properties::Model);
  return model ? std::string(*model) : camera.id();
}

Error CameraSession::error(ErrorCode code, const std::string& what) const {
  return {code, "libcamera:" + which_ + ": " + what};
}

Expected<std::unique_ptr<CameraSession>> CameraSession::open(const std::string& which,
                                                             const LibcameraOptions& options) {
  std::unique_ptr<CameraSession> session(new CameraSession(shared_camera_manager()));
  if (Status done = session->acquire(which); !done) return done.error();
  if (Status done = session->configure(options); !done) return done.error();
  if (Status done = session->allocate(); !done) return done.error();
  if (Status done = session->start(options.rate_hz); !done) return done.error();
  return session;
}

CameraSession::~CameraSession() {
  if (!camera_) return;
  if (read_) read_->end();
  if (queueing_.joinable()) queueing_.join();
  (void)camera_->stop();  // of a camera that is gone: fails, no matter
  camera_->requestCompleted.disconnect(this);
  camera_->disconnected.disconnect(this);
  slots_.clear();
  for (const Mapping& mapping : mappings_) ::munmap(mapping.memory, mapping.bytes);
  allocator_.reset();
  (void)camera_->release();
  camera_.reset();  // before the manager
}

Status CameraSession::acquire(const std::string& which) {
  which_ = which;
  if (!manager_) return error(ErrorCode::kIo, "libcamera does not start; LIBCAMERA_LOG_LEVELS=INFO says why");
  std::shared_ptr<libcamera::Camera> camera = find_camera(*manager_, which);
  if (!camera) {
    return error(ErrorCode::kNotFound,
                 "there is no such camera; 'loopsift-tool devices' lists those there are (" +
                     std::to_string(manager_->cameras().size()) + ")");
  }
  if (const int result = camera->acquire(); result != 0) {
    return error(ErrorCode::kIo, std::string("the camera cannot be had: ") + std::strerror(-result) +
                                     (result == -EBUSY ? "; another program uses it" : ""));
  }
  camera_ = std::move(camera);
  return {};
}

Status CameraSession::configure(const LibcameraOptions& options) {
  configuration_ = camera_->generateConfiguration({libcamera::StreamRole::Viewfinder});
  if (!configuration_ || configuration_->empty())
    return error(ErrorCode::kUnsupported, "the camera gives no stream for viewing");
  if (Status chosen = choose_format(options.format); !chosen) return chosen;
  libcamera::StreamConfiguration& stream = configuration_->at(0);
  stream.size = {static_cast<unsigned>(options.width), static_cast<unsigned>(options.height)};
  stream.bufferCount = static_cast<unsigned>(options.buffers);
  const std::string asked = stream.pixelFormat.toString();
  if (configuration_->validate() == libcamera::CameraConfiguration::Invalid)
    return error(ErrorCode::kUnsupported, "the camera has no mode near the one that was asked for");
  pixels_ = find_stream_format(stream.pixelFormat);
  if (stream.pixelFormat.toString() != asked || pixels_ == nullptr) {
    return error(ErrorCode::kUnsupported, "asked for " + asked + ", the camera gives " +
                                              stream.pixelFormat.toString() + "; it has " + offer(stream));
  }
  if (const int result = camera_->configure(configuration_.get()); result != 0)
    return error(ErrorCode::kIo, std::string("cannot be configured: ") + std::strerror(-result));
  const std::size_t row_bytes =
      std::size_t{stream.size.width} * static_cast<std::size_t>(pixels_->bytes_per_pixel);
  if (stream.size.isNull() || stream.stride < row_bytes)
    return error(ErrorCode::kUnsupported, "the camera's rows are shorter than its image");
  return {};
}

// The wanted format, or the first that is read among those that the camera has.
Status CameraSession::choose_format(const std::string& name) {
  libcamera::StreamConfiguration& stream = configuration_->at(0);
  const std::vector<libcamera::PixelFormat> offered = stream.formats().pixelformats();
  for (const StreamPixelFormat& known : known_stream_formats()) {
    const bool has = std::find(offered.begin(), offered.end(), known.format) != offered.end();
    if (!has || (!name.empty() && known.format.toString() != name)) continue;
    stream.pixelFormat = known.format;
    return {};
  }
  return error(ErrorCode::kUnsupported, (name.empty() ? "no format of the camera" : "format '" + name + "'") +
                                            " can be used: it has " + offer(stream) + ", known are " +
                                            readable_formats());
}

Status CameraSession::allocate() {
  libcamera::Stream* stream = this->stream().stream();
  allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
  if (const int result = allocator_->allocate(stream); result < 0)
    return error(ErrorCode::kIo, std::string("gives no buffers: ") + std::strerror(-result));
  for (const std::unique_ptr<libcamera::FrameBuffer>& buffer : allocator_->buffers(stream))
    if (Status added = add_request(buffer.get()); !added) return added;
  completed_ = std::make_unique<RequestHandover>(slots_.size());
  read_ = std::make_unique<RequestHandover>(slots_.size());
  return {};
}

Status CameraSession::add_request(libcamera::FrameBuffer* buffer) {
  Slot slot{camera_->createRequest(slots_.size()), buffer, {}};
  if (!slot.request || slot.request->addBuffer(stream().stream(), buffer) != 0)
    return error(ErrorCode::kIo, "gives no requests");
  if (Status mapped = map(*buffer, &slot.image); !mapped) return mapped;
  slots_.push_back(std::move(slot));
  return {};
}

// Each plane apart, from the start of what its descriptor stands for: an offset need not be a page's.
Status CameraSession::map(const libcamera::FrameBuffer& buffer, CameraImage* image) {
  const libcamera::StreamConfiguration& format = stream();
  const auto& planes = buffer.planes();
  const auto wanted = static_cast<std::size_t>(pixels_->planes);
  if (planes.size() < wanted) return error(ErrorCode::kUnsupported, "its buffers lack a plane");
  std::array<const std::uint8_t*, 2> starts{};
  for (std::size_t k = 0; k < wanted; ++k) {
    const std::size_t rows = k == 0 ? format.size.height : (format.size.height + 1) / 2;
    const std::size_t bytes = planes[k].offset + planes[k].length;
    if (planes[k].length < format.stride * rows)
      return error(ErrorCode::kUnsupported, "its buffers are too small");
    void* memory = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, planes[k].fd.get(), 0);
    if (memory == MAP_FAILED)
      return error(ErrorCode::kIo, std::string("its buffers cannot be mapped: ") + std::strerror(errno));
    mappings_.push_back({memory, bytes});
    starts[k] = static_cast<const std::uint8_t*>(memory) + planes[k].offset;
  }
  *image = {starts[0],
            starts[1],
            format.stride,
            static_cast<int>(format.size.width),
            static_cast<int>(format.size.height),
            range_of(format)};
  return {};
}

Status CameraSession::start(double rate_hz) {
  camera_->requestCompleted.connect(this, &CameraSession::completed);
  camera_->disconnected.connect(this, &CameraSession::disconnected);
  libcamera::ControlList controls(camera_->controls());
  if (rate_hz > 0 && camera_->controls().count(&libcamera::controls::FrameDurationLimits) != 0) {
    const auto period_us = static_cast<std::int64_t>(std::lround(1e6 / rate_hz));
    controls.set(libcamera::controls::FrameDurationLimits,
                 libcamera::Span<const std::int64_t, 2>({period_us, period_us}));
  }
  if (const int result = camera_->start(&controls); result != 0)
    return error(ErrorCode::kIo, std::string("cannot start: ") + std::strerror(-result));
  for (Slot& slot : slots_) {
    if (const int result = camera_->queueRequest(slot.request.get()); result != 0)
      return error(ErrorCode::kIo, std::string("takes no requests: ") + std::strerror(-result));
  }
  queueing_ = std::thread([this] { queue_again(); });
  return {};
}

void CameraSession::completed(libcamera::Request* request) {
  if (!completed_->push(static_cast<std::uint32_t>(request->cookie()))) disconnected();
}

bool CameraSession::is_short(const Slot& slot) const {
  const auto planes = slot.buffer->metadata().planes();
  const std::size_t least = slot.image.stride_bytes * static_cast<std::size_t>(slot.image.height - 1) +
                            static_cast<std::size_t>(slot.image.width * pixels_->bytes_per_pixel);
  return planes.empty() || planes[0].bytesused < least;
}

CameraSession::Take CameraSession::take(int timeout_ms, TakenImage* taken) {
  const std::int64_t deadline_ns = steady_now_ns() + std::int64_t{timeout_ms} * 1'000'000;
  while (cancelled_ < slots_.size()) {
    const RequestHandover::Wait wait = completed_->pop(&taken->request, deadline_ns);
    if (wait == RequestHandover::Wait::kTimeout) return Take::kTimeout;
    if (wait == RequestHandover::Wait::kEnded) return Take::kLost;
    const Slot& slot = slots_[taken->request];
    if (slot.request->status() == libcamera::Request::RequestCancelled) {  // the camera is stopping
      ++cancelled_;
      continue;
    }
    const libcamera::FrameMetadata& metadata = slot.buffer->metadata();
    taken->image = slot.image;
    taken->count = metadata.sequence;
    taken->timestamp_ns = static_cast<std::int64_t>(metadata.timestamp);
    taken->damaged = metadata.status != libcamera::FrameMetadata::FrameSuccess || is_short(slot);
    return Take::kImage;
  }
  return Take::kLost;
}

void CameraSession::give_back(const TakenImage& taken) {
  if (!read_->push(taken.request)) disconnected();  // given back twice
}

// The body of queueing_. A camera that takes no more requests is as good as gone.
void CameraSession::queue_again() {
  constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  std::uint32_t index = 0;
  while (read_->pop(&index, kNever) == RequestHandover::Wait::kRequest) {
    libcamera::Request* request = slots_[index].request.get();
    request->reuse(libcamera::Request::ReuseBuffers);
    if (camera_->queueRequest(request) != 0) disconnected();
  }
}

}  // namespace loopsift
