// SPDX-License-Identifier: MIT
// The publisher with a map of FRAGMENTS fragments, as a process of its own: lcm_map_server URL FRAGMENTS
// FILE. Publishes poses at 30 Hz, health at 2 Hz, one correction and some loops, long before anybody need
// listen; obeys SAVE by writing the map to FILE, PAUSE and RESUME by standing still, FINISH by ending.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "core/fragment/surfel_ply.hpp"
#include "firmware_app/publisher.hpp"
#include "tests/support/in_arena.hpp"
#include "tests/support/random_graph.hpp"

namespace {

using namespace loopsift;

constexpr std::size_t kSurfels = 10'000;  // of a fragment: about what a room at 2 cm gives
constexpr int kLoops = 40;
constexpr int kTick_ms = 33;

test::RandomGraphOptions graph_options(int fragments) {
  test::RandomGraphOptions options;
  options.fragments = fragments;
  return options;
}

StoreOptions store_options(int fragments) {
  StoreOptions options;
  options.max_fragments = fragments;
  options.max_surfels = fragments * static_cast<int>(kSurfels);
  options.max_frames = options.max_views = fragments;
  return options;
}

GraphLimits limits(int fragments) { return {fragments, 16 * fragments, 64 * fragments}; }

LcmSettings settings(const std::string& url) {
  LcmSettings made;
  made.url = url;
  return made;
}

/// Surfels and normals of any value; one frame.
class Filler {
 public:
  Filler() {
    for (std::vector<float>* list : {&x_, &y_, &z_, &nx_, &ny_, &nz_, &radius_, &weight_})
      list->resize(kSurfels);
    rgb_.resize(kSurfels);
    times_.resize(kSurfels);
  }
  void add_to(FragmentStore* store) {
    std::normal_distribution<float> wide(0, 2);
    for (std::vector<float>* list : {&x_, &y_, &z_, &nx_, &ny_, &nz_}) {
      for (float& value : *list) value = wide(random_);
    }
    for (float& value : radius_) value = std::abs(wide(random_)) * 0.01F;
    for (float& value : weight_) value = std::abs(wide(random_));
    for (std::uint32_t& value : rgb_) value = static_cast<std::uint32_t>(random_()) & 0xFFFFFFU;
    frame_.timestamp_ns += 1'666'666'667;
    Fragment fragment;
    fragment.frames = Span<const FragmentFrame>(&frame_, 1);
    fragment.surfels = {x_, y_, z_, nx_, ny_, nz_, radius_, weight_, rgb_, times_, times_};
    if (store->add(fragment) == nullptr) std::fprintf(stderr, "the store is full\n");
  }

 private:
  std::mt19937 random_{11};
  std::vector<float> x_, y_, z_, nx_, ny_, nz_, radius_, weight_;
  std::vector<std::uint32_t> rgb_;
  std::vector<std::uint16_t> times_;
  FragmentFrame frame_;
};

LoopRecord loop_record(int id) {
  LoopRecord record;
  record.id = id;
  record.fragment_i = 0;
  record.fragment_j = id + 2;
  record.decision = id % 3 == 0 ? LoopDecision::kAccepted : LoopDecision::kRejected;
  return record;
}

std::vector<Se3> fragment_poses(const PoseGraph& graph, std::size_t fragments) {
  std::vector<Se3> poses;
  for (std::size_t f = 0; f < fragments; ++f)
    poses.push_back(graph.T_map_fragment(FragmentId{static_cast<std::int32_t>(f)}));
  return poses;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: lcm_map_server URL FRAGMENTS FILE\n");
    return 2;
  }
  const int fragments = std::atoi(argv[2]);
  const test::InArena<FragmentStore> store(store_options(fragments));
  Filler filler;
  for (int f = 0; f < fragments; ++f) filler.add_to(&*store);
  const test::RandomGraph world(graph_options(fragments));
  const std::vector<Se3> poses = fragment_poses(world.graph, store->fragments().size());

  Arena measuring;
  { const Publisher unused(settings(argv[1]), measuring, limits(fragments)); }
  Arena arena(measuring.used_bytes());
  Publisher publisher(settings(argv[1]), arena, limits(fragments));
  if (const Status started = publisher.start(&*store); !started.ok()) {
    std::fprintf(stderr, "%s\n", started.error().message.c_str());
    return 1;
  }
  CorrectionRecord correction;
  correction.epoch = 1;
  correction.T_map_odom = Se3(Eigen::Matrix3d::Identity(), {0.1, 0, 0});
  (void)publisher.publish(correction);
  for (int id = 0; id < kLoops; ++id) (void)publisher.publish(loop_record(id));
  publisher.publish(world.graph, store->fragments(), poses, 0, 1);
  std::printf("listening\n");
  std::fflush(stdout);

  RunHealth health;
  health.state = RunState::kTracking;
  health.fragments = fragments;
  health.correction_epoch = 1;
  health.loops_proposed = kLoops;
  bool paused = false;
  for (int tick = 0, at = 0;; ++tick) {
    Command command;
    while (publisher.take(&command)) {
      if (command.kind == CommandKind::kSave) (void)write_surfel_ply(argv[3], store->fragments(), poses);
      if (command.kind == CommandKind::kPause || command.kind == CommandKind::kResume)
        paused = command.kind == CommandKind::kPause;
      publisher.set_paused(paused);
      publisher.acknowledge(Publisher::AckFrom::kTaker, answer(command, AckStatus::kDone, "done"));
      if (command.kind == CommandKind::kFinish) {
        publisher.stop();
        std::printf("%ld commands obeyed, %ld refused\n", static_cast<long>(publisher.commands_obeyed()),
                    static_cast<long>(publisher.commands_refused()));
        return 0;
      }
    }
    if (!paused) {
      PoseRecord pose;
      pose.timestamp_ns = ++at * std::int64_t{kTick_ms} * 1'000'000;
      pose.epoch = 1;
      pose.T_map_odom = correction.T_map_odom;
      pose.T_odom_camera = Se3(Eigen::Matrix3d::Identity(), {0, 0, 0.01 * at});
      pose.information = Matrix6d::Identity() * 1e6;
      (void)publisher.publish(pose);
    }
    if (tick % 15 == 0) {
      health.uptime_ns = tick * std::int64_t{kTick_ms} * 1'000'000;
      (void)publisher.publish(health);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(kTick_ms));
  }
}
