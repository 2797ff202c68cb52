// SPDX-License-Identifier: MIT
#include <utility>

#include "core/geometry/trajectory.hpp"
#include "core/proposal/loop.hpp"

namespace loopsift {
namespace {

std::string where(const std::string& path, std::size_t record, int a, int b) {
  return path + ": record " + std::to_string(record + 1) + " (" + std::to_string(a) + " " +
         std::to_string(b) + "): ";
}

/// A loop that nobody gave an information for: 1 cm, 0.5°.
Matrix6d default_information() {
  constexpr double kSigma_m = 0.01, kSigma_rad = 0.5 * 3.14159265358979 / 180.0;
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(1 / (kSigma_m * kSigma_m)),
      Eigen::Vector3d::Constant(1 / (kSigma_rad * kSigma_rad));
  return diagonal.asDiagonal();
}

/// Exchanges the ends so that i < j. With T_j_i = T_i_j⁻¹ the information goes along by the adjoint.
void order_ends(Loop* loop) {
  if (loop->i < loop->j) return;
  std::swap(loop->i, loop->j);
  loop->T_i_j = loop->T_i_j.inverse();
  const Matrix6d Ad = loop->T_i_j.adjoint();
  loop->information = Ad.transpose() * loop->information * Ad;
}

Expected<std::vector<InfoRecord>> read_infos(const std::string& path, const std::vector<LogRecord>& records) {
  Expected<std::vector<InfoRecord>> infos = read_info(path);
  if (!infos) return infos;
  if (infos->size() != records.size())
    return Error{ErrorCode::kFormat, path + ": has " + std::to_string(infos->size()) +
                                         " records, the .log has " + std::to_string(records.size()) +
                                         "; give the .info of the same loops"};
  for (std::size_t k = 0; k < records.size(); ++k)
    if ((*infos)[k].a != records[k].a || (*infos)[k].b != records[k].b)
      return Error{ErrorCode::kFormat, where(path, k, (*infos)[k].a, (*infos)[k].b) + "the .log has " +
                                           std::to_string(records[k].a) + " " + std::to_string(records[k].b) +
                                           " here; give the .info of the same loops"};
  return infos;
}

}  // namespace

Expected<std::vector<Loop>> read_loops(const std::string& log_path, const std::string& info_path,
                                       int fragment_count) {
  const Expected<std::vector<LogRecord>> records = read_log(log_path);
  if (!records) return records.error();
  std::vector<InfoRecord> infos;
  if (!info_path.empty()) {
    Expected<std::vector<InfoRecord>> read = read_infos(info_path, *records);
    if (!read) return read.error();
    infos = std::move(*read);
  }
  std::vector<Loop> loops;
  for (std::size_t k = 0; k < records->size(); ++k) {
    const LogRecord& r = (*records)[k];
    const std::string at = where(log_path, k, r.a, r.b);
    for (int f : {r.a, r.b})
      if (f < 0 || f >= fragment_count)
        return Error{ErrorCode::kFormat, at + "there is no fragment " + std::to_string(f) +
                                             "; the sequence has " + std::to_string(fragment_count) +
                                             " fragments, numbered from 0: check the frames per fragment"};
    if (r.a == r.b)
      return Error{ErrorCode::kFormat, at + "a loop joins two different fragments; remove this record"};
    if (!r.T.is_valid())
      return Error{ErrorCode::kFormat, at + "the transform is no rigid motion; remove or repair this record"};
    Loop loop;
    loop.id.value = static_cast<std::int32_t>(k);
    loop.i.value = r.a;
    loop.j.value = r.b;
    loop.T_i_j = r.T;
    loop.information = infos.empty() ? default_information() : infos[k].information;
    order_ends(&loop);
    loops.push_back(loop);
  }
  return loops;
}

Status write_loops(const std::string& path, const std::vector<Loop>& loops, int fragment_count) {
  std::vector<LogRecord> records;
  std::vector<InfoRecord> infos;
  for (const Loop& loop : loops) {
    records.push_back({loop.i.value, loop.j.value, fragment_count, loop.T_i_j});
    infos.push_back({loop.i.value, loop.j.value, fragment_count, loop.information});
  }
  const Status status = write_log(path + ".log", records);
  if (!status) return status;
  return write_info(path + ".info", infos);
}

}  // namespace loopsift
