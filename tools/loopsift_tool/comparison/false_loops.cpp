// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/comparison/false_loops.hpp"

#include <algorithm>
#include <random>

namespace loopsift::tool {
namespace {

constexpr double kDegree = 3.14159265358979 / 180.0;
constexpr double kFalseBeyond_m = 0.2, kFalseBeyond_rad = 12.0 * kDegree;

struct Pair {
  FragmentId i, j;
};

class FalseLoops {
 public:
  FalseLoops(const std::vector<Loop>& loops, const std::vector<Se3>& T_gt_fragment, unsigned seed)
      : loops_(loops), T_gt_fragment_(T_gt_fragment), random_(seed) {}

  // One of the three kinds. Where a place looks like another a swapped motion may be true: then once more.
  Loop draw() {
    while (true) {
      const Loop& model = loops_[below(loops_.size())];
      Loop loop = model;
      switch (below(3)) {
        case 0: {
          const Pair pair = any_pair();
          loop.i = pair.i;
          loop.j = pair.j;
          loop.T_i_j = motion({model.i, model.j});
          break;
        }
        case 1:
          loop.T_i_j = motion({model.i, model.j}) * offset(0.3, 1.0, 30.0, 90.0);
          break;
        default:
          loop.T_i_j = motion({model.i, model.j}) * offset(0.25, 0.6, 0.0, 8.0);
      }
      const Se3 error = motion({loop.i, loop.j}).inverse() * loop.T_i_j;
      if (error.translation().norm() > kFalseBeyond_m || error.angle() > kFalseBeyond_rad) return loop;
    }
  }

 private:
  [[nodiscard]] Se3 motion(const Pair& pair) const {
    return T_gt_fragment_[pair.i.index()].inverse() * T_gt_fragment_[pair.j.index()];
  }
  Pair any_pair() {  // no neighbours
    while (true) {
      const auto i = static_cast<std::int32_t>(below(T_gt_fragment_.size()));
      const auto j = static_cast<std::int32_t>(below(T_gt_fragment_.size()));
      if (j > i + 1) return {FragmentId{i}, FragmentId{j}};
    }
  }
  Se3 offset(double least_m, double most_m, double least_deg, double most_deg) {
    const Eigen::Vector3d t = between(least_m, most_m) * direction();
    const Eigen::Vector3d w = between(least_deg, most_deg) * kDegree * direction();
    return {so3_exp(w), t};
  }
  Eigen::Vector3d direction() {
    while (true) {
      const Eigen::Vector3d v(between(-1, 1), between(-1, 1), between(-1, 1));
      if (v.norm() > 0.1 && v.norm() <= 1.0) return v.normalized();
    }
  }
  // Of the generator's own numbers, which the standard fixes; its distributions it does not.
  double between(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  std::size_t below(std::size_t count) { return random_() % count; }

  const std::vector<Loop>& loops_;
  const std::vector<Se3>& T_gt_fragment_;
  std::mt19937 random_;
};

}  // namespace

Expected<std::vector<Loop>> make_false_loops(const std::vector<Loop>& loops, const Truth& truth,
                                             Span<const Fragment> fragments, int count, unsigned seed) {
  if (loops.empty() || fragments.size() < 4)
    return Error{ErrorCode::kUsage,
                 "false loops are made after given ones, between at least 4 fragments: give loops"};
  std::vector<Se3> T_gt_fragment;
  for (const Fragment& fragment : fragments) {
    const Expected<Se3> T = truth.motion(fragments, FragmentId{0}, fragment.id);
    if (!T) return T.error();
    T_gt_fragment.push_back(*T);
  }
  int highest = 0;
  for (const Loop& loop : loops) highest = std::max(highest, loop.id.value);
  FalseLoops source(loops, T_gt_fragment, seed);
  std::vector<Loop> wrong;
  for (int k = 0; k < count; ++k) {
    wrong.push_back(source.draw());
    wrong.back().id.value = highest + 1 + k;
  }
  return wrong;
}

}  // namespace loopsift::tool
