// SPDX-License-Identifier: MIT
// The score of a map and what it is made of: one fragment into one view, a whole map, and a loop scored alone
// (step 1 of Algorithm 1) and tested (step 3) as the sifter does it, with percentiles over many loops. Every
// frame at full resolution, for comparison. All fragments are of one room, so that
// most are in sight of most others: the worst case.
#include <benchmark/benchmark.h>

#include <map>

#include "tests/bench/sifting_world.hpp"

namespace loopsift {
namespace {

using test::FragmentWorld;
using test::InArena;

const FragmentWorld& world_of(int fragments, int views_per_fragment, int view_width) {
  static std::map<std::vector<int>, FragmentWorld> worlds;
  const std::vector<int> key{fragments, views_per_fragment, view_width};
  const auto known = worlds.find(key);
  if (known != worlds.end()) return known->second;
  const PinholeCamera view = view_width == 40 ? test::small_view_camera() : test::view_camera();
  return worlds.emplace(key, test::make_building(test::Building::kRoom, fragments, views_per_fragment, view))
      .first->second;
}

const FragmentWorld& world_of(const benchmark::State& state) {
  return world_of(60, static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
}

void dmp(benchmark::State& state) {
  const FragmentWorld& world = world_of(state);
  const InArena<MapScorer> scorer(test::posterior_for(world));
  for (const Fragment& fragment : world.fragments())
    if (!scorer->add(fragment)) std::abort();
  for (auto _ : state) benchmark::DoNotOptimize(scorer->dmp(world.odometry()).value);
  state.counters["views"] = scorer->view_count();
}
BENCHMARK(dmp)
    ->ArgNames({"views_each", "width"})
    ->ArgsProduct({{2, 5}, {40, 80}})
    ->Unit(benchmark::kMillisecond);

// What the 60th fragment costs: drawn on top of the odometry's map, and with everything drawn anew.
void add_to_odometry_map(benchmark::State& state) {
  const FragmentWorld& world = world_of(state);
  const InArena<MapScorer> scorer(test::posterior_for(world));
  const InArena<MapLikelihood> likelihood(std::cref(*scorer));
  const std::vector<Se3>& poses = world.odometry();
  const std::size_t last = poses.size() - 1;
  for (std::size_t f = 0; f < last; ++f)
    if (!scorer->add(world.fragments()[f])) std::abort();
  (void)likelihood->set_odometry_map({poses.data(), last});
  if (!scorer->add(world.fragments()[last])) std::abort();
  std::vector<Se3> moved = poses;
  for (auto _ : state) {
    state.PauseTiming();
    moved[0] = moved[0] * Se3(Eigen::Matrix3d::Identity(), {1e-9, 0, 0});  // forget what is drawn
    (void)likelihood->set_odometry_map({moved.data(), last});
    if (state.range(2) != 0) moved[0] = poses[0];
    state.ResumeTiming();
    benchmark::DoNotOptimize(likelihood->set_odometry_map(moved));
  }
  state.counters["views"] = scorer->view_count();
}
BENCHMARK(add_to_odometry_map)
    ->ArgNames({"views_each", "width", "anew"})
    ->ArgsProduct({{2, 5}, {40, 80}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

// Discs of one fragment in arrays of its own.
struct Discs {
  Discs(const Fragment& fragment, float spacing_m, float radius_m)
      : chunks(fragment.surfels.size() / kChunkSize + 1) {
    for (std::vector<float>& array : arrays) array.resize(fragment.surfels.size());
    surfels = {arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5], arrays[6], chunks};
    ThinScratch scratch;
    if (thin(fragment.surfels, spacing_m, radius_m, &scratch, &surfels) > 0) std::abort();
  }
  std::vector<float> arrays[7];
  std::vector<SurfelChunk> chunks;
  ScoreSurfels surfels;
};

// An image that discs can be rendered to.
struct Layer {
  explicit Layer(const PinholeCamera& camera)
      : pixels(static_cast<std::size_t>(padded_stride(camera.width) * camera.height)),
        image(pixels.data(), camera.width, camera.height, padded_stride(camera.width)) {}
  void clear() { std::fill(pixels.begin(), pixels.end(), 0.0F); }
  std::vector<float> pixels;
  ImageView<float> image;
};

void render_one_fragment(benchmark::State& state) {
  const PosteriorOptions options;
  const Discs discs(world_of(60, 2, 80).fragments()[0], options.disc_spacing_m, options.disc_radius_m);
  const PinholeCamera camera = test::view_camera();
  Layer layer(camera);
  const double half = static_cast<double>(state.range(0));
  const Se3 T_camera_fragment = test::shifted(0.3 * half, 0, 0, 0.8 * half);
  const auto render = state.range(1) != 0 ? render_discs_plain : render_discs;
  for (auto _ : state) {
    layer.clear();
    render(discs.surfels, T_camera_fragment, camera, options.min_depth_m, options.max_depth_m, layer.image);
    benchmark::DoNotOptimize(layer.pixels.data());
  }
  state.counters["discs"] = static_cast<double>(discs.surfels.size());
}
BENCHMARK(render_one_fragment)
    ->ArgNames({"half_in_sight", "plain"})
    ->Args({0, 0})
    ->Args({1, 0})
    ->Args({0, 1})
    ->Unit(benchmark::kMicrosecond);

// What the published metric costs for one map: all surfels of all fragments, none thinned away, drawn into
// 640 × 480 pixels. A map of 60 fragments of 50 frames has 3000 frames (`all_frames_s`). By our own renderer
// six frames are timed, spread over the walk, whole. The renderer's plain form takes minutes for one frame:
// of each fragment it draws one chunk of 64 surfels, a different part of each; the rest is extrapolated.
// Fusing and solving come on top and are left out.
struct FullMap {
  FullMap() : world(world_of(60, 2, 80)) {
    for (const Fragment& fragment : world.fragments()) discs.emplace_back(fragment, 0.001F, 0.02F);
    for (const Discs& fragment : discs) surfels += static_cast<double>(fragment.surfels.size());
  }
  void render(std::size_t frame, const ImageView<float>& image) const {
    const PosteriorOptions options;
    const Se3 T_camera_map = frame_pose(frame);
    for (std::size_t f = 0; f < discs.size(); ++f)
      render_discs(discs[f].surfels, T_camera_map * world.odometry()[f], kCamera, options.min_depth_m,
                   options.max_depth_m, image);
  }
  // Returns how many surfels it drew.
  [[nodiscard]] double render_plain_sample(std::size_t frame, const ImageView<float>& image) const {
    const PosteriorOptions options;
    const Se3 T_camera_map = frame_pose(frame);
    double drawn = 0;
    for (std::size_t f = 0; f < discs.size(); ++f) {
      ScoreSurfels s = discs[f].surfels;
      const SurfelChunk chunk = s.chunks[f * s.chunks.size() / discs.size()];
      for (Span<float>* array : {&s.x, &s.y, &s.z, &s.nx, &s.ny, &s.nz, &s.radius})
        *array = {array->data() + chunk.begin, chunk.size};
      render_discs_plain(s, T_camera_map * world.odometry()[f], kCamera, options.min_depth_m,
                         options.max_depth_m, image);
      drawn += chunk.size;
    }
    return drawn;
  }
  static constexpr std::size_t kTimedFrames = 6;
  static constexpr double kFrames = 60.0 * 50.0;
  static constexpr PinholeCamera kCamera{640, 480, 580.0F, 580.0F, 319.5F, 239.5F};
  const FragmentWorld& world;
  std::vector<Discs> discs;
  double surfels = 0;

 private:
  [[nodiscard]] Se3 frame_pose(std::size_t frame) const {
    return world.odometry()[frame * world.odometry().size() / kTimedFrames].inverse();
  }
};

void full_resolution(benchmark::State& state) {
  const FullMap map;
  Layer layer(FullMap::kCamera);
  double drawn = 0;
  const double begin = test::cpu_ms();
  for (auto _ : state) {
    for (std::size_t frame = 0; frame < FullMap::kTimedFrames; ++frame) {
      layer.clear();
      if (state.range(0) == 0) map.render(frame, layer.image);
      drawn += state.range(0) == 0 ? map.surfels : map.render_plain_sample(frame, layer.image);
      benchmark::DoNotOptimize(layer.pixels.data());
    }
  }
  state.counters["surfels"] = map.surfels;
  state.counters["drawn"] = drawn / FullMap::kTimedFrames;
  state.counters["all_frames_s"] = 1e-3 * (test::cpu_ms() - begin) * map.surfels / drawn * FullMap::kFrames;
}
BENCHMARK(full_resolution)->ArgName("plain")->Arg(0)->Arg(1)->Iterations(1)->Unit(benchmark::kMillisecond);

// Times of single steps, milliseconds of processor time.
struct StepTimes {
  std::vector<double> alone, refused, accepted;
};

// Runs all steps that there are, by kind.
StepTimes run_steps(Sifter* sifter) {
  StepTimes times;
  const auto accepted = [sifter] {
    const auto& records = sifter->records();
    return std::count_if(records.begin(), records.end(),
                         [](const SiftedLoop& r) { return r.decision == Decision::kAccepted; });
  };
  for (bool more = true; more;) {
    const SifterCounts before = sifter->counts();
    const auto accepted_before = accepted();
    const double begin = test::cpu_ms();
    more = sifter->step();
    const double took = test::cpu_ms() - begin;
    if (sifter->counts().scored > before.scored) times.alone.push_back(took);
    if (sifter->counts().tested == before.tested) continue;
    (accepted() > accepted_before ? times.accepted : times.refused).push_back(took);
  }
  return times;
}

void add_percentiles(const char* name, const std::vector<double>& times, benchmark::State* state) {
  const std::string prefix(name);
  state->counters[prefix + "_n"] = static_cast<double>(times.size());
  state->counters[prefix + "_p50_ms"] = test::percentile(times, 0.5);
  state->counters[prefix + "_p99_ms"] = test::percentile(times, 0.99);
}

// Ten true loops make a map; then 200 more come in, all true or all false. alone, refused, accepting: whole
// steps. One that accepts renders every view, to be the next tests' reference; so does one that refuses, when
// the map that it is tested on is not the one of the step before. test: solve and score alone, by the clock.
void loop_steps(benchmark::State& state) {
  const FragmentWorld& world = world_of(state);
  constexpr int kFirst = 10, kLoops = 200;
  const std::vector<Loop> true_ones = test::candidate_loops(world, kFirst + kLoops, kFirst + kLoops);
  const std::vector<Loop> false_ones = test::candidate_loops(world, kFirst + kLoops, kFirst);
  const std::vector<Loop>& loops = state.range(2) != 0 ? true_ones : false_ones;
  test::LoadedSifter loaded(world, test::posterior_for(world), {});
  Sifter& sifter = *loaded.sifter;
  sifter.add({loops.data(), kFirst});
  while (sifter.step()) {
  }
  StepTimes times;
  for (auto _ : state) {
    sifter.add({loops.data() + kFirst, kLoops});
    times = run_steps(&sifter);
  }
  add_percentiles("alone", times.alone, &state);
  add_percentiles("refused", times.refused, &state);
  add_percentiles("accepting", times.accepted, &state);
  state.counters["test_p50_ms"] = sifter.test_times().percentile_ms(0.5);
  state.counters["test_p99_ms"] = sifter.test_times().percentile_ms(0.99);
  state.counters["views"] = loaded.scorer->view_count();
  state.counters["accepted"] = static_cast<double>(sifter.accepted().size());
}
BENCHMARK(loop_steps)
    ->ArgNames({"views_each", "width", "true"})
    ->ArgsProduct({{2, 5}, {40, 80}, {0, 1}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace loopsift
