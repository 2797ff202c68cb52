// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/odometry_information.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/posegraph/pose_graph.hpp"
#include "tools/loopsift_tool/g2o_input.hpp"

namespace loopsift::tool {
namespace {

constexpr double kSameFrame = 0.005;  // seconds, or frame numbers
constexpr double kMaxGap_s = 0.1;     // poses of the trajectory farther apart are not interpolated

}  // namespace

Expected<OdometryInformation> OdometryInformation::read(const std::string& path,
                                                        const Trajectory& trajectory) {
  OdometryInformation information;
  const Status read =
      is_g2o(path) ? information.read_graph(path, trajectory) : information.read_info_file(path);
  if (!read) return read.error();
  std::sort(information.spans_.begin(), information.spans_.end(),
            [](const Interval& a, const Interval& b) { return a.begin < b.begin; });
  return information;
}

Status OdometryInformation::add(const std::string& at, const Interval& span) {
  if (span.information.llt().info() != Eigen::Success)
    return Error{ErrorCode::kFormat, at + ": the 6x6 matrix is not positive definite; repair or remove it"};
  spans_.push_back(span);
  return {};
}

Status OdometryInformation::read_info_file(const std::string& path) {
  const Expected<std::vector<InfoRecord>> records = read_info(path);
  if (!records) return records.error();
  for (const InfoRecord& record : *records) {
    const std::string at = path + ": record " + std::to_string(record.a) + " " + std::to_string(record.b);
    if (record.b != record.a + 1)
      return Error{ErrorCode::kFormat, at + " joins no two frames in a row; odometry information is of the "
                                            "motions from frame k to k+1"};
    const Interval span{static_cast<double>(record.a), static_cast<double>(record.b), Se3(),
                        record.information};
    if (Status added = add(at, span); !added) return added;
  }
  return {};
}

Status OdometryInformation::read_graph(const std::string& path, const Trajectory& trajectory) {
  const Expected<PoseGraph> graph = read_g2o(path);
  if (!graph) return graph.error();
  by_time_ = has_times(*graph);
  if (by_time_ && trajectory.indexed)
    return Error{ErrorCode::kUsage, path +
                                        ": its vertices have times, and the trajectory goes by frame "
                                        "number; give a trajectory with times (TUM) with it"};
  if (by_time_) trajectory_ = trajectory;
  for (const Edge& edge : graph->odometry) {
    const auto place = [&](int node) {
      return by_time_ ? 1e-9 * static_cast<double>(graph->nodes[static_cast<std::size_t>(node)].timestamp_ns)
                      : static_cast<double>(node);
    };
    const std::string at = path + ": edge " + std::to_string(edge.a) + " " + std::to_string(edge.b);
    Interval span{place(edge.a), place(edge.b), Se3(), edge.information};
    if (!(span.end > span.begin))
      return Error{ErrorCode::kFormat,
                   at + " goes back in time; odometry edges join a vertex to a later one"};
    if (by_time_ && !trajectory.at(span.end, kMaxGap_s, &span.T_odom_end)) continue;
    if (Status added = add(at, span); !added) return added;
  }
  return {};
}

bool OdometryInformation::between(const FramePlace& from, const FramePlace& to, Matrix6d* information) const {
  const double begin = by_time_ ? from.time_s : from.number, end = by_time_ ? to.time_s : to.number;
  const auto after = std::upper_bound(spans_.begin(), spans_.end(), begin + kSameFrame,
                                      [](double value, const Interval& span) { return value < span.begin; });
  if (from.number < 0 || after == spans_.begin()) return false;
  const Interval& span = *std::prev(after);
  if (end > span.end + kSameFrame || begin < span.begin - kSameFrame) return false;
  // Σ_edge = Σ_k A_k Σ_k A_kᵀ with A_k = Ad(T_end_k), as append_fragment sums them.
  Se3 T_odom_to = span.T_odom_end;
  if (by_time_ && !trajectory_.at(to.time_s, kMaxGap_s, &T_odom_to)) return false;
  const Matrix6d A = (span.T_odom_end.inverse() * T_odom_to).adjoint();
  const double share = std::min(1.0, (end - begin) / (span.end - span.begin));
  *information = A.transpose() * span.information * A / share;
  return true;
}

}  // namespace loopsift::tool
