// SPDX-License-Identifier: MIT
// Sparse Cholesky factorisation of a symmetric positive definite matrix of 6×6 blocks, in fixed memory.
//
// In: which blocks are not zero, then their values. Out: the solution of H x = b. The elimination order is
// minimum degree (Tinney & Walker 1967; George & Liu, The evolution of the minimum degree ordering algorithm,
// 1989), found on a bit matrix: a chain with few loops is eliminated almost without fill. Capacity: blocks
// under the diagonal, fill included. Thread: any one at a time. Allocates in the constructor only, from the
// arena.
#pragma once
#include <cstdint>

#include "core/base/arena.hpp"
#include "core/base/span.hpp"
#include "core/geometry/se3.hpp"

namespace loopsift {

class BlockCholesky {
 public:
  /// Room for max_rows block rows and max_blocks blocks under the diagonal of the factor.
  BlockCholesky(Arena* arena, int max_rows, int max_blocks);

  /// Starts a new pattern of `rows` ≤ max_rows block rows, all independent.
  void begin(int rows);
  /// Says that block (a, b) may be non-zero, a ≠ b.
  void connect(int a, int b);
  /// Finds the order and the factor's pattern. False when it needs more than max_blocks blocks.
  [[nodiscard]] bool analyze();

  /// Sets all values to zero.
  void clear();
  /// Adds to block (a, a).
  void add_diagonal(int a, const Matrix6d& H_aa) { diagonal_[place(a)] += H_aa; }
  /// Adds to block (a, b) and its transpose to (b, a); the two were connected.
  void add_off_diagonal(int a, int b, const Matrix6d& H_ab);
  /// Factorises H + damping · damping_scale. H itself stays for another try. False when that is not positive
  /// definite.
  [[nodiscard]] bool factorize(double damping);
  /// Replaces b by the solution. After factorize.
  void solve(Span<Vector6d> b) const;
  /// What the damping multiplies at row a: the diagonal of H, at least a little where no edge knows anything.
  [[nodiscard]] Vector6d damping_scale(int a) const { return scale_at(place(a)); }
  /// Blocks under the diagonal of the factor, fill included.
  [[nodiscard]] int block_count() const { return block_count_; }

 private:
  [[nodiscard]] std::size_t place(int row) const {
    return static_cast<std::size_t>(place_of_[static_cast<std::size_t>(row)]);
  }
  [[nodiscard]] Vector6d scale_at(std::size_t at) const { return diagonal_[at].diagonal().cwiseMax(1e-6); }
  [[nodiscard]] std::uint64_t* neighbours(int row) const {
    return adjacency_.data() + static_cast<std::size_t>(row) * words_;
  }
  [[nodiscard]] int next_to_eliminate() const;
  [[nodiscard]] bool eliminate(int row, int place);
  void sort_columns();
  void subtract_outer_product(int column);

  std::size_t words_;  // 64-bit words in a row of the bit matrix
  int rows_ = 0;
  int block_count_ = 0;
  Span<std::uint64_t> adjacency_;      // of the rows not yet eliminated
  Span<int> degree_;                   // number of neighbours; kEliminated once out
  Span<int> place_of_;                 // row → place in the order of elimination
  Span<int> column_begin_;             // place → first block of its column; rows_ + 1 of them
  Span<int> row_place_;                // block → place of its row, ascending within a column
  Span<Matrix6d> diagonal_, blocks_;   // H
  Span<Matrix6d> inverse_L_, factor_;  // L: inverses of the diagonal blocks, blocks under it
  mutable Span<Vector6d> permuted_;
};

}  // namespace loopsift
