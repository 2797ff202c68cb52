// SPDX-License-Identifier: MIT
#include "core/geometry/trajectory.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/base/text_file.hpp"

namespace loopsift {
namespace {

constexpr double kQuaternionTolerance = 1e-2;  // of |q|, for files with few digits
constexpr double kSameTime_s = 1e-4;           // files round times to as little as four decimals
// Of R Rᵀ − I: published proposers write rotations scaled by up to 5 %, which are brought to the nearest one.
constexpr double kRotationTolerance = 0.2;

// Λ_ω = D Λ_q D with D = diag(1,1,1,½,½,½), since q_xyz ≈ ω/2.
Matrix6d scaled_rotation(const Matrix6d& information, double factor) {
  Vector6d d = Vector6d::Ones();
  d.tail<3>().setConstant(factor);
  return d.asDiagonal() * information * d.asDiagonal();
}

// The current line must hold exactly `count` finite numbers.
Status numbers(const TextFile& file, std::size_t count, double* values) {
  if (file.words().size() != count) {
    return file.error("expected " + std::to_string(count) + " numbers, found " +
                      std::to_string(file.words().size()) + " words");
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!parse_number(file.words()[i], &values[i])) {
      return file.error("'" + std::string(file.words()[i]) + "' is not a finite number");
    }
  }
  return {};
}

// `rows` lines of as many numbers, after a record's header.
Status matrix(TextFile& file, int rows, double* row_major) {
  for (int row = 0; row < rows; ++row) {
    if (!file.next()) return file.error("the file ends inside a record");
    const Status status = numbers(file, static_cast<std::size_t>(rows), row_major + row * rows);
    if (!status) return status;
  }
  return {};
}

Status header(const TextFile& file, int* a, int* b, int* n) {
  if (file.words().size() == 3 && parse_number(file.words()[0], a) && parse_number(file.words()[1], b) &&
      parse_number(file.words()[2], n)) {
    return {};
  }
  return file.error("expected a record's header of three integers (i j n)");
}

Expected<LogRecord> read_log_record(TextFile& file) {
  LogRecord record;
  Status status = header(file, &record.a, &record.b, &record.n);
  if (!status) return status.error();
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T;
  status = matrix(file, 4, T.data());
  if (!status) return status.error();
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRotationTolerance ||
      R.determinant() < 0 || (T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-6) {
    return file.error("the 4x4 matrix that ends here is no rigid motion");
  }
  record.T = Se3::from_matrix(T);
  return record;
}

Expected<StampedPose> read_tum_line(const TextFile& file) {
  double v[8];
  const Status status = numbers(file, 8, v);
  if (!status) return status.error();
  const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  if (std::abs(q.norm() - 1.0) > kQuaternionTolerance) {
    return file.error("qx qy qz qw is no rotation: its length is " + std::to_string(q.norm()));
  }
  return StampedPose{v[0], Se3(q, Eigen::Vector3d(v[1], v[2], v[3]))};
}

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

File create(const std::string& path) { return File(std::fopen(path.c_str(), "wb"), &std::fclose); }

Status close_written(const std::string& path, File file) {
  const bool good = file && std::fflush(file.get()) == 0 && std::ferror(file.get()) == 0;
  if (good) return {};
  return Error{ErrorCode::kIo, path + ": cannot be written: " + std::strerror(errno)};
}

void print_matrix(std::FILE* file, int rows, const double* row_major, const char* format) {
  for (int i = 0; i < rows * rows; ++i) {
    std::fprintf(file, format, row_major[i]);
    std::fputc(i % rows == rows - 1 ? '\n' : ' ', file);
  }
}

}  // namespace

bool Trajectory::at(double time_s, double max_gap_s, Se3* T_world_camera) const {
  const auto after = std::lower_bound(poses.begin(), poses.end(), time_s - kSameTime_s,
                                      [](const StampedPose& p, double t) { return p.time_s < t; });
  if (after == poses.end()) return false;
  if (after->time_s <= time_s + kSameTime_s) {
    *T_world_camera = after->T_world_camera;
    return true;
  }
  if (after == poses.begin()) return false;
  const StampedPose& before = *(after - 1);
  const double gap = after->time_s - before.time_s;
  if (!(gap <= max_gap_s)) return false;
  *T_world_camera = interpolate(before.T_world_camera, after->T_world_camera, (time_s - before.time_s) / gap);
  return true;
}

Expected<Trajectory> read_trajectory(const std::string& path) {
  Expected<TextFile> file = TextFile::open(path);
  if (!file) return file.error();
  Trajectory trajectory;
  while (file->next()) {
    const std::size_t words = file->words().size();
    if (trajectory.poses.empty()) trajectory.indexed = words == 3;
    if (words != (trajectory.indexed ? 3U : 8U)) {
      return file->error("neither a TUM line (t tx ty tz qx qy qz qw) nor a redwood .log header (i j n)");
    }
    StampedPose pose;
    if (trajectory.indexed) {
      const Expected<LogRecord> record = read_log_record(*file);
      if (!record) return record.error();
      pose = {static_cast<double>(record->a), record->T};
    } else {
      const Expected<StampedPose> line = read_tum_line(*file);
      if (!line) return line.error();
      pose = *line;
    }
    if (!trajectory.poses.empty() && pose.time_s < trajectory.poses.back().time_s) {
      return file->error("time goes back here; sort the poses by time");
    }
    trajectory.poses.push_back(pose);
  }
  if (trajectory.poses.empty()) return Error{ErrorCode::kFormat, path + ": holds no pose"};
  return trajectory;
}

Status write_trajectory_tum(const std::string& path, const Trajectory& trajectory) {
  File file = create(path);
  for (const StampedPose& pose : trajectory.poses) {
    if (!file) break;
    const Eigen::Vector3d& t = pose.T_world_camera.translation();
    const Eigen::Quaterniond q = pose.T_world_camera.quaternion();
    std::fprintf(file.get(), "%.9f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", pose.time_s, t.x(), t.y(), t.z(),
                 q.x(), q.y(), q.z(), q.w());
  }
  return close_written(path, std::move(file));
}

Status write_trajectory_log(const std::string& path, const Trajectory& trajectory) {
  std::vector<LogRecord> records;
  for (const StampedPose& pose : trajectory.poses) {
    const int k =
        trajectory.indexed ? static_cast<int>(std::lround(pose.time_s)) : static_cast<int>(records.size());
    records.push_back({k, k, k + 1, pose.T_world_camera});
  }
  return write_log(path, records);
}

Expected<std::vector<LogRecord>> read_log(const std::string& path) {
  Expected<TextFile> file = TextFile::open(path);
  if (!file) return file.error();
  std::vector<LogRecord> records;
  while (file->next()) {
    const Expected<LogRecord> record = read_log_record(*file);
    if (!record) return record.error();
    records.push_back(*record);
  }
  return records;
}

Status write_log(const std::string& path, const std::vector<LogRecord>& records) {
  File file = create(path);
  for (const LogRecord& record : records) {
    if (!file) break;
    std::fprintf(file.get(), "%d\t%d\t%d\n", record.a, record.b, record.n);
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T = record.T.matrix();
    print_matrix(file.get(), 4, T.data(), "%.10f");
  }
  return close_written(path, std::move(file));
}

Expected<std::vector<InfoRecord>> read_info(const std::string& path) {
  Expected<TextFile> file = TextFile::open(path);
  if (!file) return file.error();
  std::vector<InfoRecord> records;
  while (file->next()) {
    InfoRecord record;
    Status status = header(*file, &record.a, &record.b, &record.n);
    if (!status) return status.error();
    Eigen::Matrix<double, 6, 6, Eigen::RowMajor> L;
    status = matrix(*file, 6, L.data());
    if (!status) return status.error();
    const double scale = L.cwiseAbs().maxCoeff();
    if ((L - L.transpose()).cwiseAbs().maxCoeff() > 1e-4 * scale || L.diagonal().minCoeff() < 0) {
      return file->error(
          "the 6x6 matrix that ends here is no information matrix (not symmetric, or negative)");
    }
    record.information = scaled_rotation(0.5 * (L + L.transpose()), 0.5);
    records.push_back(record);
  }
  return records;
}

Status write_info(const std::string& path, const std::vector<InfoRecord>& records) {
  File file = create(path);
  for (const InfoRecord& record : records) {
    if (!file) break;
    std::fprintf(file.get(), "%d\t%d\t%d\n", record.a, record.b, record.n);
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> L = scaled_rotation(record.information, 2.0);
    print_matrix(file.get(), 6, L.data(), "%.12e");
  }
  return close_written(path, std::move(file));
}

}  // namespace loopsift
