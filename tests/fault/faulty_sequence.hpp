// SPDX-License-Identifier: MIT
// A rendered walk round a room at 320 × 240 whose frames can be spoilt before the front end sees them.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/fragment/front_end.hpp"
#include "drivers/synth/synth_sequence.hpp"

namespace loopsift::test {

class FaultySequence {
 public:
  explicit FaultySequence(const char* scene = "room?frames=260&width=320&height=240") {
    auto sequence = make_synth_sequence(scene, {});
    EXPECT_TRUE(sequence.ok());
    camera_ = sequence->settings.camera;
    unit_m_ = sequence->settings.noise.depth_unit_m;
    truth_ = sequence->trajectory;
    auto renderer = SequenceRenderer::create(*sequence);
    EXPECT_TRUE(renderer.ok());
    renderer_ = std::move(*renderer);
    depth_.resize(static_cast<std::size_t>(camera_.width * camera_.height));
    color_.resize(depth_.size());
    options_.frame.reduction = 2;
    options_.fragment.view_step = 8;
    options_.fragment.frames_per_fragment = 30;
    Arena measuring;
    const FragmentStore unused_store(StoreOptions(), measuring);
    const FrontEnd unused(camera_, unit_m_, options_, nullptr, measuring);
    arena_ = std::make_unique<Arena>(measuring.used_bytes());
    store_ = std::make_unique<FragmentStore>(StoreOptions(), *arena_);
    front_end_ = std::make_unique<FrontEnd>(camera_, unit_m_, options_, store_.get(), *arena_);
  }

  // Frame k as the camera sees it, to be spoilt; its buffers live until the next call.
  RawFrame frame(int k) {
    RawFrame raw;
    raw.depth = {depth_.data(), camera_.width, camera_.height};
    raw.color = {color_.data(), camera_.width, camera_.height};
    const auto index = static_cast<std::size_t>(k);
    renderer_->render(index, &scratch_, raw.depth, raw.color);
    raw.timestamp_ns = std::llround(renderer_->time_s(index) * 1e9);
    raw.sequence = k;
    return raw;
  }
  FrontEndResult see(const RawFrame& raw) {
    const FrontEndResult result = front_end_->process(raw);
    if (result.tracking.status == TrackingStatus::kFirst) {
      piece_begin_ = static_cast<std::size_t>(raw.sequence);
      T_odom_piece_ = result.tracking.T_odom_camera;
    }
    return result;
  }
  FrontEndResult see(int k) { return see(frame(k)); }
  // Tracks frames [begin, end), all of which must be tracked.
  void track(int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const FrontEndResult result = see(k);
      ASSERT_NE(result.tracking.status, TrackingStatus::kLost)
          << k << ": " << to_string(result.tracking.reason);
    }
  }
  void fill_depth(std::uint16_t raw) { std::fill(depth_.begin(), depth_.end(), raw); }
  void brighten(double gain) {
    for (Rgb8& c : color_)
      for (unsigned char* value : {&c.r, &c.g, &c.b})
        *value = static_cast<unsigned char>(std::min(255.0, gain * *value));
  }
  // How far a pose is from the truth, metres, since the present piece of trajectory began.
  double error_m(int k, const Se3& T_odom_camera) const {
    const Se3 truth = truth_.poses[piece_begin_].T_world_camera.inverse() *
                      truth_.poses[static_cast<std::size_t>(k)].T_world_camera;
    const Se3 found = T_odom_piece_.inverse() * T_odom_camera;
    return (truth.inverse() * found).translation().norm();
  }
  const Se3& truth(std::size_t k) const { return truth_.poses[k].T_world_camera; }
  FragmentStore& store() { return *store_; }
  FrontEnd& front_end() { return *front_end_; }
  const FrontEndOptions& options() const { return options_; }

 private:
  PinholeCamera camera_;
  double unit_m_ = 0;
  Trajectory truth_;
  std::unique_ptr<SequenceRenderer> renderer_;
  RenderedFrame scratch_;
  std::vector<std::uint16_t> depth_;
  std::vector<Rgb8> color_;
  FrontEndOptions options_;
  std::unique_ptr<Arena> arena_;
  std::unique_ptr<FragmentStore> store_;
  std::unique_ptr<FrontEnd> front_end_;
  std::size_t piece_begin_ = 0;
  Se3 T_odom_piece_;
};

}  // namespace loopsift::test
