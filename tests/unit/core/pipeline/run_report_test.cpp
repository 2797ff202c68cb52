// SPDX-License-Identifier: MIT
#include "core/pipeline/run_report.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace loopsift {
namespace {

using Json = nlohmann::json;

std::vector<std::string> keys(const Json& json) {
  std::vector<std::string> names;
  for (const auto& [name, value] : json.items()) names.push_back(name);
  return names;
}

TEST(RunReport, TheKeysAreTheDocumentedOnes) {
  using ::testing::UnorderedElementsAre;
  const Json json = Json::parse(run_report_json(RunFigures{}));
  EXPECT_THAT(keys(json), UnorderedElementsAre("source", "sequence_duration_s", "wall_s", "frames",
                                               "latency_ms", "loops", "dmp", "memory", "pools"));
  EXPECT_THAT(keys(json["frames"]), UnorderedElementsAre("received", "dropped", "tracked", "lost"));
  EXPECT_THAT(keys(json["latency_ms"]),
              UnorderedElementsAre("odometry", "fusion", "frame", "capture_to_pose", "proposal", "loop_solve",
                                   "loop_score", "loop_test", "correction"));
  for (const Json& stage : json["latency_ms"])
    EXPECT_THAT(keys(stage), UnorderedElementsAre("p50", "p99", "max", "count", "quantiles"));
  EXPECT_THAT(keys(json["loops"]), UnorderedElementsAre("proposed", "scored", "tested", "accepted", "revoked",
                                                        "dropped", "pending"));
  EXPECT_THAT(keys(json["dmp"]), UnorderedElementsAre("odometry", "final", "views"));
  EXPECT_THAT(keys(json["memory"]),
              UnorderedElementsAre("budget_bytes", "cap_bytes", "peak_rss_bytes", "heap_calls_after_seal",
                                   "camera_library_heap_calls", "fence_peak_bytes", "fence_refusals"));
  EXPECT_THAT(keys(json["memory"]["heap_calls_after_seal"]),
              UnorderedElementsAre("capture", "front", "publish"));
}

TEST(RunReport, FiguresArriveUnderTheirKeys) {
  RunFigures figures;
  figures.source = "synth:room \"quoted\"";
  figures.frames = {10, 1, 8, 1};
  figures[Stage::kLoopTest].record_ns(5'000'000);
  figures.loops.accepted = 3;
  figures.dmp = {12.5, 4.25, 30};
  figures.memory.front_heap_calls = 0;
  figures.pools.push_back({"publisher/poses", 64, 5, 0});
  const Json json = Json::parse(run_report_json(figures));
  EXPECT_EQ(json["source"], "synth:room \"quoted\"");
  EXPECT_EQ(json["frames"], Json({{"received", 10}, {"dropped", 1}, {"tracked", 8}, {"lost", 1}}));
  EXPECT_EQ(json["latency_ms"]["loop_test"]["count"], 1);
  EXPECT_EQ(json["latency_ms"]["loop_test"]["max"], 5.0);
  EXPECT_EQ(json["latency_ms"]["loop_test"]["quantiles"].size(), 21U);
  EXPECT_EQ(json["latency_ms"]["loop_test"]["quantiles"][20], 5.0);
  EXPECT_EQ(json["latency_ms"]["frame"]["count"], 0);
  EXPECT_EQ(json["loops"]["accepted"], 3);
  EXPECT_EQ(json["dmp"], Json({{"odometry", 12.5}, {"final", 4.25}, {"views", 30}}));
  EXPECT_EQ(json["memory"]["heap_calls_after_seal"]["front"], 0);
  EXPECT_EQ(json["pools"]["publisher/poses"], Json({{"capacity", 64}, {"high_water", 5}, {"refused", 0}}));
}

TEST(RunReport, WhatWasNotMeasuredIsNull) {
  const Json json = Json::parse(run_report_json(RunFigures{}));
  EXPECT_TRUE(json["dmp"]["final"].is_null());
  EXPECT_TRUE(json["memory"]["heap_calls_after_seal"]["capture"].is_null());
  EXPECT_TRUE(json["memory"]["fence_peak_bytes"].is_null());
}

TEST(RunReport, AFolderThatIsNotThereIsNamed) {
  const Status written = write_run_report("/no/such/folder/run.json", RunFigures{});
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_THAT(written.error().message, ::testing::HasSubstr("/no/such/folder/run.json"));
}

TEST(RunReport, PeakResidentMemoryCoversWhatWasTouched) {
  const std::vector<char> touched(64 << 20, 'x');
  EXPECT_GE(peak_rss_bytes(), 64 << 20);
  EXPECT_EQ(touched.back(), 'x');
}

}  // namespace
}  // namespace loopsift
