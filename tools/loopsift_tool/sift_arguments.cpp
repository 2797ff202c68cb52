// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/sift_arguments.hpp"

#include <CLI/CLI.hpp>
#include <utility>

#include "core/base/steady_time.hpp"
#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/ticker.hpp"

namespace loopsift::tool {

void add_sift_arguments(CLI::App* command, SiftArguments* arguments) {
  command->add_option("--source", arguments->source, "recording: replay:FORMAT:PATH or synth:SCENE")
      ->required();
  command
      ->add_option("--trajectory", arguments->trajectory,
                   "its odometry, camera-to-world: TUM text (by time) or redwood .log (by frame number)")
      ->required();
  command
      ->add_option("--loops", arguments->loops,
                   "proposed loops, redwood .log: 'i j n' and the 4x4 that maps fragment j into i")
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
  command->add_option("--json", arguments->json, "write the figures to this file");
}

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
  const int expected = fragments_in((*source)->info().frame_count, arguments.map.fragment_frames);
  auto loops = read_loops(arguments.loops, arguments.info, expected);
  if (!loops) return failed(loops.error());
  auto map = OfflineMap::build(**source, *odometry, arguments.map);
  if (!map) return failed(map.error());
  const int fragments = static_cast<int>((*map)->fragments().size());
  if (fragments != expected) loops = read_loops(arguments.loops, arguments.info, fragments);
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
