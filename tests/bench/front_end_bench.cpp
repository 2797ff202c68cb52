// SPDX-License-Identifier: MIT
// The front end's kernels, and whole frames at 640 × 480 and 320 × 240, on a rendered room.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "core/fragment/front_end.hpp"
#include "core/frame/intensity.hpp"
#include "core/frame/kernels.hpp"
#include "core/odometry/depth_calibration.hpp"
#include "core/odometry/icp.hpp"
#include "core/odometry/photometric.hpp"
#include "core/odometry/rotation_alignment.hpp"
#include "tests/support/analytic_scene.hpp"

namespace loopsift {
namespace {

using test::AnalyticScene;
using test::SceneCamera;
using test::shifted;

PinholeCamera camera_of(int width) {
  const float s = static_cast<float>(width) / 640.0F;
  return {width, width * 3 / 4, 585 * s, 585 * s, 320 * s - 0.5F, 240 * s - 0.5F};
}

// One lap of 60 frames to and fro, rendered before the clock runs.
class Lap {
 public:
  explicit Lap(int width) {
    for (int i = 0; i < kFrames; ++i) {
      cameras_.push_back(std::make_unique<SceneCamera>(camera_of(width), 1));
      const double s = 0.3 * (i < kFrames / 2 ? i : kFrames - i) / (kFrames / 2.0);
      raw_.push_back(cameras_.back()->capture_color(AnalyticScene::room(), shifted(s, 0, 0.3 * s, 0.2 * s),
                                                    0.0012, 0.0019));
    }
  }
  RawFrame next() {
    RawFrame raw = raw_[static_cast<std::size_t>(count_ % kFrames)];
    raw.timestamp_ns = count_++ * 33333333;
    return raw;
  }

 private:
  static constexpr int kFrames = 60;
  std::vector<std::unique_ptr<SceneCamera>> cameras_;
  std::vector<RawFrame> raw_;
  std::int64_t count_ = 0;
};

FrontEndOptions options_for(int width) {
  FrontEndOptions options;
  options.frame.reduction = width / 160;
  return options;
}

StoreOptions small_store() {
  StoreOptions options;
  options.max_fragments = 40;
  options.max_surfels = 1000000;
  options.max_frames = 2000;
  options.max_views = 120;
  return options;
}

void whole_frame(benchmark::State& state) {
  const int width = static_cast<int>(state.range(0));
  const FrontEndOptions options = options_for(width);
  Arena measuring;
  const FragmentStore unused_store(small_store(), measuring);
  const FrontEnd unused(camera_of(width), SceneCamera::kUnitM, options, nullptr, measuring);
  Arena arena(measuring.used_bytes());
  FragmentStore store(small_store(), arena);
  FrontEnd front_end(camera_of(width), SceneCamera::kUnitM, options, &store, arena);
  Lap lap(width);
  FrontEndTimes sum;
  for (auto _ : state) {
    const FrontEndResult result = front_end.process(lap.next());
    sum.preprocess_ns += result.times.preprocess_ns;
    sum.odometry_ns += result.times.odometry_ns;
    sum.fusion_ns += result.times.fusion_ns;
  }
  const auto ms = [](std::int64_t ns) {
    return benchmark::Counter(1e-6 * static_cast<double>(ns), benchmark::Counter::kAvgIterations);
  };
  state.counters["preprocess_ms"] = ms(sum.preprocess_ns);
  state.counters["odometry_ms"] = ms(sum.odometry_ns);
  state.counters["fusion_ms"] = ms(sum.fusion_ns);
}
BENCHMARK(whole_frame)->Arg(640)->Arg(320)->Unit(benchmark::kMillisecond);

// A preprocessed frame and a model view of the same room, as the tracker gets them.
struct Scene {
  explicit Scene(int width) : options(options_for(width)) {
    Arena measuring;
    carve(measuring, width);
    arena = std::make_unique<Arena>(measuring.used_bytes());
    carve(*arena, width);
    Lap lap(width);
    for (int i = 0; i < 20; ++i) {
      frame = &preprocessor->process(lap.next());
      builder->integrate(*frame, Se3(), Matrix6d::Zero(), true);
    }
    raw_owner = std::make_unique<SceneCamera>(camera_of(width), 1);
    raw = raw_owner->capture_color(AnalyticScene::room(), Se3(), 0.0012, 0.0019);
    frame = &preprocessor->process(raw);
    keyframe->keep(*frame, Se3());
    model = renderer->render({}, builder->active().surfels(), Se3(), Se3());
  }
  void carve(Arena& from, int width) {
    preprocessor =
        std::make_unique<FramePreprocessor>(camera_of(width), SceneCamera::kUnitM, options.frame, from);
    builder = std::make_unique<FragmentBuilder>(options.fragment, preprocessor->working_camera(),
                                                camera_of(width), from);
    renderer = std::make_unique<ModelRenderer>(options.model, preprocessor->working_camera(), from);
    keyframe = std::make_unique<Keyframe>(preprocessor->working_camera(), options.frame.levels, from);
  }
  FrontEndOptions options;
  std::unique_ptr<Arena> arena;
  std::unique_ptr<FramePreprocessor> preprocessor;
  std::unique_ptr<FragmentBuilder> builder;
  std::unique_ptr<ModelRenderer> renderer;
  std::unique_ptr<Keyframe> keyframe;
  std::unique_ptr<SceneCamera> raw_owner;
  RawFrame raw;
  const Frame* frame = nullptr;
  ModelView model;
};

void preprocess(benchmark::State& state) {
  Scene scene(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(&scene.preprocessor->process(scene.raw));
}
BENCHMARK(preprocess)->Arg(640)->Arg(320)->Unit(benchmark::kMicrosecond);

void icp_iteration(benchmark::State& state) {
  Scene scene(640);
  const FrameLevel& level = scene.frame->levels[static_cast<std::size_t>(state.range(0))];
  for (auto _ : state) benchmark::DoNotOptimize(linearize(level, scene.model, Se3(), IcpSettings()));
  state.counters["pixels"] = static_cast<double>(level.depth_m.size());
}
BENCHMARK(icp_iteration)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

void photometric_iteration(benchmark::State& state) {
  Scene scene(640);
  const auto l = static_cast<int>(state.range(0));
  const FrameLevel& level = scene.frame->levels[static_cast<std::size_t>(l)];
  for (auto _ : state)
    benchmark::DoNotOptimize(
        linearize_photometric(level, scene.keyframe->level(l), Se3(), PhotometricSettings()));
  state.counters["pixels"] = static_cast<double>(level.depth_m.size());
}
BENCHMARK(photometric_iteration)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

void find_turn(benchmark::State& state) {
  Scene scene(640);
  const PinholeCamera& coarsest = scene.preprocessor->coarsest_camera();
  Arena measuring;
  const RotationAlignment unused(coarsest, measuring);
  Arena arena(measuring.used_bytes());
  RotationAlignment alignment(coarsest, arena);
  alignment.keep(*scene.frame);
  for (auto _ : state)
    benchmark::DoNotOptimize(alignment.find(*scene.frame, so3_exp(Eigen::Vector3d(0, 0.15, 0))));
}
BENCHMARK(find_turn)->Unit(benchmark::kMicrosecond);

void calibrate_depth(benchmark::State& state) {
  Scene scene(640);
  DepthCalibration calibration((DepthCalibrationOptions()));
  for (auto _ : state) benchmark::DoNotOptimize(calibration.add_pair(*scene.keyframe, *scene.frame, Se3()));
}
BENCHMARK(calibrate_depth)->Unit(benchmark::kMicrosecond);

void reduce_color_image(benchmark::State& state) {
  Scene scene(640);
  const PinholeCamera& camera = scene.preprocessor->working_camera();
  std::vector<float> out(static_cast<std::size_t>(camera.width * camera.height));
  for (auto _ : state) reduce_color(scene.raw.color, {out.data(), camera.width, camera.height});
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(scene.raw.color.size()) * 3);
}
BENCHMARK(reduce_color_image)->Unit(benchmark::kMicrosecond);

void reduce_depth_image(benchmark::State& state) {
  Scene scene(640);
  std::vector<float> out(320 * 240);
  for (auto _ : state) reduce_raw(scene.raw.depth, 2, 0.0001F, {0.3F, 4.5F, 0.03F}, {out.data(), 320, 240});
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(scene.raw.depth.size()) * 2);
}
BENCHMARK(reduce_depth_image)->Unit(benchmark::kMicrosecond);

void smooth_and_normals(benchmark::State& state) {
  Scene scene(640);
  const FrameLevel& level = scene.frame->levels[0];
  const std::size_t pixels = level.depth_m.size();
  std::vector<float> smooth(pixels), nx(pixels), ny(pixels), nz(pixels);
  const ImageView<float> smoothed(smooth.data(), level.camera.width, level.camera.height);
  for (auto _ : state) {
    smooth_depth(level.depth_m, 1, 0.03F, smoothed);
    compute_normals(smoothed, level.camera, 0.03F, nx.data(), ny.data(), nz.data());
  }
}
BENCHMARK(smooth_and_normals)->Unit(benchmark::kMicrosecond);

void render_model(benchmark::State& state) {
  Scene scene(640);
  const SurfelSpan surfels = scene.builder->active().surfels();
  for (auto _ : state) benchmark::DoNotOptimize(&scene.renderer->render({}, surfels, Se3(), Se3()));
  state.counters["surfels"] = static_cast<double>(surfels.size());
}
BENCHMARK(render_model)->Unit(benchmark::kMicrosecond);

void fuse_frame(benchmark::State& state) {
  Scene scene(640);
  Arena measuring;
  const ActiveSurfels unused(scene.options.fragment, scene.preprocessor->working_camera(), measuring);
  Arena arena(measuring.used_bytes());
  ActiveSurfels active(scene.options.fragment, scene.preprocessor->working_camera(), arena);
  for (auto _ : state) active.fuse(*scene.frame, Se3());
  state.counters["surfels"] = static_cast<double>(active.surfels().size());
}
BENCHMARK(fuse_frame)->Unit(benchmark::kMicrosecond);

void close_fragment(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    Scene scene(640);
    Arena measuring;
    const FragmentStore unused(small_store(), measuring);
    Arena arena(measuring.used_bytes());
    FragmentStore store(small_store(), arena);
    state.ResumeTiming();
    benchmark::DoNotOptimize(scene.builder->close(&store));
  }
}
BENCHMARK(close_fragment)->Unit(benchmark::kMicrosecond)->Iterations(5);

}  // namespace
}  // namespace loopsift
