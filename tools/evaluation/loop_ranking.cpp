// SPDX-License-Identifier: MIT
#include "tools/evaluation/loop_ranking.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <utility>

#include "core/base/text_file.hpp"

namespace loopsift {
namespace {

constexpr std::array<const char*, 5> kColumns = {"id", "fragment_i", "fragment_j", "rank", "decision"};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

/// Where each of kColumns is.
Expected<std::array<std::size_t, 5>> find_columns(const std::string& path, const std::string& header) {
  const std::vector<std::string> names = split(header);
  std::array<std::size_t, 5> columns{};
  for (std::size_t k = 0; k < kColumns.size(); ++k) {
    const auto found = std::find(names.begin(), names.end(), kColumns[k]);
    if (found == names.end())
      return Error{ErrorCode::kFormat,
                   path + ": has no column '" + kColumns[k] + "'; give the loops.csv of a run"};
    columns[k] = static_cast<std::size_t>(found - names.begin());
  }
  return columns;
}

LogRecord ordered(const LogRecord& record) {
  return record.a <= record.b ? record : LogRecord{record.b, record.a, record.n, record.T.inverse()};
}

}  // namespace

Expected<std::vector<RankedLoop>> read_ranked_loops(const std::string& path) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot be opened; check the path"};
  std::string line;
  std::getline(in, line);
  const auto columns = find_columns(path, line);
  if (!columns) return columns.error();
  std::vector<RankedLoop> loops;
  for (int number = 2; std::getline(in, line); ++number) {
    if (line.empty()) continue;
    const std::vector<std::string> fields = split(line);
    RankedLoop loop;
    const auto field = [&](std::size_t k) {
      return (*columns)[k] < fields.size() ? fields[(*columns)[k]] : std::string();
    };
    if (!parse_number(field(0), &loop.id) || !parse_number(field(1), &loop.fragment_i) ||
        !parse_number(field(2), &loop.fragment_j) || !parse_number(field(3), &loop.rank))
      return Error{ErrorCode::kFormat, path + ":" + std::to_string(number) +
                                           ": id, fragments and rank must be whole numbers; is it cut off?"};
    loop.accepted = field(4) == "accepted";
    loops.push_back(loop);
  }
  return loops;
}

Expected<Ranking> rank_loops(const LoopVerdicts& verdicts, const std::vector<LogRecord>& proposals,
                             std::vector<RankedLoop> loops) {
  std::sort(loops.begin(), loops.end(),
            [](const RankedLoop& a, const RankedLoop& b) { return a.rank < b.rank; });
  Ranking ranking;
  std::set<std::pair<int, int>> found;
  int hits = 0;
  double last_recall = 0;
  for (const RankedLoop& loop : loops) {
    if (loop.rank < 0) continue;
    const auto k = static_cast<std::size_t>(loop.id);
    const LogRecord* record = loop.id >= 0 && k < proposals.size() ? &proposals[k] : nullptr;
    if (record == nullptr || ordered(*record).a != loop.fragment_i || ordered(*record).b != loop.fragment_j)
      return Error{ErrorCode::kUsage,
                   "loop " + std::to_string(loop.id) +
                       " of the ranking is not among the loops; give the proposals.log and "
                       "the loops.csv of one run"};
    if (!verdicts.counts[k]) continue;
    const bool hit = verdicts.correct[k];
    hits += hit ? 1 : 0;
    if (hit) found.insert({loop.fragment_i, loop.fragment_j});
    RankingPoint point{loop, hit, 0, 0};
    point.recall = static_cast<double>(found.size()) / verdicts.true_loops;
    point.precision = static_cast<double>(hits) / static_cast<double>(ranking.points.size() + 1);
    ranking.average_precision += point.precision * (point.recall - last_recall);
    last_recall = point.recall;
    ranking.points.push_back(point);
  }
  if (ranking.points.empty())
    return Error{ErrorCode::kUsage, "the ranking holds no loop that was scored; did the run get that far?"};
  return ranking;
}

}  // namespace loopsift
