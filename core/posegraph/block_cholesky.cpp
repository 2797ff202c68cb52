// SPDX-License-Identifier: MIT
#include "core/posegraph/block_cholesky.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <climits>

namespace loopsift {
namespace {

constexpr int kEliminated = INT_MAX;

std::size_t words_for(int rows) { return (static_cast<std::size_t>(rows) + 63) / 64; }

}  // namespace

BlockCholesky::BlockCholesky(Arena* arena, int max_rows, int max_blocks) : words_(words_for(max_rows)) {
  const auto rows = static_cast<std::size_t>(max_rows), blocks = static_cast<std::size_t>(max_blocks);
  adjacency_ = arena->carve<std::uint64_t>("posegraph/pattern", rows * words_);
  degree_ = arena->carve<int>("posegraph/pattern", rows);
  place_of_ = arena->carve<int>("posegraph/pattern", rows);
  column_begin_ = arena->carve<int>("posegraph/pattern", rows + 1);
  row_place_ = arena->carve<int>("posegraph/pattern", blocks);
  diagonal_ = arena->carve<Matrix6d>("posegraph/normal equations", rows);
  blocks_ = arena->carve<Matrix6d>("posegraph/normal equations", blocks);
  inverse_L_ = arena->carve<Matrix6d>("posegraph/factor", rows);
  factor_ = arena->carve<Matrix6d>("posegraph/factor", blocks);
  permuted_ = arena->carve<Vector6d>("posegraph/factor", rows);
}

void BlockCholesky::begin(int rows) {
  assert(static_cast<std::size_t>(rows) <= degree_.size());
  rows_ = rows;
  std::fill(adjacency_.begin(), neighbours(rows), 0);
}

void BlockCholesky::connect(int a, int b) {
  neighbours(a)[b / 64] |= std::uint64_t{1} << (b % 64);
  neighbours(b)[a / 64] |= std::uint64_t{1} << (a % 64);
}

bool BlockCholesky::analyze() {
  const std::size_t words = words_for(rows_);
  for (int row = 0; row < rows_; ++row) {
    int degree = 0;
    for (std::size_t w = 0; w < words; ++w) degree += __builtin_popcountll(neighbours(row)[w]);
    degree_[static_cast<std::size_t>(row)] = degree;
  }
  block_count_ = 0;
  for (int place = 0; place < rows_; ++place)
    if (!eliminate(next_to_eliminate(), place)) return false;
  column_begin_[static_cast<std::size_t>(rows_)] = block_count_;
  sort_columns();
  return true;
}

// The lowest row of least degree.
int BlockCholesky::next_to_eliminate() const {
  const int* begin = degree_.data();
  return static_cast<int>(std::min_element(begin, begin + rows_) - begin);
}

// Notes the row's neighbours as its column of the factor and joins them to one another.
bool BlockCholesky::eliminate(int row, int place) {
  const std::size_t words = words_for(rows_);
  const std::uint64_t* own = neighbours(row);
  degree_[static_cast<std::size_t>(row)] = kEliminated;
  place_of_[static_cast<std::size_t>(row)] = place;
  column_begin_[static_cast<std::size_t>(place)] = block_count_;
  for (std::size_t word = 0; word < words; ++word)
    for (std::uint64_t bits = own[word]; bits != 0; bits &= bits - 1) {
      if (static_cast<std::size_t>(block_count_) == row_place_.size()) return false;
      const int other = static_cast<int>(word) * 64 + __builtin_ctzll(bits);
      row_place_[static_cast<std::size_t>(block_count_++)] = other;
      std::uint64_t* theirs = neighbours(other);
      int degree = 0;
      for (std::size_t w = 0; w < words; ++w) {
        theirs[w] |= own[w];
        degree += __builtin_popcountll(theirs[w]);
      }
      theirs[other / 64] &= ~(std::uint64_t{1} << (other % 64));
      theirs[row / 64] &= ~(std::uint64_t{1} << (row % 64));
      degree_[static_cast<std::size_t>(other)] = degree - 2;
    }
  return true;
}

// Rows into places, ascending, so that the columns of a product can be merged.
void BlockCholesky::sort_columns() {
  for (int k = 0; k < block_count_; ++k) {
    int& row = row_place_[static_cast<std::size_t>(k)];
    row = place_of_[static_cast<std::size_t>(row)];
  }
  for (std::size_t column = 0; column < static_cast<std::size_t>(rows_); ++column)
    std::sort(row_place_.data() + column_begin_[column], row_place_.data() + column_begin_[column + 1]);
}

void BlockCholesky::clear() {
  std::fill_n(diagonal_.data(), rows_, Matrix6d::Zero());
  std::fill_n(blocks_.data(), block_count_, Matrix6d::Zero());
}

void BlockCholesky::add_off_diagonal(int a, int b, const Matrix6d& H_ab) {
  const std::size_t place_a = place(a), place_b = place(b);
  const std::size_t column = std::min(place_a, place_b), row = std::max(place_a, place_b);
  const int* begin = row_place_.data() + column_begin_[column];
  const int* end = row_place_.data() + column_begin_[column + 1];
  const int* found = std::lower_bound(begin, end, static_cast<int>(row));
  assert(found != end && *found == static_cast<int>(row));
  Matrix6d& block = blocks_[static_cast<std::size_t>(found - row_place_.data())];
  if (place_a > place_b)
    block += H_ab;
  else
    block += H_ab.transpose();
}

bool BlockCholesky::factorize(double damping) {
  std::copy_n(blocks_.data(), block_count_, factor_.data());
  for (std::size_t k = 0; k < static_cast<std::size_t>(rows_); ++k) {
    inverse_L_[k] = diagonal_[k];
    inverse_L_[k].diagonal() += damping * scale_at(k);
  }
  for (int column = 0; column < rows_; ++column) {
    Matrix6d& pivot = inverse_L_[static_cast<std::size_t>(column)];
    const Eigen::LLT<Matrix6d> llt(pivot);
    if (llt.info() != Eigen::Success) return false;
    pivot = llt.matrixL().solve(Matrix6d::Identity());
    subtract_outer_product(column);
  }
  return true;
}

// Scales the column's blocks, L_ik = A_ik L_kk⁻ᵀ, and takes L_ik L_jkᵀ from A_ij for all i ≥ j below it. The
// column's rows are a subset of those of every column j that it meets, so one walk down j finds them all.
void BlockCholesky::subtract_outer_product(int column) {
  const auto begin = static_cast<std::size_t>(column_begin_[static_cast<std::size_t>(column)]);
  const auto end = static_cast<std::size_t>(column_begin_[static_cast<std::size_t>(column) + 1]);
  const Matrix6d& inverse_L = inverse_L_[static_cast<std::size_t>(column)];
  for (std::size_t k = begin; k < end; ++k) factor_[k] = (factor_[k] * inverse_L.transpose()).eval();
  for (std::size_t k = begin; k < end; ++k) {
    const auto j = static_cast<std::size_t>(row_place_[k]);
    const Matrix6d transposed = factor_[k].transpose();
    inverse_L_[j].noalias() -= factor_[k] * transposed;
    auto target = static_cast<std::size_t>(column_begin_[j]);
    for (std::size_t i = k + 1; i < end; ++i) {
      while (row_place_[target] != row_place_[i]) ++target;
      factor_[target].noalias() -= factor_[i] * transposed;
    }
  }
}

void BlockCholesky::solve(Span<Vector6d> b) const {
  const auto rows = static_cast<std::size_t>(rows_);
  for (std::size_t row = 0; row < rows; ++row) permuted_[place(static_cast<int>(row))] = b[row];
  for (std::size_t k = 0; k < rows; ++k) {  // L y = b
    permuted_[k] = (inverse_L_[k] * permuted_[k]).eval();
    for (int block = column_begin_[k]; block < column_begin_[k + 1]; ++block) {
      const auto at = static_cast<std::size_t>(block);
      permuted_[static_cast<std::size_t>(row_place_[at])].noalias() -= factor_[at] * permuted_[k];
    }
  }
  for (std::size_t k = rows; k-- > 0;) {  // Lᵀ x = y
    for (int block = column_begin_[k]; block < column_begin_[k + 1]; ++block) {
      const auto at = static_cast<std::size_t>(block);
      permuted_[k].noalias() -= factor_[at].transpose() * permuted_[static_cast<std::size_t>(row_place_[at])];
    }
    permuted_[k] = (inverse_L_[k].transpose() * permuted_[k]).eval();
  }
  for (std::size_t row = 0; row < rows; ++row) b[row] = permuted_[place(static_cast<int>(row))];
}

}  // namespace loopsift
