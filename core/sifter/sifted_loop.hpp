// SPDX-License-Identifier: MIT
// A loop with all that the sifter found out about it.
#pragma once
#include <cstdint>
#include <vector>

#include "core/proposal/loop.hpp"

namespace loopsift {

enum class Decision {
  kPending,
  kAccepted,
  kRejected,
  kRevoked,  ///< was part of a published map, and is no longer
};

/// Why a loop was decided as it was; the text of `reason` in loops.csv.
enum class Reason {
  kNotTested,
  kWaits,          ///< names a fragment that is not closed yet
  kImproves,       ///< the map is better with it
  kNoChange,       ///< the map is the same with it, as far as any view can tell
  kNoImprovement,  ///< the map is not better with it
  kInsignificant,  ///< it is, but by no more than its standard error over the views
  kChallenged,     ///< a motion next to it explains the two fragments better
  kSolveFailed,    ///< the pose graph could not be optimised with it
  kSame,           ///< another loop says the very same
  kNoFragment,     ///< names a fragment that is not in the map
  kBetterWithout,  ///< accepted once; the map is better without it since others came in
};
[[nodiscard]] const char* to_string(Decision decision);
[[nodiscard]] const char* to_string(Reason reason);

/// Scores in m², lower is better, of the chosen ScoreKind; those of the posterior are estimates from the
/// views looked at.
struct SiftedLoop {
  Loop loop;
  bool scored = false;
  double single_score = 0;  ///< of the odometry's map with this loop alone
  double improvement =
      0;          ///< score of the odometry's map − single_score, when it was measured; the rank's key
  int rank = -1;  ///< place among the scored loops, 0 is best
  double tested_score =
      0;  ///< with the accepted loops of better rank; where the test gave up early as it looked then
  double best_score_before = 0;
  Decision decision = Decision::kPending;
  Reason reason = Reason::kNotTested;
  int frame_decided = -1;       ///< newest frame in the map when it was decided
  int views = 0;                ///< looked at by the last test
  int revisions = 0;            ///< how often the decision changed after the first
  std::uint64_t tested_on = 0;  ///< names the accepted loops of better rank when it was tested; 0: not tested
  bool published = false;       ///< is part of the published map
};

}  // namespace loopsift
