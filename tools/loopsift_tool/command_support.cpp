// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/command_support.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace loopsift::tool {
namespace {

int exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
    case ErrorCode::kNotFound:
    case ErrorCode::kFormat:
    case ErrorCode::kUnsupported:
      return kExitUsage;
    case ErrorCode::kIo:
    case ErrorCode::kCapacity:
    case ErrorCode::kNumeric:
      break;
  }
  return kExitOther;
}

void print(const Error& error) { std::fprintf(stderr, "loopsift-tool: %s\n", error.message.c_str()); }

}  // namespace

int fail(const Error& error) {
  print(error);
  return exit_code_of(error.code);
}

int fail_to_open_source(const Error& error) {
  print(error);
  return error.code == ErrorCode::kUsage ? kExitUsage : kExitSourceNotOpened;
}

int show_figures(const std::vector<Figure>& figures, const std::string& json_path) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Figure& figure : figures) {
    json[figure.key] = figure.value;
    if (figure.value.is_number_float()) {
      std::printf("%-40s %10.4f %s\n", figure.label, figure.value.get<double>(), figure.unit);
    } else {
      const std::string text = figure.value.is_null() ? "-" : figure.value.dump();
      std::printf("%-40s %10s %s\n", figure.label, text.c_str(), figure.unit);
    }
  }
  const Status written = write_json(json_path, json);
  return written.ok() ? kExitDone : fail(written.error());
}

Status make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return {};
  return Error{ErrorCode::kIo, path + ": the folder for the results cannot be made: " + error.message()};
}

Status write_json(const std::string& path, const nlohmann::ordered_json& json) {
  if (path.empty()) return {};
  std::ofstream file(path);
  file << json.dump(2) << '\n';
  file.flush();
  if (!file)
    return Error{ErrorCode::kIo, path + ": cannot be written; check that its folder exists and has room"};
  return {};
}

}  // namespace loopsift::tool
