// SPDX-License-Identifier: MIT
#include "firmware_app/cli.hpp"

#include <CLI/CLI.hpp>
#include <utility>
#include <vector>

namespace loopsift {
namespace {

constexpr const char* kDescription =
    "loopsift: a drift-corrected pose and a dense map from a depth camera, published over LCM.\n"
    "The map itself decides which loop closures are accepted.";

constexpr const char* kFooter = R"(Sources (URI):
  replay:tum:DIR        associations.txt, or depth.txt and rgb.txt
  replay:7scenes:DIR    frame-NNNNNN.depth.png, frame-NNNNNN.color.png
  replay:redwood:DIR    depth/ and image/ or color/
  replay:sun3d:DIR      intrinsics.txt, depth/ and image/
  replay:klg:FILE       a .klg recording
  lcm:CHANNEL           bot_core.images_t of another program
  synth:SCENE           a rendered scene, nothing needed: synth:room, synth:room?frames=60
  A folder may hold camera.txt (one "name value" a line: fx fy cx cy width height depth_scale);
  --set camera.fx=... comes before it.

Odometry:
  builtin               tracks the depth images (default)
  file:TRAJECTORY       poses from a TUM trajectory or a redwood .log
  lcm:CHANNEL           bot_core.pose_t of the body that carries the camera

Results in DIR: trajectory.txt (corrected) and trajectory_odometry.txt, map.ply, loops.csv (why each loop
was taken or refused), proposals.log and accepted.log with .info, posegraph.g2o, run.json (figures).

Published over LCM: POSE (corrected), POSE_ODOM (never jumps), LOOPSIFT_CORRECTION, LOOPSIFT_UPDATE,
LOOPSIFT_LOOP. Without a multicast route the run goes on unpublished.

Exit codes: 0 done, 1 other failure, 2 bad usage or settings, 3 source could not be opened,
4 over the memory cap, 5 source lost.

Examples:
  loopsift --source synth:room --rate max --out out
  loopsift --source replay:7scenes:redkitchen --rate max --out out --set lcm.enabled=false
  loopsift --check-config > all_settings.toml)";

struct Arguments {
  std::string config, source, odometry, out, record, rate;
  std::vector<std::string> assignments;
  bool print_budget = false;
  bool check_config = false;
};

void declare(CLI::App& app, Arguments* a) {
  app.footer(kFooter);
  app.set_help_flag("-h,--help", "Print this text and exit");
  app.set_version_flag("--version", "loopsift " LOOPSIFT_VERSION, "Print the version and exit");
  app.add_option("--config", a->config, "Settings file (TOML); see --check-config")->type_name("FILE");
  app.add_option("--source", a->source, "Where depth images come from; see Sources below")->type_name("URI");
  app.add_option("--odometry", a->odometry, "Where the pose between images comes from")->type_name("URI");
  app.add_option("--out", a->out, "Write the results into this folder (made if missing)")->type_name("DIR");
  app.add_option("--record", a->record, "Keep the frames in this new folder, to be replayed")
      ->type_name("DIR");
  app.add_option(
         "--rate", a->rate,
         "realtime: at the recording's pace, late frames dropped; max: every frame, fast and repeatable")
      ->type_name("realtime|max")
      ->check(CLI::IsMember({"realtime", "max"}).description(""));
  app.add_option("--set", a->assignments, "Change one setting, as in --set camera.max_depth_m=4; repeatable")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_flag("--print-budget", a->print_budget, "Print the memory that a run will use and exit");
  app.add_flag("--check-config", a->check_config, "Check the settings, print all of them as TOML and exit");
}

/// The named options as assignments to the keys that they stand for.
std::vector<std::string> all_assignments(const Arguments& a) {
  std::vector<std::string> all = a.assignments;
  for (const auto& [key, value] : {std::pair{"run.source=", &a.source},
                                   std::pair{"run.odometry=", &a.odometry}, std::pair{"run.out=", &a.out},
                                   std::pair{"record.folder=", &a.record}, std::pair{"run.rate=", &a.rate}})
    if (!value->empty()) all.push_back(key + *value);
  return all;
}

}  // namespace

Expected<CommandLine> parse_command_line(int argc, const char* const* argv) {
  CLI::App app{kDescription, "loopsift"};
  Arguments arguments;
  declare(app, &arguments);
  CommandLine line;
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    line.action = CommandLine::Action::kPrintText;
    line.text = app.help();
    return line;
  } catch (const CLI::CallForVersion& version) {
    line.action = CommandLine::Action::kPrintText;
    line.text = std::string(version.what()) + "\n";
    return line;
  } catch (const CLI::ParseError& error) {
    return Error{ErrorCode::kUsage, std::string(error.what()) + "; --help lists what there is"};
  }
  auto settings = load_settings(arguments.config, all_assignments(arguments));
  if (!settings.ok()) return settings.error();
  line.settings = std::move(*settings);
  if (arguments.check_config) {
    line.action = CommandLine::Action::kPrintSettings;
  } else if (arguments.print_budget) {
    line.action = CommandLine::Action::kPrintBudget;
  } else if (line.settings.run.source.empty()) {
    return Error{
        ErrorCode::kUsage,
        "no source: name one with --source URI, or as run.source in the settings file; --help lists them"};
  }
  return line;
}

}  // namespace loopsift
