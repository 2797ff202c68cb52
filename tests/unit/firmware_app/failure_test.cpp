// SPDX-License-Identifier: MIT
#include "firmware_app/failure.hpp"

#include <gtest/gtest.h>

namespace loopsift {
namespace {

TEST(Failure, ExitCodesAreTheDocumentedOnes) {
  const auto code = [](Phase phase, ErrorCode error) { return exit_code({phase, {error, ""}}); };
  EXPECT_EQ(code(Phase::kSettings, ErrorCode::kUsage), 2);
  EXPECT_EQ(code(Phase::kSettings, ErrorCode::kNotFound), 2);
  EXPECT_EQ(code(Phase::kSourceOpen, ErrorCode::kNotFound), 3);
  EXPECT_EQ(code(Phase::kSourceOpen, ErrorCode::kIo), 3);
  EXPECT_EQ(code(Phase::kSourceOpen, ErrorCode::kFormat), 3);
  EXPECT_EQ(code(Phase::kSourceOpen, ErrorCode::kUnsupported), 3);
  EXPECT_EQ(code(Phase::kSourceOpen, ErrorCode::kUsage), 2);
  EXPECT_EQ(code(Phase::kMemoryPlan, ErrorCode::kCapacity), 4);
  EXPECT_EQ(code(Phase::kSourceRead, ErrorCode::kIo), 5);
  EXPECT_EQ(code(Phase::kRun, ErrorCode::kIo), 1);
  EXPECT_EQ(code(Phase::kRun, ErrorCode::kCapacity), 1);
  EXPECT_EQ(code(Phase::kRun, ErrorCode::kUsage), 2);
}

}  // namespace
}  // namespace loopsift
