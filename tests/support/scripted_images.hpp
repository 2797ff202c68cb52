// SPDX-License-Identifier: MIT
// A libcamera camera that is not there: its images come from a script.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "drivers/libcamera/camera_images.hpp"

namespace loopsift::test {

/// One answer to take().
struct ScriptedImage {
  CameraImages::Take result = CameraImages::Take::kImage;
  std::uint32_t count = 0;        ///< the camera's frame number
  std::int64_t timestamp_ns = 0;  ///< 0: none
  bool damaged = false;
};

class ScriptedImages final : public CameraImages {
 public:
  /// Every image has these pixels. After the script the camera is silent.
  ScriptedImages(const CameraImage& image, std::vector<ScriptedImage> script, int* given_back)
      : image_(image), script_(std::move(script)), given_back_(given_back) {}

  [[nodiscard]] Take take(int /*timeout_ms*/, TakenImage* taken) override {
    if (next_ == script_.size()) return Take::kTimeout;
    const ScriptedImage& now = script_[next_++];
    *taken = {0, image_, now.count, now.timestamp_ns, now.damaged};
    return now.result;
  }
  void give_back(const TakenImage& /*taken*/) override { ++*given_back_; }

 private:
  CameraImage image_;
  std::vector<ScriptedImage> script_;
  std::size_t next_ = 0;
  int* given_back_;
};

}  // namespace loopsift::test
