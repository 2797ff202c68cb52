// SPDX-License-Identifier: MIT
#include "core/proposal/proposer.hpp"

namespace loopsift {
namespace {

Status out_of_range(const char* key, const char* range) {
  return Error{ErrorCode::kUsage, std::string("proposal.") + key + " must be " + range};
}

Status validate_features(const RegistrationCloudOptions& cloud, const FpfhOptions& features) {
  if (!(cloud.voxel_m > 0)) return out_of_range("voxel_m", "more than 0");
  if (cloud.max_points < 1 || cloud.max_points > 65534) return out_of_range("max_points", "from 1 to 65534");
  if (!(features.radius_m > cloud.voxel_m)) return out_of_range("feature_radius_m", "more than voxel_m");
  if (features.min_neighbours < 1) return out_of_range("min_neighbours", "1 or more");
  if (features.max_keypoints < 1 || features.max_keypoints > 65534)
    return out_of_range("max_keypoints", "from 1 to 65534");
  return {};
}

Status validate_global(const GlobalRegistrationOptions& o) {
  if (!(o.distance_tolerance_m > 0)) return out_of_range("distance_tolerance_m", "more than 0");
  if (!(o.normal_tolerance_rad > 0)) return out_of_range("normal_tolerance_rad", "more than 0");
  if (!(o.min_length_m >= 0)) return out_of_range("min_length_m", "0 or more");
  if (o.max_seeds < 1) return out_of_range("max_seeds", "1 or more");
  if (o.companions < 2) return out_of_range("companions", "2 or more");
  if (o.min_agreeing < 3) return out_of_range("min_agreeing", "3 or more");
  if (o.max_hypotheses < 1) return out_of_range("max_hypotheses", "1 or more");
  return {};
}

Status validate_icp(const IcpOptions& o) {
  for (const IcpStage& stage : o.stages)
    if (!(stage.max_distance_m > 0) || stage.max_iterations < 1 || stage.stride < 1)
      return out_of_range("icp.stages", "of distance more than 0, with iterations and stride 1 or more");
  if (!(o.min_normal_cosine > -1 && o.min_normal_cosine < 1))
    return out_of_range("icp.min_normal_cosine", "between -1 and 1");
  if (!(o.sigma_floor_m > 0)) return out_of_range("icp.sigma_floor_m", "more than 0");
  if (!(o.sigma_slope_per_m >= 0)) return out_of_range("icp.sigma_slope_per_m", "0 or more");
  if (o.min_partners < 6) return out_of_range("icp.min_partners", "6 or more");
  if (!(o.correlated_pairs >= 1)) return out_of_range("icp.correlated_pairs", "1 or more");
  if (!(o.max_sigma_m > 0)) return out_of_range("icp.max_sigma_m", "more than 0");
  if (!(o.max_sigma_rad > 0)) return out_of_range("icp.max_sigma_rad", "more than 0");
  return {};
}

}  // namespace

Status validate(const ProposalOptions& o) {
  for (Status status :
       {validate_features(o.cloud, o.features), validate_global(o.global), validate_icp(o.icp)})
    if (!status) return status;
  if (o.max_fragments < 1) return out_of_range("max_fragments", "1 or more");
  if (o.max_registrations_per_fragment < 1)
    return out_of_range("max_registrations_per_fragment", "1 or more");
  if (o.max_repeats_per_fragment < 0) return out_of_range("max_repeats_per_fragment", "0 or more");
  if (o.max_matches < 3 || o.max_matches > 65534) return out_of_range("max_matches", "from 3 to 65534");
  if (!(o.min_overlap > 0 && o.min_overlap < 1)) return out_of_range("min_overlap", "between 0 and 1");
  if (!(o.min_expected_overlap >= 0)) return out_of_range("min_expected_overlap", "0 or more");
  if (!(o.same_translation_m > 0)) return out_of_range("same_translation_m", "more than 0");
  if (!(o.same_rotation_rad > 0)) return out_of_range("same_rotation_rad", "more than 0");
  return {};
}

}  // namespace loopsift
