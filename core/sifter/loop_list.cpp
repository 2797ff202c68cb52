// SPDX-License-Identifier: MIT
#include "core/sifter/loop_list.hpp"

#include <algorithm>

namespace loopsift {

LoopList::LoopList(std::size_t max_loops, Arena& arena)
    : records_(arena.carve<SiftedLoop>("sifter/loops", max_loops)),
      dropped_loops_(arena.carve<SiftedLoop>("sifter/dropped loops", kDroppedKept)) {
  if (!arena.measuring()) ranking_.reserve(max_loops);
}

bool LoopList::add(const Loop& loop) {
  SiftedLoop record;
  record.loop = loop;
  if (size_ < records_.size()) {
    newest_ = size_++;
    records_[newest_] = record;
    return true;
  }
  const auto lowest = std::find_if(ranking_.rbegin(), ranking_.rend(), [this](std::size_t k) {
    return records_[k].decision != Decision::kAccepted && !records_[k].published;
  });
  if (lowest == ranking_.rend()) {
    drop(record);
    return false;
  }
  newest_ = *lowest;
  drop(records_[newest_]);
  records_[newest_] = record;
  const auto from = static_cast<std::size_t>(std::distance(lowest, ranking_.rend())) - 1;
  ranking_.erase(ranking_.begin() + static_cast<std::ptrdiff_t>(from));
  renumber(from);
  return true;
}

void LoopList::drop(const SiftedLoop& record) {
  dropped_loops_[static_cast<std::size_t>(dropped_++) % kDroppedKept] = record;
}

bool LoopList::take_dropped(SiftedLoop* record) {
  dropped_taken_ = std::max(dropped_taken_, dropped_ - static_cast<std::int64_t>(kDroppedKept));
  if (dropped_taken_ == dropped_) return false;
  *record = dropped_loops_[static_cast<std::size_t>(dropped_taken_++) % kDroppedKept];
  return true;
}

void LoopList::rank(std::size_t record) {
  const auto better = [this](std::size_t a, std::size_t b) {
    const SiftedLoop &x = records_[a], &y = records_[b];
    return x.improvement != y.improvement ? x.improvement > y.improvement : x.loop.id < y.loop.id;
  };
  const auto place = std::upper_bound(ranking_.begin(), ranking_.end(), record, better);
  const auto from = static_cast<std::size_t>(place - ranking_.begin());
  ranking_.insert(place, record);
  renumber(from);
}

void LoopList::start_again() {
  ranking_.clear();
  for (std::size_t k = 0; k < size_; ++k) {
    records_[k].scored = false;
    records_[k].rank = -1;
    records_[k].tested_on = 0;
  }
}

void LoopList::restore(const std::vector<SiftedLoop>& snapshot) {
  ranking_.clear();
  for (std::size_t k = 0; k < snapshot.size(); ++k) {
    records_[k] = snapshot[k];
    if (snapshot[k].rank >= 0) rank(k);
  }
}

void LoopList::renumber(std::size_t from) {
  for (std::size_t k = from; k < ranking_.size(); ++k) records_[ranking_[k]].rank = static_cast<int>(k);
}

}  // namespace loopsift
