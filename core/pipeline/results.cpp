// SPDX-License-Identifier: MIT
#include "core/pipeline/results.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <memory>

#include "core/fragment/surfel_ply.hpp"

namespace loopsift {
namespace {

// A score, or nothing where the loop was not tested.
void append_number(bool known, double value, std::string* line) {
  char text[32] = "";
  if (known) std::snprintf(text, sizeof text, "%.9g", value);
  *line += ',';
  *line += text;
}

std::string csv_row(const SiftedLoop& r) {
  char head[64];
  std::snprintf(head, sizeof head, "%" PRId32 ",%" PRId32 ",%" PRId32, r.loop.id.value, r.loop.i.value,
                r.loop.j.value);
  std::string line = head;
  append_number(r.rank >= 0, r.single_score, &line);
  line += ',' + std::to_string(r.rank);
  const bool tested = r.reason != Reason::kNotTested && r.rank >= 0;
  append_number(tested, r.tested_score, &line);
  append_number(tested, r.best_score_before, &line);
  return line + ',' + to_string(r.decision) + ',' + to_string(r.reason) + ',' +
         std::to_string(r.frame_decided) + '\n';
}

Status write_loops_csv(const std::string& path, std::vector<SiftedLoop> records) {
  std::sort(records.begin(), records.end(),
            [](const SiftedLoop& a, const SiftedLoop& b) { return a.loop.id < b.loop.id; });
  const auto close = [](std::FILE* f) { return std::fclose(f); };
  std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "w"), close);
  if (file == nullptr) return Error{ErrorCode::kIo, path + ": cannot be created"};
  std::fputs(
      "id,fragment_i,fragment_j,single_dmp,rank,tested_dmp,best_dmp_before,decision,reason,frame_decided\n",
      file.get());
  for (const SiftedLoop& r : records) std::fputs(csv_row(r).c_str(), file.get());
  const bool failed = std::ferror(file.get()) != 0;
  if (std::fclose(file.release()) != 0 || failed)
    return Error{ErrorCode::kIo, path + ": writing failed; is the disk full?"};
  return {};
}

// The first failure of several steps.
class FirstFailure {
 public:
  void note(const Status& status) {
    if (status_.ok() && !status.ok()) status_ = status;
  }
  [[nodiscard]] const Status& status() const { return status_; }

 private:
  Status status_;
};

}  // namespace

std::vector<Se3> map_poses(const BackEnd& back_end, Span<const Fragment> fragments) {
  std::vector<Se3> poses = back_end.T_map_fragment();
  for (std::size_t f = poses.size(); f < fragments.size(); ++f) {
    poses.push_back(back_end.T_map_odom() * fragments[f].T_odom_fragment);
  }
  return poses;
}

Status write_results(const std::string& out, const BackEnd& back_end, Span<const OdometryPose> frames,
                     Span<const Fragment> fragments) {
  FirstFailure failure;
  const auto note = [&failure](const Status& status) { failure.note(status); };
  const Sifter& sifter = back_end.sifter();
  const int count = back_end.fragment_count();
  note(write_trajectory_tum(out + "/trajectory_odometry.txt", odometry_trajectory(frames)));
  note(write_trajectory_tum(out + "/trajectory.txt",
                            corrected_trajectory(frames, back_end.odometry_graph(), sifter.T_map_node())));
  note(write_loops(out + "/proposals", back_end.proposals(), count));
  note(write_loops(out + "/accepted", sifter.accepted(), count));
  note(write_loops_csv(out + "/loops.csv", {sifter.records().begin(), sifter.records().end()}));
  note(write_g2o(out + "/posegraph.g2o", sifter.graph()));
  const std::vector<Se3> poses = map_poses(back_end, fragments);
  note(write_surfel_ply(out + "/map.ply", fragments, poses));
  return failure.status();
}

Status write_front_results(const std::string& out, const Se3& T_map_odom, Span<const OdometryPose> frames,
                           Span<const Fragment> fragments) {
  FirstFailure failure;
  Trajectory trajectory = odometry_trajectory(frames);
  failure.note(write_trajectory_tum(out + "/trajectory_odometry.txt", trajectory));
  for (StampedPose& pose : trajectory.poses) pose.T_world_camera = T_map_odom * pose.T_world_camera;
  failure.note(write_trajectory_tum(out + "/trajectory.txt", trajectory));
  std::vector<Se3> poses;
  for (const Fragment& fragment : fragments) poses.push_back(T_map_odom * fragment.T_odom_fragment);
  failure.note(write_surfel_ply(out + "/map.ply", fragments, poses));
  return failure.status();
}

}  // namespace loopsift
