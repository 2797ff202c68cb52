// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/filters/max_clique.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace loopsift::tool {
namespace {

class Search {
 public:
  Search(const std::vector<std::vector<bool>>& adjacent, std::int64_t budget)
      : adjacent_(adjacent), budget_(budget) {}

  // Candidates are adjacent to all of the clique so far; the last of them is branched on first.
  void expand(const std::vector<int>& candidates) {
    if (candidates.empty()) {
      if (clique_.size() > best_.size()) best_ = clique_;
      return;
    }
    std::vector<int> order, colors;
    color(candidates, &order, &colors);
    for (std::size_t k = order.size(); k-- > 0;) {
      if (clique_.size() + static_cast<std::size_t>(colors[k]) <= best_.size()) return;
      if (budget_-- <= 0) {
        proven_ = false;
        return;
      }
      clique_.push_back(order[k]);
      std::vector<int> next;
      for (std::size_t m = 0; m < k; ++m)
        if (are_adjacent(order[m], order[k])) next.push_back(order[m]);
      expand(next);
      clique_.pop_back();
    }
  }
  [[nodiscard]] MaxClique result() const {
    MaxClique result{best_, proven_};
    std::sort(result.members.begin(), result.members.end());
    return result;
  }

 private:
  [[nodiscard]] bool are_adjacent(int a, int b) const {
    return adjacent_[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
  }
  // Vertices by colour class, no two of a class adjacent: a clique among the first k of `order` has at most
  // colors[k] vertices.
  void color(const std::vector<int>& candidates, std::vector<int>* order, std::vector<int>* colors) const {
    std::vector<std::vector<int>> classes;
    for (const int vertex : candidates) {
      const auto fits = [&](const std::vector<int>& members) {
        return std::none_of(members.begin(), members.end(), [&](int m) { return are_adjacent(vertex, m); });
      };
      auto place = std::find_if(classes.begin(), classes.end(), fits);
      if (place == classes.end()) place = classes.insert(classes.end(), std::vector<int>());
      place->push_back(vertex);
    }
    for (std::size_t c = 0; c < classes.size(); ++c)
      for (const int vertex : classes[c]) {
        order->push_back(vertex);
        colors->push_back(static_cast<int>(c) + 1);
      }
  }

  const std::vector<std::vector<bool>>& adjacent_;
  std::int64_t budget_;
  std::vector<int> clique_, best_;
  bool proven_ = true;
};

}  // namespace

MaxClique max_clique(const std::vector<std::vector<bool>>& adjacent, std::int64_t budget) {
  std::vector<int> vertices(adjacent.size());
  std::iota(vertices.begin(), vertices.end(), 0);
  std::vector<std::ptrdiff_t> degrees;
  degrees.reserve(adjacent.size());
  for (const auto& row : adjacent) degrees.push_back(std::count(row.begin(), row.end(), true));
  // Many neighbours first: the greedy colouring then needs fewer colours.
  std::stable_sort(vertices.begin(), vertices.end(), [&](int a, int b) {
    return degrees[static_cast<std::size_t>(a)] > degrees[static_cast<std::size_t>(b)];
  });
  Search search(adjacent, budget);
  search.expand(vertices);
  return search.result();
}

}  // namespace loopsift::tool
