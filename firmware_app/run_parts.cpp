// SPDX-License-Identifier: MIT
#include "firmware_app/run_parts.hpp"

#include <filesystem>

#include "core/pipeline/results.hpp"

namespace loopsift {
namespace {

FrameQueueOptions queue_options(const Settings& settings) {
  FrameQueueOptions options;
  options.realtime = settings.run.rate == Rate::kRealtime;
  return options;
}

GraphLimits graph_limits(const Settings& settings) {
  constexpr int kEdgesPerNode = 3;  // one of the odometry, the rest of loops
  GraphLimits limits;
  limits.max_fragments = settings.store.max_fragments;
  limits.max_nodes = limits.max_fragments * settings.back_end.keyframes_per_fragment;
  limits.max_edges = limits.max_nodes * kEdgesPerNode;
  return limits;
}

}  // namespace

Status make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, path + ": the folder for the results cannot be made: " + error.message()};
}

Parts::Parts(const Settings& settings, SupervisedSource& frame_source, ExternalOdometry* given,
             Shared& shared, Arena& arena)
    : recorder(settings.record, frame_source.info(), arena),
      source(frame_source, shared[ThreadRole::kCapture], recorder),
      queue(source, queue_options(settings), arena),
      publisher(settings.lcm, arena, graph_limits(settings)),
      store(settings.store, arena),
      front_end(source.info().camera, source.info().depth_unit_m, settings.front_end, &store, arena),
      back_end(settings.back_end, arena),
      back_worker(back_end, store, publisher, arena, back_worker_options(settings, shared)),
      front({queue, front_end, back_worker, publisher, given}, settings.lcm.slew,
            settings.run.rate == Rate::kMax, static_cast<std::size_t>(settings.store.max_frames),
            &shared.figures, arena) {}

BackWorkerOptions Parts::back_worker_options(const Settings& settings, Shared& shared) {
  BackWorkerOptions options;
  options.heap_bytes = static_cast<std::int64_t>(mebibytes(settings.memory.back_heap_mib));
  options.steps_per_fragment = settings.back_end.steps_per_fragment;
  options.realtime = settings.run.rate == Rate::kRealtime;
  options.slice_s = settings.back_end.slice_s;
  options.max_nodes = graph_limits(settings).max_nodes;
  options.monitor = &shared[ThreadRole::kBack];
  if (!settings.run.out.empty()) options.save = [this, to = settings.run.out + "/saved"] { return save(to); };
  return options;
}

Status Parts::save(const std::string& to) const {
  if (const Status made = make_folder(to); !made.ok()) return made;
  return write_results(to, back_end, front.poses(), store.fragments());
}

}  // namespace loopsift
