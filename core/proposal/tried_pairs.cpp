// SPDX-License-Identifier: MIT
#include "core/proposal/tried_pairs.hpp"

#include <limits>

namespace loopsift {

TriedPairs::TriedPairs(int max_fragments, Arena& arena) {
  const auto n = static_cast<std::size_t>(max_fragments);
  motions_ = arena.carve<Motion>("proposal/tried pairs", n * (n - 1) / 2);
}

void TriedPairs::set(std::size_t i, std::size_t j, const Se3& T_j_i) {
  Motion& motion = at(i, j);
  Eigen::Map<Eigen::Vector4f>{motion.q} =
      Eigen::Quaterniond(T_j_i.rotation()).normalized().coeffs().cast<float>();
  Eigen::Map<Eigen::Vector3f>{motion.t} = T_j_i.translation().cast<float>();
}

float TriedPairs::moved(std::size_t i, std::size_t j, const Se3& T_j_i, const Eigen::Vector3f& center,
                        float radius) const {
  const Motion& motion = at(i, j);
  const Eigen::Quaternionf before(motion.q[3], motion.q[0], motion.q[1], motion.q[2]);
  if (before.squaredNorm() == 0.0F) return std::numeric_limits<float>::infinity();
  const Eigen::Quaternionf now(T_j_i.rotation().cast<float>());
  const Eigen::Vector3f was = before * center + Eigen::Map<const Eigen::Vector3f>(motion.t);
  const Eigen::Vector3f is = now * center + T_j_i.translation().cast<float>();
  return (is - was).norm() + radius * now.angularDistance(before);
}

}  // namespace loopsift
