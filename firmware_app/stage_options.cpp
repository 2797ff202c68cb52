// SPDX-License-Identifier: MIT
#include "firmware_app/stage_options.hpp"

namespace loopsift {
namespace {

// Bounds that many keys share. Where zero makes no sense, kTiny stands for "more than 0".
constexpr double kTiny = 1e-6;
constexpr double kManySurfels = 1 << 28;

OptionSection frame_section(FrameOptions& o) {
  return {"frame",
          "What tracking and fusion make of a depth image.",
          {
              {"reduction", &o.reduction, "image pixels per working pixel, each way: 1, 2 or 4", {1, 4}},
              {"levels", &o.levels, "of the pyramid", {1, kMaxFrameLevels}},
              {"edge_fraction",
               &o.edge_fraction,
               "neighbours whose depths differ by more than this part of "
               "the depth lie on two surfaces",
               {kTiny, 0.99}},
              {"smoothing_radius",
               &o.smoothing_radius,
               "working pixels of the edge-aware mean below the "
               "normals; 0: none",
               {0, 4}},
          }};
}

OptionSection odometry_section(OdometryOptions& o, int* lost_patience_frames) {
  return {"odometry",
          "Tracking of each frame against the map of the last fragments.",
          {
              {"finest_level", &o.finest_level, "pyramid level of the last iterations", {0, kMaxFrameLevels}},
              {"iterations_coarse", &o.iterations_coarse, "at most, on each coarser level", {1, 100}},
              {"iterations_fine", &o.iterations_fine, "at most, on the finest level", {1, 100}},
              {"gate_coarse_m",
               &o.gate_coarse_m,
               "points farther from the map are not matched, on the "
               "coarsest level",
               {kTiny, 10}},
              {"gate_fine_m", &o.gate_fine_m, "the same on the finest level", {kTiny, 10}},
              {"min_normal_cosine", &o.min_normal_cosine, "of the angle between matched normals", {0, 0.99}},
              {"prior_sigma_m",
               &o.prior_sigma_m,
               "how far a frame may be from the constant-velocity "
               "prediction, one σ",
               {kTiny, 10}},
              {"prior_sigma_rad", &o.prior_sigma_rad, "the same for rotation", {kTiny, 10}},
              {"correlated_pixels",
               &o.correlated_pixels,
               "pixels that err together; divides the "
               "information of a motion",
               {1, 1e6}},
              {"photometric", &o.photometric, "track intensities, too, where there is colour"},
              {"photometric_floor_m",
               &o.photometric_floor_m,
               "what they say about the motion is never more certain than this",
               {kTiny, 10}},
              {"photometric_floor_rad", &o.photometric_floor_rad, "the same for rotation", {kTiny, 10}},
              {"min_inlier_fraction",
               &o.min_inlier_fraction,
               "of the pixels with depth; below it tracking "
               "is lost",
               {0.01, 0.99}},
              {"max_step_m", &o.max_step_m, "from the prediction; farther is lost", {kTiny, 100}},
              {"max_step_rad", &o.max_step_rad, "the same for rotation", {kTiny, 4}},
              {"lost_patience_frames",
               lost_patience_frames,
               "lost frames in a row before the trajectory "
               "starts anew",
               {0, 1e6}},
          }};
}

OptionSection depth_calibration_section(DepthCalibrationOptions& o) {
  return {"depth_calibration",
          "The camera's smooth depth error, found while it moves: what two frames see in different places of "
          "the image must agree.",
          {
              {"enabled", &o.enabled, "find and remove it"},
              {"sigma_per_m",
               &o.sigma_per_m,
               "of each coefficient of the inverse depth's error before anything was seen, 1/m",
               {kTiny, 1}},
              {"caution",
               &o.caution,
               "how much less, as a variance, pairs of frames are trusted than their scatter allows",
               {1, 1e6}},
              {"memory", &o.memory, "weight of all that was seen before, with each pair", {0.5, 1}},
          }};
}

OptionSection file_odometry_section(TrajectoryOdometryOptions& o) {
  return {"odometry.file",
          "Odometry from a file (and over LCM), which does not say how sure it is.",
          {
              {"max_gap_s", &o.max_gap_s, "poses farther apart are not interpolated", {0, 1e6}},
              {"sigma_m_per_m", &o.sigma_m_per_m, "assumed drift per metre of path", {0, 10}},
              {"sigma_rad_per_rad", &o.sigma_rad_per_rad, "assumed drift per radian turned", {0, 10}},
              {"sigma_floor_m", &o.sigma_floor_m, "assumed error of a frame that stands still", {kTiny, 10}},
              {"sigma_floor_rad", &o.sigma_floor_rad, "the same for rotation", {kTiny, 10}},
          }};
}

OptionSection fragment_section(FragmentOptions& o) {
  return {"fragment",
          "Fusion of consecutive frames into rigid pieces of the map.",
          {
              {"frames_per_fragment",
               &o.frames_per_fragment,
               "consecutive frames in one piece, at most",
               {2, 10000}},
              {"max_travel_m",
               &o.max_travel_m,
               "a piece ends earlier after this way of the camera; 0: no limit",
               {0, 1000}},
              {"max_turn_rad", &o.max_turn_rad, "… after turns of this sum; 0: no limit", {0, 1000}},
              {"max_drift_m",
               &o.max_drift_m,
               "… when the odometry may have drifted by this since its first frame; 0: no limit",
               {0, 1000}},
              {"views_per_fragment", &o.views_per_fragment, "frames kept to score the map with", {1, 100}},
              {"view_step",
               &o.view_step,
               "image pixels per view pixel, each way; a view must fit "
               "posterior.max_view_width, max_view_height",
               {1, 128}},
              {"active_capacity",
               &o.active_capacity,
               "surfels of the piece that is being built",
               {1000, kManySurfels}},
              {"max_surfels",
               &o.max_surfels,
               "of a finished piece; a larger one is thinned more coarsely",
               {100, kManySurfels}},
              {"thin_cell_m",
               &o.thin_cell_m,
               "finished pieces keep one surfel per cube of this edge and "
               "side",
               {0.001, 1}},
              {"merge_distance_sigmas",
               &o.merge_distance_sigmas,
               "a measurement within this many σ of a "
               "surfel is of that surfel",
               {0.1, 100}},
              {"min_normal_cosine",
               &o.min_normal_cosine,
               "of the angle between normals that may merge",
               {-0.99, 0.99}},
              {"min_view_cosine",
               &o.min_view_cosine,
               "measurements at more grazing angles are not fused",
               {0, 0.99}},
              {"min_frames_seen",
               &o.min_frames_seen,
               "surfels seen in fewer frames are dropped in the end",
               {1, 10000}},
              {"max_unconfirmed_frames",
               &o.max_unconfirmed_frames,
               "within which a new surfel must have "
               "been seen that often",
               {1, 10000}},
          }};
}

OptionSection model_section(ModelOptions& o) {
  return {"model",
          "The part of the map that frames are tracked against.",
          {
              {"fragments", &o.fragments, "how many finished pieces it reaches back", {0, 1000}},
              {"step", &o.step, "working pixels per model pixel, each way", {1, 8}},
              {"same_surface_m",
               &o.same_surface_m,
               "a newer surfel within this of an older one is the same "
               "surface: the older stands",
               {kTiny, 10}},
              {"max_splat_radius", &o.max_splat_radius, "of a surfel, model pixels", {0, 16}},
          }};
}

OptionSection proposal_section(BackEndOptions& back, ProposalOptions& o) {
  return {
      "proposal",
      "Loop proposals: registrations between pieces. Liberal on purpose, the sifter decides.",
      {
          {"enabled", &back.propose, "false: loops come from elsewhere only"},
          {"voxel_m", &o.cloud.voxel_m, "edge of the cubes to which pieces are thinned", {0.005, 1}},
          {"max_points", &o.cloud.max_points, "of a thinned piece", {1, 65534}},
          {"feature_radius_m", &o.features.radius_m, "neighbourhood that a feature describes", {0.01, 10}},
          {"min_neighbours", &o.features.min_neighbours, "points with fewer get no feature", {1, 1000}},
          {"max_keypoints", &o.features.max_keypoints, "features kept of a piece", {1, 65534}},
          {"max_matches", &o.max_matches, "feature matches of a pair", {3, 65534}},
          {"distance_tolerance_m",
           &o.global.distance_tolerance_m,
           "of lengths that agree in both pieces",
           {kTiny, 10}},
          {"normal_tolerance_rad",
           &o.global.normal_tolerance_rad,
           "of angles that agree in both pieces",
           {kTiny, 4}},
          {"min_length_m", &o.global.min_length_m, "matches nearer to each other say nothing", {0, 100}},
          {"max_seeds", &o.global.max_seeds, "matches from which a motion is tried", {1, 65534}},
          {"companions", &o.global.companions, "matches that a motion is fitted to", {2, 1000}},
          {"min_agreeing", &o.global.min_agreeing, "matches that must agree with a motion", {3, 65534}},
          {"max_hypotheses", &o.global.max_hypotheses, "motions of a pair that are refined", {1, 100}},
          {"distinct_translation_m",
           &o.global.distinct_translation_m,
           "motions nearer than this and …",
           {0, 100}},
          {"distinct_rotation_rad", &o.global.distinct_rotation_rad, "… than this are refined once", {0, 4}},
          {"max_registrations_per_fragment",
           &o.max_registrations_per_fragment,
           "pairs tried for a new "
           "piece; bounds the time",
           {1, 1e6}},
          {"max_repeats_per_fragment",
           &o.max_repeats_per_fragment,
           "earlier pairs tried again then, because a correction has moved them",
           {0, 1e6}},
          {"min_overlap", &o.min_overlap, "of the smaller piece, to be a proposal at all", {0.01, 0.99}},
          {"min_expected_overlap",
           &o.min_expected_overlap,
           "below it the present poses are no start",
           {0, 1}},
          {"same_translation_m", &o.same_translation_m, "two results nearer than this and …", {kTiny, 10}},
          {"same_rotation_rad", &o.same_rotation_rad, "… than this are one proposal", {kTiny, 4}},
      }};
}

OptionSection proposal_icp_section(IcpOptions& o) {
  constexpr double kReach_m = 0.2;  // NearestField looks no farther
  return {
      "proposal.icp",
      "Refinement of a proposal, coarse to fine, and the information that it claims.",
      {
          {"coarse_distance_m",
           &o.stages[0].max_distance_m,
           "farther points are no pair, first stage",
           {0.001, kReach_m}},
          {"middle_distance_m", &o.stages[1].max_distance_m, "second stage", {0.001, kReach_m}},
          {"fine_distance_m",
           &o.stages[2].max_distance_m,
           "last stage; also what overlap means",
           {0.001, kReach_m}},
          {"coarse_iterations", &o.stages[0].max_iterations, "at most, first stage", {1, 1000}},
          {"middle_iterations", &o.stages[1].max_iterations, "second stage", {1, 1000}},
          {"fine_iterations", &o.stages[2].max_iterations, "last stage", {1, 1000}},
          {"min_normal_cosine", &o.min_normal_cosine, "of the angle between paired normals", {-0.99, 0.99}},
          {"sigma_floor_m", &o.sigma_floor_m, "a surfel's error: floor + slope · range²", {kTiny, 1}},
          {"sigma_slope_per_m", &o.sigma_slope_per_m, "range from the piece's first camera", {0, 1}},
          {"min_partners", &o.min_partners, "fewer pairs are a failure", {6, 65534}},
          {"correlated_pairs",
           &o.correlated_pairs,
           "pairs that err together; divides the information",
           {1, 1e6}},
          {"max_sigma_m", &o.max_sigma_m, "a motion known worse along any axis is a failure", {kTiny, 100}},
          {"max_sigma_rad", &o.max_sigma_rad, "or about any axis", {kTiny, 100}},
      }};
}

OptionSection posegraph_section(BackEndOptions& back, SolveOptions& o) {
  return {"posegraph",
          "Optimisation of the pieces' poses under odometry and accepted loops.",
          {
              {"calibrate_odometry", &back.calibrate_odometry,
               "scale the odometry's uncertainty by what neighbouring pieces show"},
              {"keyframes_per_fragment", &back.keyframes_per_fragment, "nodes of a piece", {1, 10000}},
              {"max_iterations", &o.max_iterations, "a solve that needs more has failed", {1, 10000}},
              {"relative_cost_tolerance",
               &o.relative_cost_tolerance,
               "a smaller step of the cost ends a "
               "solve",
               {1e-15, 0.1}},
              {"time_limit_s", &o.time_limit_s, "a solve that takes longer has failed", {0.001, 3600}},
          }};
}

OptionSection posterior_section(PosteriorOptions& o) {
  return {"posterior",
          "The dense map posterior: how well the map predicts the depth that was measured.",
          {
              {"disc_spacing_m",
               &o.disc_spacing_m,
               "edge of the cubes to which pieces are thinned for "
               "scoring",
               {0.005, 1}},
              {"disc_radius_m", &o.disc_radius_m, "of what is drawn for a cube", {0.005, 1}},
              {"max_discs_per_fragment",
               &o.max_discs_per_fragment,
               "what is more is left out and counted",
               {64, 1e6}},
              {"max_view_width", &o.max_view_width, "pixels", {8, 1024}},
              {"max_view_height", &o.max_view_height, "pixels", {8, 1024}},
          }};
}

OptionSection sifter_section(BackEndOptions& back_end, SifterOptions& o) {
  const auto score = by_name(&o.score, {{"posterior", ScoreKind::kPosterior}, {"plain", ScoreKind::kPlain}});
  return {
      "sifter",
      "Which loops are accepted. There is no threshold to set.",
      {
          {"score", score, "posterior: a torn map gains nothing; plain: the published metric alone"},
          {"hindsight", &o.hindsight, "test accepted loops again once others are in"},
          {"challenge", &o.challenge, "a loop must explain its two pieces better than motions next to it"},
          {"max_loops",
           &o.max_loops,
           "known at a time; past it the lowest ranked are dropped and counted",
           {1, 1e6}},
          {"max_views_per_test",
           &o.max_views_per_test,
           "views that one test looks at, at most; half as many for a loop alone; 0: all, and no test ends "
           "early",
           {0, 65535}},
          {"steps_per_fragment",
           &back_end.steps_per_fragment,
           "loops scored or tested, at most, before the next piece is taken",
           {1, 1e9}},
          {"slice_s",
           &back_end.slice_s,
           "and how long after the piece closed, in real time; no correction is later by much more",
           {0, 1e6}},
          {"finish_limit_s",
           &back_end.finish_limit_s,
           "at the end of a run all loops are sifted once more; past this the map stays as it was",
           {0, 1e6}},
      }};
}

}  // namespace

OptionTable front_end_sections(FrontEndOptions& o, TrajectoryOdometryOptions& file) {
  return {frame_section(o.frame),       odometry_section(o.odometry, &o.lost_patience_frames),
          file_odometry_section(file),  depth_calibration_section(o.depth_calibration),
          fragment_section(o.fragment), model_section(o.model)};
}

OptionSection store_section(StoreOptions& o) {
  return {"store",
          "Capacity of the map. When any of these is used up no further piece is added; tracking goes on.",
          {
              {"max_fragments", &o.max_fragments, "pieces", {1, 65535}},
              {"max_surfels", &o.max_surfels, "of all pieces", {100, kManySurfels}},
              {"max_frames",
               &o.max_frames,
               "of all pieces; also the poses of the written trajectory",
               {2, kManySurfels}},
          }};
}

OptionTable back_end_sections(BackEndOptions& o) {
  return {proposal_section(o, o.proposal), proposal_icp_section(o.proposal.icp),
          posegraph_section(o, o.sifter.solve), posterior_section(o.posterior), sifter_section(o, o.sifter)};
}

}  // namespace loopsift
