// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/sift_arguments.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/g2o_input.hpp"

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
  command->add_option(
      "--odometry-info", arguments->odometry_info,
      "how well the odometry knows its motions: redwood .info with records k k+1 n for the one "
      "from frame k to k+1, or the odometry edges of a .g2o (a run's own posegraph.g2o); "
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

// A loop file, read before the recording to tell what is wrong with it and how many loops there are, and
// made loops between fragments after it.
class LoopFile {
 public:
  explicit LoopFile(const SiftArguments& arguments) : arguments_(arguments) {}
  Status read_early(int recorded) {
    recorded_ = recorded;
    if (!is_g2o(arguments_.loops)) {
      const auto loops = read_log_loops(arguments_, recorded, recorded);
      if (!loops) return loops.error();
      count_ = loops->size();
      return {};
    }
    if (!arguments_.info.empty())
      return Error{ErrorCode::kUsage,
                   "--info: the edges of a .g2o carry their information themselves; leave it out"};
    Expected<PoseGraph> graph = read_g2o(arguments_.loops);
    if (!graph) return graph.error();
    graph_ = std::move(*graph);
    count_ = graph_.loops.size();
    return {};
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] Expected<std::vector<Loop>> between(Span<const Fragment> fragments) const {
    if (is_g2o(arguments_.loops)) return loops_of(graph_, arguments_.loops, fragments);
    return read_log_loops(arguments_, recorded_, static_cast<int>(fragments.size()));
  }

 private:
  const SiftArguments& arguments_;
  PoseGraph graph_;  // of a .g2o
  std::size_t count_ = 0;
  int recorded_ = 0;  // fragments in the recording
};

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
  LoopFile file(arguments);
  const int recorded = fragments_in((*source)->info().frame_count, arguments.map.fragment_frames);
  if (const Status read = file.read_early(recorded); !read) return failed(read.error());
  OfflineMapOptions options_of_map = arguments.map;
  options_of_map.max_loops = std::max<std::size_t>(1, arguments.room_for_loops * file.count());
  auto map = OfflineMap::build(**source, *odometry, options_of_map);
  if (!map) return failed(map.error());
  auto loops = file.between((*map)->fragments());
  if (!loops) return failed(loops.error());
  *input = {std::move(*map), std::move(*loops)};
  return true;
}

}  // namespace loopsift::tool
