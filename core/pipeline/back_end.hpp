// SPDX-License-Identifier: MIT
// The back thread's whole work on closed fragments: graph → proposals → sift → correction.
// In: closed fragments in order, and loops from elsewhere. Out: the best map's poses. Capacity: that of the
// proposer, the scorer and the list of loops; a fragment past it is counted and left out of sifting (the map
// keeps it where the odometry put it). Thread: back. Allocates.
#pragma once
#include <atomic>
#include <functional>
#include <vector>

#include "core/base/arena.hpp"
#include "core/base/latency_histogram.hpp"
#include "core/fragment/fragment.hpp"
#include "core/pipeline/odometry_calibration.hpp"
#include "core/posegraph/pose_graph.hpp"
#include "core/posterior/map_scorer.hpp"
#include "core/proposal/proposer.hpp"
#include "core/sifter/sifter.hpp"

namespace loopsift {

struct BackEndOptions {
  bool propose = true;             ///< register fragments; false: loops only come from elsewhere
  bool calibrate_odometry = true;  ///< scale the odometry's covariances by what neighbouring fragments show
  int keyframes_per_fragment = 2;  ///< graph nodes of a fragment
  int steps_per_fragment = 256;  ///< of sifting, that the back thread does before it takes the next fragment
  double slice_s = 0.8;          ///< and how long after the fragment closed, in real time
  double finish_limit_s = 600;   ///< for finish()
  ProposalOptions proposal;
  PosteriorOptions posterior;
  SifterOptions sifter;
};

class BackEnd {
 public:
  BackEnd(const BackEndOptions& options, Arena& arena);

  /// The next fragment: into the graph and the scorer, and proposals against earlier ones, which work() then
  /// sifts. False when there was no room for it.
  bool add_fragment(const Fragment& fragment);
  /// Without proposals: for batch use, before update_sifter, add_loops and finish.
  bool insert_fragment(const Fragment& fragment);
  /// Loops from elsewhere, by the same door as the proposals. A loop whose id is taken gets the next free
  /// one.
  void add_loops(Span<const Loop> loops);
  /// At most so many steps of sifting (see Sifter). True when there is more to do.
  bool work(int max_steps) { return sifter_.work(max_steps); }
  /// Sifts all loops once more from the odometry's map: the batch result. Call at the end of a run. False
  /// when the limit or the no of go_on, which is asked before each step, came first; the map stays as it was
  /// then.
  bool finish(const std::function<bool()>& go_on = {}) {
    return sifter_.finish(options_.finish_limit_s, go_on);
  }
  /// Once *stop is set (null: never), add_fragment() ends after the registration in work.
  void stop_on(const std::atomic<bool>* stop) { proposer_.stop_on(stop); }

  /// All loops as they were proposed or handed in, by id; without those that the list dropped.
  [[nodiscard]] std::vector<Loop> proposals() const;
  [[nodiscard]] const Sifter& sifter() const { return sifter_; }
  [[nodiscard]] Sifter& sifter() { return sifter_; }
  [[nodiscard]] const MapScorer& scorer() const { return scorer_; }
  /// What prepares the sifter after insert_fragment: the graph, its information calibrated.
  void update_sifter();
  /// The odometry's graph: its poses are the odometry's, its information as the odometry claims it.
  [[nodiscard]] const PoseGraph& odometry_graph() const { return graph_; }
  /// The same with the information that sifting uses. After update_sifter or add_fragment.
  [[nodiscard]] const PoseGraph& calibrated_graph() const { return calibrated_graph_; }
  [[nodiscard]] int fragment_count() const { return static_cast<int>(fragments_.size()); }
  [[nodiscard]] int fragments_left_out() const { return fragments_left_out_; }
  /// Fragments whose registration ran out of the memory that the thread is allowed
  /// (core/base/heap_watch.hpp).
  [[nodiscard]] int registrations_refused() const { return registrations_refused_; }
  /// Pose of each fragment in the best map.
  [[nodiscard]] std::vector<Se3> T_map_fragment() const;
  /// Correction in force at the newest fragment.
  [[nodiscard]] Se3 T_map_odom() const;
  /// Whether edges of the odometry and of accepted loops join the newest fragment to the first. After a loss
  /// of tracking they do not until a loop of the new piece is accepted; T_map_odom() says nothing until then.
  [[nodiscard]] bool anchored() const;
  /// First frame of the piece of trajectory that the newest fragment is of; invalid before the first one.
  [[nodiscard]] FrameId piece() const;
  /// DMP (plain, m²) of the odometry's map and of the best one, over the score views.
  [[nodiscard]] double dmp_odometry() const;
  [[nodiscard]] double dmp_final() const;
  [[nodiscard]] const LatencyHistogram& proposal_times() const { return proposal_times_; }

 private:
  void propose_again(Span<const Se3> T_map_fragment);
  [[nodiscard]] bool id_is_taken(LoopId id) const;

  BackEndOptions options_;
  MapScorer scorer_;
  Proposer proposer_;
  Sifter sifter_;
  OdometryCalibration calibration_;
  PoseGraph graph_;  // with the odometry's own information
  PoseGraph calibrated_graph_;
  std::vector<const Fragment*> fragments_;
  std::vector<Loop> proposed_;  // with the newest fragment
  std::int32_t next_loop_id_ = 0;
  int fragments_left_out_ = 0, registrations_refused_ = 0;
  LatencyHistogram proposal_times_;
};

}  // namespace loopsift
