// SPDX-License-Identifier: MIT
// One HTML page about a run. What is measured is measured here; the page is drawn by tools/report/report.py.
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "tools/loopsift_tool/command_support.hpp"
#include "tools/loopsift_tool/commands.hpp"
#include "tools/loopsift_tool/run_evaluation.hpp"

namespace loopsift::tool {
namespace {

struct ReportOptions {
  RunEvaluationOptions evaluation;
  std::string out, title, json;
};

/// Where report.py is: installed beside this program, or in the sources that it was built from.
Expected<std::string> find_script() {
  std::error_code ignored;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::string installed = (program.parent_path() / LOOPSIFT_REPORT_FROM_BINDIR / "report.py").string();
  for (const std::string& path : {installed, std::string(LOOPSIFT_REPORT_SOURCE "/report.py")})
    if (std::filesystem::exists(path)) return path;
  return Error{ErrorCode::kUnsupported,
               installed + ": is not there; install loopsift with `cmake --install` to have reports"};
}

/// Debian's own Python comes first: it has the packages that Debian installs.
std::string python() { return std::filesystem::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3"; }

/// Runs a program with this one's output and returns its exit code.
Expected<int> run_program(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  std::fflush(nullptr);
  pid_t child = 0;
  if (const int problem = posix_spawnp(&child, argv[0], nullptr, nullptr, argv.data(), environ); problem != 0)
    return Error{ErrorCode::kUnsupported,
                 words[0] + ": cannot be started: " + std::strerror(problem) +
                     "; the report is drawn with python3 (apt-get install python3-numpy "
                     "python3-matplotlib python3-pil)"};
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  return Error{ErrorCode::kIo, words[1] + ": was ended by signal " + std::to_string(WTERMSIG(status))};
}

/// A folder for what the script reads, gone at the end.
class ScriptInput {
 public:
  ScriptInput()
      : folder_((std::filesystem::temp_directory_path() / ("loopsift-report-" + std::to_string(getpid())))
                    .string()) {}
  ~ScriptInput() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ScriptInput(const ScriptInput&) = delete;
  ScriptInput& operator=(const ScriptInput&) = delete;
  /// evaluation.json; residual_before.f32 and residual_after.f32, a float for each surfel, where there are
  /// any.
  [[nodiscard]] Status write(const RunEvaluation& evaluation) const {
    if (Status made = make_folder(folder_); !made) return made;
    if (Status written = write_json(folder_ + "/evaluation.json", evaluation.json); !written) return written;
    if (evaluation.residual.views.empty()) return {};
    if (Status s = write_floats("residual_before.f32", evaluation.residual.before_m); !s) return s;
    return write_floats("residual_after.f32", evaluation.residual.after_m);
  }
  [[nodiscard]] const std::string& folder() const { return folder_; }

 private:
  [[nodiscard]] Status write_floats(const char* name, const std::vector<float>& values) const {
    std::ofstream file(folder_ + "/" + name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(float)));
    file.flush();
    if (file) return {};
    return Error{ErrorCode::kIo, folder_ + ": cannot be written; is there room for temporary files?"};
  }
  std::string folder_;
};

std::string title_of(const ReportOptions& options) {
  if (!options.title.empty()) return options.title;
  return std::filesystem::weakly_canonical(options.evaluation.folder).filename().string();
}

int report(const ReportOptions& options) {
  const auto evaluation = evaluate_run(options.evaluation);
  if (!evaluation.ok()) return fail(evaluation.error());
  const auto script = find_script();
  if (!script.ok()) return fail(script.error());
  const ScriptInput input;
  if (const Status written = input.write(*evaluation); !written.ok()) return fail(written.error());
  const std::string out = options.out.empty() ? options.evaluation.folder + "/report.html" : options.out;
  const auto exit_code =
      run_program({python(), *script, options.evaluation.folder, out, input.folder(), title_of(options)});
  if (!exit_code.ok()) return fail(exit_code.error());
  if (*exit_code != 0) return *exit_code == kExitUsage ? kExitUsage : kExitOther;  // the script said why
  std::printf("%s\n", out.c_str());
  const Status written = write_json(options.json, {{"report", out}});
  return written.ok() ? kExitDone : fail(written.error());
}

}  // namespace

void add_report_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ReportOptions>();
  RunEvaluationOptions* evaluation = &options->evaluation;
  CLI::App* command = app.add_subcommand(
      "report", "One HTML page about a run: map, trajectory, loops and why they were taken, latency, memory");
  command->add_option("DIR", evaluation->folder, "what --out of the run named")->required();
  command->add_option("--out", options->out, "the page; by default DIR/report.html");
  command->add_option("--title", options->title, "by default the folder's name");
  command->add_option("--gt", evaluation->gt,
                      "true trajectory (TUM, KITTI, EuRoC, redwood): errors, and which loops are true");
  command->add_option("--gt-loops", evaluation->gt_loops,
                      "labelled pairs of fragments, redwood .log: which loops are true, instead of by --gt");
  command->add_option("--gt-info", evaluation->gt_info, "their information matrices, redwood .info");
  command
      ->add_option(
          "--fragments", evaluation->labels.fragments,
          "look only at pairs of the first so many fragments, where the labels are of a longer recording")
      ->check(CLI::PositiveNumber);
  command->add_option(
      "--source", evaluation->source,
      "the recording (replay:FORMAT:PATH or synth:SCENE): the map's residual, in each view and "
      "on each surfel, before and after");
  command->add_option("--json", options->json, "write where the page is to this file");
  command->callback([options, exit_code] { *exit_code = report(*options); });
}

}  // namespace loopsift::tool
