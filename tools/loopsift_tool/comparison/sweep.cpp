// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/comparison/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/loopsift_tool/comparison/false_loops.hpp"
#include "tools/loopsift_tool/comparison/task_pool.hpp"

namespace loopsift::tool {
namespace {

constexpr const char *kFalseAxis = "false_loops", *kLoopAxis = "loop_information",
                     *kOdometryAxis = "odometry_information";

struct Point {
  const char* axis;
  double value;
  int seed;
  ContestInput input;
};

Expected<Point> make_point(const ContestInput& given, const Truth& truth, const char* axis, double value,
                           double false_share, int seed) {
  Point point{axis, value, seed, given};
  const int count = static_cast<int>(std::lround(false_share * static_cast<double>(given.true_ids.size())));
  const auto wrong =
      make_false_loops(given.loops, truth, given.map->fragments(), count, static_cast<unsigned>(seed));
  if (!wrong) return wrong.error();
  point.input.loops.insert(point.input.loops.end(), wrong->begin(), wrong->end());
  return point;
}

Expected<std::vector<Point>> make_points(const ContestInput& given, const Truth& truth,
                                         const SweepOptions& options) {
  std::vector<Point> points;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    for (const double share : options.false_shares) {
      Expected<Point> point = make_point(given, truth, kFalseAxis, share, share, seed);
      if (!point) return point.error();
      points.push_back(std::move(*point));
    }
    for (const double factor : options.factors) {
      if (factor == 1.0) continue;  // the last point of false_shares; see with_factor_one()
      const double share = options.false_shares.back();
      Expected<Point> loops = make_point(given, truth, kLoopAxis, factor, share, seed);
      Expected<Point> odometry = make_point(given, truth, kOdometryAxis, factor, share, seed);
      if (!loops) return loops.error();
      if (!odometry) return odometry.error();
      for (Loop& loop : loops->input.loops) loop.information *= factor;
      for (Edge& edge : odometry->input.odometry.odometry) edge.information *= factor;
      odometry->input.odometry_factor *= factor;
      points.push_back(std::move(*loops));
      points.push_back(std::move(*odometry));
    }
  }
  return points;
}

SweepRow run_one(const Point& point, const Contestant& contestant, const Truth& truth) {
  const Outcome outcome = contestant.run(point.input);
  return {point.axis,
          point.value,
          point.seed,
          contestant.name,
          point.input.loops.size(),
          point.input.true_ids.size(),
          judge(point.input, truth, outcome),
          outcome.wall_s,
          outcome.failure};
}

// The point of factor 1 on both of the factors' axes is that of the last share of false loops.
std::vector<SweepRow> with_factor_one(std::vector<SweepRow> rows, const SweepOptions& options) {
  if (std::find(options.factors.begin(), options.factors.end(), 1.0) == options.factors.end()) return rows;
  const std::size_t count = rows.size();
  for (const char* axis : {kLoopAxis, kOdometryAxis}) {
    for (std::size_t k = 0; k < count; ++k) {
      if (std::string(rows[k].axis) != kFalseAxis || rows[k].value != options.false_shares.back()) continue;
      rows.push_back(rows[k]);
      rows.back().axis = axis;
      rows.back().value = 1.0;
    }
  }
  return rows;
}

void print_optional(std::FILE* file, const std::optional<double>& value) {
  if (value) std::fprintf(file, "%.6g", *value);
  std::fputc(',', file);
}

}  // namespace

Status validate(const SweepOptions& o) {
  if (o.seeds < 1 || o.seeds > 1000) return Error{ErrorCode::kUsage, "--seeds must be from 1 to 1000"};
  for (const double share : o.false_shares)
    if (!(share >= 0.0) || share > 100.0)
      return Error{ErrorCode::kUsage,
                   "--sweep-false must hold shares from 0 to 100 (1: as many false as true)"};
  for (const double factor : o.factors)
    if (!(factor > 0.0) || !std::isfinite(factor))
      return Error{ErrorCode::kUsage, "--sweep-factors must hold factors above 0"};
  if (o.false_shares.empty()) return Error{ErrorCode::kUsage, "--sweep-false is empty"};
  return {};
}

Expected<std::vector<SweepRow>> run_sweep(const ContestInput& input, const Truth& truth,
                                          const SweepOptions& options) {
  if (!truth.has_trajectory())
    return Error{ErrorCode::kUsage,
                 "--sweep makes false loops, for which it needs the true trajectory: --gt"};
  const Expected<std::vector<Point>> points = make_points(input, truth, options);
  if (!points) return points.error();
  std::vector<SweepRow> rows(points->size() * contestants().size());
  std::vector<std::function<void()>> tasks;
  for (std::size_t p = 0; p < points->size(); ++p)
    for (std::size_t c = 0; c < contestants().size(); ++c)
      tasks.emplace_back(
          [&, p, c] { rows[p * contestants().size() + c] = run_one((*points)[p], contestants()[c], truth); });
  run_tasks("sweep: filter runs", tasks);
  return with_factor_one(std::move(rows), options);
}

Status write_sweep_csv(const std::string& path, const std::vector<SweepRow>& rows) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) return Error{ErrorCode::kIo, path + ": cannot be opened for writing"};
  std::fputs("axis,value,seed,filter,loops,true_loops,accepted,precision,recall,ate_rmse_m,wall_s,failed\n",
             file);
  for (const SweepRow& row : rows) {
    std::fprintf(file, "%s,%g,%d,%s,%zu,%zu,%zu,", row.axis, row.value, row.seed, row.filter.c_str(),
                 row.loops, row.true_loops, row.figures.accepted);
    print_optional(file, row.figures.precision);
    print_optional(file, row.figures.recall);
    print_optional(file, row.figures.ate_rmse_m);
    std::fprintf(file, "%.3f,%d\n", row.wall_s, row.failure.empty() ? 0 : 1);
  }
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed)
    return Error{ErrorCode::kIo, path + ": could not be written in full; is the disk full?"};
  return {};
}

}  // namespace loopsift::tool
