// SPDX-License-Identifier: MIT
#include "tools/evaluation/trajectory_formats.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <vector>

#include "core/base/text_file.hpp"

namespace loopsift {
namespace {

constexpr double kRotationTolerance = 0.05;  // of R Rᵀ − I and of |q|: files with few digits
constexpr std::size_t kEurocFields = 8;
constexpr const char* kFormats = "tum, kitti, euroc, redwood";

/// A folder in ASL form: the ground truth in it.
std::string euroc_file(const std::string& folder) {
  for (const char* inside :
       {"/data.csv", "/state_groundtruth_estimate0/data.csv", "/mav0/state_groundtruth_estimate0/data.csv"})
    if (std::filesystem::exists(folder + inside)) return folder + inside;
  return "";
}

/// The fields of a line of comma-separated values; spaces around them do not matter.
std::vector<std::string> comma_fields(const TextFile& file) {
  std::string line;
  for (const std::string_view word : file.words()) line += word;
  std::vector<std::string> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

Expected<TrajectoryFormat> format_of(const TextFile& file) {
  const auto& words = file.words();
  for (const std::string_view word : words)
    if (word.find(',') != std::string_view::npos) return TrajectoryFormat::kEuroc;
  if (words.size() == 12) return TrajectoryFormat::kKitti;
  if (words.size() == 8) return TrajectoryFormat::kTum;
  if (words.size() == 3) return TrajectoryFormat::kRedwood;
  return file.error(
      "is no line of a trajectory that is known here: TUM has 8 numbers, KITTI 12, EuRoC "
      "commas, redwood a header of 3; name it with --format if that guess is wrong");
}

Expected<StampedPose> read_kitti_line(const TextFile& file, std::size_t frame) {
  const auto& words = file.words();
  if (words.size() != 12)
    return file.error("a KITTI pose has 12 numbers, not " + std::to_string(words.size()));
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  for (std::size_t k = 0; k < 12; ++k)
    if (!parse_number(words[k], &T(static_cast<int>(k) / 4, static_cast<int>(k) % 4)))
      return file.error("'" + std::string(words[k]) + "' is not a finite number");
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRotationTolerance ||
      R.determinant() < 0)
    return file.error("the 3x4 matrix is no rigid motion");
  return StampedPose{static_cast<double>(frame), Se3::from_matrix(T)};
}

Expected<StampedPose> read_euroc_line(const TextFile& file) {
  const std::vector<std::string> fields = comma_fields(file);
  if (fields.size() < kEurocFields)
    return file.error("a EuRoC pose has at least 8 values (ns,px,py,pz,qw,qx,qy,qz), not " +
                      std::to_string(fields.size()));
  std::int64_t time_ns = 0;
  const std::string& time = fields[0];
  const auto [end, problem] = std::from_chars(time.data(), time.data() + time.size(), time_ns);
  if (problem != std::errc() || end != time.data() + time.size())
    return file.error("'" + time + "' is no time stamp in nanoseconds");
  double v[7];
  for (std::size_t k = 0; k < 7; ++k)
    if (!parse_number(fields[k + 1], &v[k]))
      return file.error("'" + fields[k + 1] + "' is not a finite number");
  const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
  if (std::abs(q.norm() - 1.0) > kRotationTolerance)
    return file.error("qw qx qy qz is no rotation: its length is " + std::to_string(q.norm()));
  return StampedPose{static_cast<double>(time_ns) * 1e-9, Se3(q, {v[0], v[1], v[2]})};
}

Expected<Trajectory> read_lines(const std::string& path, TrajectoryFormat format) {
  Expected<TextFile> file = TextFile::open(path);
  if (!file) return file.error();
  Trajectory trajectory;
  trajectory.indexed = format == TrajectoryFormat::kKitti;
  while (file->next()) {
    const Expected<StampedPose> pose =
        trajectory.indexed ? read_kitti_line(*file, trajectory.poses.size()) : read_euroc_line(*file);
    if (!pose) return pose.error();
    if (!trajectory.poses.empty() && pose->time_s < trajectory.poses.back().time_s)
      return file->error("time goes back here; sort the poses by time");
    trajectory.poses.push_back(*pose);
  }
  return trajectory;
}

Expected<TrajectoryFormat> detect(const std::string& path) {
  Expected<TextFile> file = TextFile::open(path);
  if (!file) return file.error();
  if (!file->next()) return Error{ErrorCode::kFormat, path + ": holds no pose"};
  return format_of(*file);
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9f", value);
  return text;
}

std::string kitti_line(const Se3& T) {
  const Eigen::Matrix4d M = T.matrix();
  std::string line;
  for (int k = 0; k < 12; ++k) line += (k > 0 ? " " : "") + number(M(k / 4, k % 4));
  return line + "\n";
}

std::string euroc_line(double time_s, const Se3& T) {
  const Eigen::Vector3d& t = T.translation();
  const Eigen::Quaterniond q = T.quaternion();
  std::string line = std::to_string(std::llround(time_s * 1e9));
  for (const double v : {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()}) line += "," + number(v);
  return line + "\n";
}

Status write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (!file)
    return Error{ErrorCode::kIo, path + ": cannot be written; check the folder's rights and free space"};
  return {};
}

}  // namespace

Expected<TrajectoryFormat> trajectory_format(const std::string& name) {
  if (name == "tum") return TrajectoryFormat::kTum;
  if (name == "kitti") return TrajectoryFormat::kKitti;
  if (name == "euroc") return TrajectoryFormat::kEuroc;
  if (name == "redwood") return TrajectoryFormat::kRedwood;
  return Error{ErrorCode::kUsage, "'" + name + "' is no trajectory format; known are " + kFormats};
}

Expected<Trajectory> read_any_trajectory(const std::string& path, std::optional<TrajectoryFormat> format) {
  std::string file = path;
  if (std::filesystem::is_directory(path)) {
    file = euroc_file(path);
    if (file.empty())
      return Error{ErrorCode::kNotFound,
                   path + ": is a folder without a data.csv of a EuRoC ground truth; name the file"};
  }
  const Expected<TrajectoryFormat> found = format ? Expected<TrajectoryFormat>(*format) : detect(file);
  if (!found) return found.error();
  if (*found == TrajectoryFormat::kTum || *found == TrajectoryFormat::kRedwood) return read_trajectory(file);
  Expected<Trajectory> trajectory = read_lines(file, *found);
  if (trajectory.ok() && trajectory->poses.empty())
    return Error{ErrorCode::kFormat, file + ": holds no pose"};
  return trajectory;
}

Status write_any_trajectory(const std::string& path, const Trajectory& trajectory, TrajectoryFormat format,
                            double rate_hz) {
  if (format == TrajectoryFormat::kRedwood) return write_trajectory_log(path, trajectory);
  Trajectory timed = trajectory;
  if (timed.indexed)
    for (StampedPose& pose : timed.poses) pose.time_s /= rate_hz;
  timed.indexed = false;
  if (format == TrajectoryFormat::kTum) return write_trajectory_tum(path, timed);
  std::string text;
  if (format == TrajectoryFormat::kEuroc)
    text = "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  for (const StampedPose& pose : timed.poses)
    text += format == TrajectoryFormat::kKitti ? kitti_line(pose.T_world_camera)
                                               : euroc_line(pose.time_s, pose.T_world_camera);
  return write_text(path, text);
}

}  // namespace loopsift
