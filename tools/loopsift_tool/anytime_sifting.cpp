// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/anytime_sifting.hpp"

#include <algorithm>

namespace loopsift::tool {
namespace {

constexpr std::size_t kPortion = 8;  // loops: few enough that the first map comes soon

// Whether the published map is that of the accepted loops.
bool is_settled(const Sifter& sifter) {
  return std::all_of(sifter.records().begin(), sifter.records().end(),
                     [](const SiftedLoop& r) { return (r.decision == Decision::kAccepted) == r.published; });
}

}  // namespace

bool sift_within(const std::function<double()>& seconds_left, Span<const Loop> loops, BackEnd* back_end,
                 const std::function<void(std::size_t, std::size_t)>& show) {
  Sifter& sifter = back_end->sifter();
  std::size_t added = 0;
  while (added < loops.size() && seconds_left() > 0) {
    const std::size_t portion = std::min(kPortion, loops.size() - added);
    back_end->add_loops({loops.data() + added, portion});
    added += portion;
    while (back_end->work(1) && !(seconds_left() <= 0 && is_settled(sifter)))
      show(added - static_cast<std::size_t>(sifter.pending()), loops.size());
  }
  back_end->add_loops({loops.data() + added, loops.size() - added});
  const double left_s = seconds_left();
  return sifter.pending() == 0 && left_s > 0 && sifter.finish(left_s);
}

}  // namespace loopsift::tool
