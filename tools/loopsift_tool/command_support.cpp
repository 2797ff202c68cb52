// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/command_support.hpp"

#include <cstdio>
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
