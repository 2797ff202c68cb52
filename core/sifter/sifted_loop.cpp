// SPDX-License-Identifier: MIT
#include "core/sifter/sifted_loop.hpp"

namespace loopsift {

const char* to_string(Decision decision) {
  switch (decision) {
    case Decision::kPending:
      return "pending";
    case Decision::kAccepted:
      return "accepted";
    case Decision::kRejected:
      return "rejected";
    case Decision::kRevoked:
      return "revoked";
  }
  return "";
}

const char* to_string(Reason reason) {
  switch (reason) {
    case Reason::kNotTested:
      return "not tested";
    case Reason::kWaits:
      return "names a fragment that is not closed yet";
    case Reason::kImproves:
      return "improves the map";
    case Reason::kNoChange:
      return "changes nothing that a view sees";
    case Reason::kNoImprovement:
      return "does not improve the map";
    case Reason::kInsignificant:
      return "improves the map by less than the standard error";
    case Reason::kChallenged:
      return "a motion next to it explains the two fragments better";
    case Reason::kSolveFailed:
      return "the pose graph could not be optimised with it";
    case Reason::kSame:
      return "says the same as another loop";
    case Reason::kNoFragment:
      return "names a fragment that is not in the map";
    case Reason::kBetterWithout:
      return "the map is better without it";
  }
  return "";
}

}  // namespace loopsift
