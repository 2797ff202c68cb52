// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/sift_arguments.hpp"

#include <CLI/CLI.hpp>
#include <utility>

#include "core/base/steady_time.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/g2o_input.hpp"
#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {

void add_sift_arguments(CLI::App* command, SiftArguments* arguments) {
  command->add_option("--source", arguments->source, "recording: replay:FORMAT:PATH or synth:SCENE")
      ->required();
  command
      ->add_option(
          "--trajectory", arguments->trajectory,
          "its odometry, camera-to-world: TUM text (by time), redwood .log (by frame number) or .g2o")
      ->required();
  command
      ->add_option(
          "--loops", arguments->loops,
          "proposed loops: redwood .log ('i j n' and the 4x4 that maps fragment j into i), or the edges "
          "of a .g2o between vertices that are frames or fragments")
      ->required();
  command->add_option("--info", arguments->info,
                      "their 6x6 informations, redwood .info; without it each is taken as good to 1 cm and "
                      "0.5 degrees");
  command->add_option("--odometry-info", arguments->odometry_info,
                      "information of the motions from frame to frame, redwood .info with records k k+1 n; "
                      "without it 2 % of each motion are assumed");
  command->add_option("--fragment-frames", arguments->map.fragment_frames, "frames per fragment")
      ->capture_default_str();
  command->add_option("--views", arguments->map.views, "frames per fragment that scoring looks at")
      ->capture_default_str();
  command
      ->add_option("--view-width", arguments->map.view_width,
                   "pixels that these frames are reduced to (smaller images are reduced less)")
      ->capture_default_str();
  command
      ->add_option("--map-width", arguments->map.map_width,
                   "pixels that all frames are reduced to for the map")
      ->capture_default_str();
  command->add_option("--json", arguments->json, "write the figures to this file");
}

namespace {

// A list that was made for another number of fragments has other numbers for the same places.
Status check_fragment_counts(const std::string& path, const OfflineMapOptions& map, int recorded, int posed) {
  const Expected<std::vector<LogRecord>> records = read_log(path);
  if (!records) return records.error();
  for (const LogRecord& record : *records) {
    if (record.n == recorded || record.n == posed) continue;
    return Error{ErrorCode::kFormat, path + ": its loops are between " + std::to_string(record.n) +
                                         " fragments, and the recording has " + std::to_string(recorded) +
                                         " of " + std::to_string(map.fragment_frames) +
                                         " frames: give the --fragment-frames that the list was made with"};
  }
  return {};
}

Expected<std::vector<Loop>> read_log_loops(const SiftArguments& arguments, int recorded, int posed) {
  auto loops = read_loops(arguments.loops, arguments.info, posed);
  if (!loops) return loops;
  if (Status counts = check_fragment_counts(arguments.loops, arguments.map, recorded, posed); !counts)
    return counts.error();
  return loops;
}

Expected<std::vector<Loop>> read_g2o_loops(const SiftArguments& arguments, Span<const Fragment> fragments) {
  if (!arguments.info.empty())
    return Error{ErrorCode::kUsage,
                 "--info: the edges of a .g2o carry their information themselves; leave it out"};
  const Expected<PoseGraph> graph = read_g2o(arguments.loops);
  if (!graph) return graph.error();
  return loops_of(*graph, arguments.loops, fragments);
}

}  // namespace

bool read_sift_input(const SiftArguments& arguments, SiftInput* input, int* exit_code) {
  const auto failed = [exit_code](const Error& error) {
    *exit_code = fail(error);
    return false;
  };
  if (const Status valid = validate(arguments.map); !valid) return failed(valid.error());
  SourceOptions options;
  options.want_color = false;
  const auto source = open_source(arguments.source, options);
  if (!source) {
    *exit_code = fail_to_open_source(source.error());
    return false;
  }
  const auto odometry = GivenOdometry::open(arguments.trajectory, arguments.odometry_info);
  if (!odometry) return failed(odometry.error());
  const bool g2o = is_g2o(arguments.loops);
  const int recorded = fragments_in((*source)->info().frame_count, arguments.map.fragment_frames);
  if (!g2o) {
    const auto early = read_log_loops(arguments, recorded, recorded);
    if (!early) return failed(early.error());
  }
  auto map = OfflineMap::build(**source, *odometry, arguments.map);
  if (!map) return failed(map.error());
  const Span<const Fragment> fragments = (*map)->fragments();
  auto loops = g2o ? read_g2o_loops(arguments, fragments)
                   : read_log_loops(arguments, recorded, static_cast<int>(fragments.size()));
  if (!loops) return failed(loops.error());
  *input = {std::move(*map), std::move(*loops)};
  return true;
}

double sift_all(Span<const Loop> loops, BackEnd* back_end) {
  const std::int64_t begin = steady_now_ns();
  {
    Ticker ticker("scoring loops alone:");
    back_end->sifter().on_progress([&](std::size_t done, std::size_t of) { ticker.update(done, of); });
    back_end->add_loops(loops);
  }
  {
    Ticker ticker("sifting:");
    back_end->sifter().on_progress([&](std::size_t done, std::size_t of) { ticker.update(done, of); });
    back_end->finish();
  }
  back_end->sifter().on_progress({});
  return static_cast<double>(steady_now_ns() - begin) * 1e-9;
}

}  // namespace loopsift::tool
