// SPDX-License-Identifier: MIT
// Realizing, reversing, recovering: loops are clustered by the times of their ends; a cluster must be
// consistent with the odometry alone (algorithm 1), then clusters with each other (algorithm 2), and those
// rejected get another chance whenever the good set has grown (algorithm 3). "Consistent": a χ² below its
// 95 % quantile, of the whole graph, of a loop or of all loops. Every optimisation starts from the odometry.
#include <algorithm>
#include <cstdlib>
#include <set>

#include "tools/loopsift_tool/filters/chi_squared.hpp"
#include "tools/loopsift_tool/filters/weighted_graph.hpp"

namespace loopsift::tool {
namespace {

constexpr int kDimension = 6;  // of a loop or an odometry edge
using Cluster = std::vector<std::size_t>;
using Clusters = std::set<std::size_t>;

/// χ² of a graph with some of the loops, optimised.
struct Optimized {
  double graph_chi2 = 0, loops_chi2 = 0;
  int loops = 0;
  std::vector<double> chi2;  // of every loop
};

class Rrr {
 public:
  Rrr(const PoseGraph& odometry, WeightedGraph* graph, std::vector<Cluster> clusters)
      : odometry_edges_(static_cast<int>(odometry.odometry.size())),
        graph_(graph),
        clusters_(std::move(clusters)) {}

  // Algorithm 3. The clusters that are left in the end, as marks on the loops.
  Expected<std::vector<bool>> run() {
    for (std::size_t c = 0; c < clusters_.size(); ++c)
      if (const Status checked = check_alone(c); !checked) return checked.error();
    Clusters rejected;
    while (true) {
      Clusters current;
      for (const std::size_t c : consistent_)
        if (good_.count(c) == 0 && rejected.count(c) == 0) current.insert(c);
      Clusters candidates;
      if (const Status found = find_candidates(current, &candidates); !found) return found.error();
      if (candidates.empty()) return marks(good_, {});
      const std::size_t before = good_.size();
      Clusters rejected_now;
      if (const Status grown = grow(candidates, &rejected_now); !grown) return grown.error();
      if (good_.size() > before) rejected.clear();
      rejected.insert(rejected_now.begin(), rejected_now.end());
    }
  }

 private:
  // Algorithm 1: a cluster on the odometry; loops that disagree with the rest of it leave it.
  Status check_alone(std::size_t c) {
    const Expected<Optimized> alone = optimize(marks({c}, {}));
    if (!alone) return alone.error();
    if (!graph_consistent(*alone)) return {};
    Cluster& cluster = clusters_[c];
    cluster.erase(std::remove_if(cluster.begin(), cluster.end(),
                                 [&](std::size_t loop) { return !loop_consistent(*alone, loop); }),
                  cluster.end());
    if (!cluster.empty()) consistent_.insert(c);
    return {};
  }

  // The clusters with at least one loop that agrees when all of them are in.
  Status find_candidates(const Clusters& current, Clusters* candidates) {
    if (current.empty()) return {};
    const Expected<Optimized> all = optimize(marks(good_, current));
    if (!all) return all.error();
    for (const std::size_t c : current)
      if (std::any_of(clusters_[c].begin(), clusters_[c].end(),
                      [&](std::size_t loop) { return loop_consistent(*all, loop); }))
        candidates->insert(c);
    return {};
  }

  // Algorithm 2: all candidates, less the worst one each time, until what is left is consistent.
  Status grow(Clusters candidates, Clusters* rejected) {
    while (!candidates.empty()) {
      const Expected<Optimized> together = optimize(marks(good_, candidates));
      if (!together) return together.error();
      if (graph_consistent(*together) &&
          together->loops_chi2 < chi2_quantile_95(kDimension * together->loops)) {
        good_.insert(candidates.begin(), candidates.end());
        return {};
      }
      const std::size_t worst = *std::max_element(
          candidates.begin(), candidates.end(),
          [&](std::size_t a, std::size_t b) { return index(*together, a) < index(*together, b); });
      candidates.erase(worst);
      rejected->insert(worst);
    }
    return {};
  }

  // The consistency index of a cluster: its χ² by its quantile.
  [[nodiscard]] double index(const Optimized& at, std::size_t c) const {
    double chi2 = 0;
    for (const std::size_t loop : clusters_[c]) chi2 += at.chi2[loop];
    return chi2 / chi2_quantile_95(kDimension * static_cast<int>(clusters_[c].size()));
  }
  [[nodiscard]] bool graph_consistent(const Optimized& at) const {
    return at.graph_chi2 < chi2_quantile_95(kDimension * (odometry_edges_ + at.loops));
  }
  [[nodiscard]] static bool loop_consistent(const Optimized& at, std::size_t loop) {
    return at.chi2[loop] < chi2_quantile_95(kDimension);
  }

  [[nodiscard]] std::vector<bool> marks(const Clusters& some, const Clusters& others) const {
    std::vector<bool> marked(graph_->term_count(), false);
    for (const Clusters* set : {&some, &others})
      for (const std::size_t c : *set)
        for (const std::size_t loop : clusters_[c]) marked[loop] = true;
    return marked;
  }
  Expected<Optimized> optimize(const std::vector<bool>& with) {
    graph_->restart();
    if (Status status = graph_->solve_weighted({with.begin(), with.end()}); !status) return status.error();
    Optimized at;
    at.chi2 = graph_->term_chi2();
    for (std::size_t loop = 0; loop < with.size(); ++loop) {
      if (!with[loop]) continue;
      at.loops_chi2 += at.chi2[loop];
      ++at.loops;
    }
    at.graph_chi2 = graph_->odometry_chi2() + at.loops_chi2;
    return at;
  }

  int odometry_edges_;
  WeightedGraph* graph_;
  std::vector<Cluster> clusters_;
  Clusters consistent_, good_;
};

// Loops whose first ends and whose second ends are close in time, each to some other of its cluster.
std::vector<Cluster> cluster_by_time(const PoseGraph& graph, Span<const Loop> loops, double window_s) {
  const auto apart_s = [&](FragmentId a, FragmentId b) {
    const auto time_ns = [&](FragmentId f) {
      return graph.nodes[static_cast<std::size_t>(graph.first_node[f.index()])].timestamp_ns;
    };
    return 1e-9 * static_cast<double>(std::abs(time_ns(a) - time_ns(b)));
  };
  const auto close = [&](std::size_t a, std::size_t b) {
    return apart_s(loops[a].i, loops[b].i) <= window_s && apart_s(loops[a].j, loops[b].j) <= window_s;
  };
  std::vector<Cluster> clusters;
  std::vector<bool> placed(loops.size(), false);
  for (std::size_t seed = 0; seed < loops.size(); ++seed) {
    if (placed[seed]) continue;
    placed[seed] = true;
    Cluster cluster = {seed};
    for (std::size_t k = 0; k < cluster.size(); ++k) {
      for (std::size_t other = 0; other < loops.size(); ++other) {
        if (placed[other] || !close(cluster[k], other)) continue;
        placed[other] = true;
        cluster.push_back(other);
      }
    }
    clusters.push_back(std::move(cluster));
  }
  return clusters;
}

}  // namespace

Expected<FilterResult> run_rrr(const PoseGraph& odometry_graph, Span<const Loop> loops,
                               const RrrOptions& options) {
  Expected<WeightedGraph> graph = WeightedGraph::make(odometry_graph, loops, WeightPer::kLoop);
  if (!graph.ok()) return graph.error();
  Rrr rrr(odometry_graph, &*graph, cluster_by_time(odometry_graph, loops, options.cluster_window_s));
  const Expected<std::vector<bool>> chosen = rrr.run();
  if (!chosen.ok()) return chosen.error();
  return finish_with(*chosen, &*graph);
}

}  // namespace loopsift::tool
