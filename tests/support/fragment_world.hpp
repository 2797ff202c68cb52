// SPDX-License-Identifier: MIT
// A walk through an analytic scene as closed fragments: surfels and views are cast exactly (the views with
// white noise on top), the odometry drifts from fragment to fragment, and true and wrong loops are at hand.
#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "core/fragment/fragment.hpp"
#include "core/posegraph/pose_graph.hpp"
#include "core/proposal/loop.hpp"
#include "tests/support/analytic_scene.hpp"

namespace loopsift::test {

/// The camera that surfels are cast with, and score views unless they are said to be smaller.
inline PinholeCamera view_camera() { return {80, 60, 72.5F, 72.5F, 39.5F, 29.5F}; }
/// Half as large, as a run keeps its views.
inline PinholeCamera small_view_camera() { return {40, 30, 36.25F, 36.25F, 19.5F, 14.5F}; }

struct FragmentWorldOptions {
  int fragments = 7;
  int frames_per_fragment = 4;
  int views_per_fragment = 2;          ///< evenly spread over its frames
  PinholeCamera view = view_camera();  ///< of the score views
  std::function<Se3(double)> path;     ///< T_world_camera at so many fragments; empty: a walk in a room
  Vector6d drift = (Vector6d() << 0.015, 0, 0.01, 0, 0.012, 0).finished();  ///< per fragment, (t, ω)
  double sigma_m = 0.01, sigma_rad = 0.005;  ///< claimed by the odometry, per frame
  double depth_noise_m = 0.004;              ///< of the views
};

inline Matrix6d information_of(double sigma_m, double sigma_rad) {
  const double t = 1.0 / (sigma_m * sigma_m), w = 1.0 / (sigma_rad * sigma_rad);
  return (Vector6d() << t, t, t, w, w, w).finished().asDiagonal();
}

/// A room with something to tell every side of it from the others.
inline AnalyticScene furnished_room() {
  using V = Eigen::Vector3d;
  AnalyticScene scene = AnalyticScene::room();
  for (const Sphere& sphere :
       {Sphere{V(2.6, 0.2, 1.5), 0.5}, Sphere{V(2.2, -0.6, 0.2), 0.3}, Sphere{V(2.7, 0.5, -0.8), 0.6},
        Sphere{V(1.6, 0.5, 2.3), 0.35}, Sphere{V(1.4, 0.3, -1.9), 0.4}})
    scene.spheres.push_back(sphere);
  return scene;
}

/// Owns all that its fragments point to.
class FragmentWorld {
 public:
  explicit FragmentWorld(const FragmentWorldOptions& options = {},
                         const AnalyticScene& scene = furnished_room())
      : options_(options), scene_(scene) {
    fragments_.reserve(static_cast<std::size_t>(options.fragments));
    for (int f = 0; f < options.fragments; ++f) add_fragment(f);
  }

  [[nodiscard]] const std::vector<Fragment>& fragments() const { return fragments_; }
  /// By fragment: the truth, and the odometry's belief.
  [[nodiscard]] const std::vector<Se3>& truth() const { return truth_; }
  [[nodiscard]] const std::vector<Se3>& odometry() const { return odometry_; }
  /// The true motion between two fragments times exp(error), as stiff as a good registration.
  [[nodiscard]] Loop loop(int id, int i, int j, const Vector6d& error = Vector6d::Zero()) const {
    Loop made;
    made.id = LoopId{id}, made.i = FragmentId{i}, made.j = FragmentId{j};
    made.T_i_j = truth_[made.i.index()].inverse() * truth_[made.j.index()] * Se3::exp(error);
    made.information = information_of(0.01, 0.009);
    return made;
  }
  /// Root mean square distance of these first fragments from where they truly are; the first one is where it
  /// is.
  [[nodiscard]] double rmse_m(const std::vector<Se3>& T_map_fragment) const {
    double sum = 0;
    for (std::size_t f = 0; f < T_map_fragment.size(); ++f)
      sum += (T_map_fragment[f].translation() - truth_[f].translation()).squaredNorm();
    return std::sqrt(sum / static_cast<double>(T_map_fragment.size()));
  }
  [[nodiscard]] PoseGraph graph(int keyframes = 2) const {
    PoseGraph made;
    for (std::size_t f = 0; f < fragments_.size(); ++f)
      append_fragment(f == 0 ? nullptr : &fragments_[f - 1], fragments_[f], keyframes, &made);
    return made;
  }

 private:
  struct Stores {
    std::vector<float> x, y, z, nx, ny, nz, radius, weight;
    std::vector<std::uint32_t> rgb;
    std::vector<std::uint16_t> first_frame, last_frame;
    std::vector<FragmentFrame> frames;
    std::vector<std::vector<float>> depths;
    std::vector<ScoreView> views;
  };

  // Turns to the side and back within the walk, on a small round.
  [[nodiscard]] Se3 pose_at(double fragment) const {
    if (options_.path) return options_.path(fragment);
    const double phase = 2.0 * 3.14159265358979 * fragment / options_.fragments;
    const double there_and_back = 0.5 * (1.0 - std::cos(phase));
    return shifted(0.4 * std::sin(phase), 0.1 * std::sin(phase), -0.4 * there_and_back, 1.9 * there_and_back);
  }
  void add_fragment(int f) {
    stores_.push_back(std::make_unique<Stores>());
    Stores& s = *stores_.back();
    truth_.push_back(pose_at(f));
    Fragment fragment;
    fragment.id = FragmentId{f};
    fragment.T_odom_fragment = f == 0
                                   ? truth_[0]
                                   : fragments_.back().T_odom_fragment * truth_[truth_.size() - 2].inverse() *
                                         truth_.back() * Se3::exp(options_.drift);
    for (int k = 0; k < options_.frames_per_fragment; ++k) add_frame(f, k, &s);
    fragment.frames = Span<const FragmentFrame>(s.frames.data(), s.frames.size());
    fragment.surfels = {s.x,      s.y,      s.z,   s.nx,          s.ny,        s.nz,
                        s.radius, s.weight, s.rgb, s.first_frame, s.last_frame};
    for (int v = 0; v < options_.views_per_fragment; ++v)
      add_view(v * options_.frames_per_fragment / options_.views_per_fragment, &s);
    fragment.views = Span<const ScoreView>(s.views.data(), s.views.size());
    fragments_.push_back(fragment);
    odometry_.push_back(fragment.T_odom_fragment);
  }
  void add_frame(int f, int k, Stores* s) {
    const int number = f * options_.frames_per_fragment + k;
    const Se3 T_world_camera = pose_at(f + static_cast<double>(k) / options_.frames_per_fragment);
    const Se3 T_fragment_camera = truth_.back().inverse() * T_world_camera;
    s->frames.push_back({FrameId{number}, number * 100'000'000LL, T_fragment_camera,
                         information_of(options_.sigma_m, options_.sigma_rad)});
    const PinholeCamera camera = view_camera();
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) add_surfel(T_world_camera, camera, u, v, k, s);
  }
  void add_surfel(const Se3& T_world_camera, const PinholeCamera& camera, int u, int v, int frame,
                  Stores* s) {
    const Eigen::Vector3d p = cast(T_world_camera, camera, u, v, nullptr);
    const Se3 T_fragment_world = truth_.back().inverse();
    const Eigen::Vector3f q = (T_fragment_world * p).cast<float>();
    const Eigen::Vector3f n = (T_fragment_world.rotation() * normal_at(p)).cast<float>();
    s->x.push_back(q.x()), s->y.push_back(q.y()), s->z.push_back(q.z());
    s->nx.push_back(n.x()), s->ny.push_back(n.y()), s->nz.push_back(n.z());
    s->radius.push_back(0.02F), s->weight.push_back(10.0F), s->rgb.push_back(0x808080U);
    s->first_frame.push_back(static_cast<std::uint16_t>(frame));
    s->last_frame.push_back(s->first_frame.back());
  }
  void add_view(int k, Stores* s) {
    const PinholeCamera& camera = options_.view;
    const Se3& T_fragment_camera = s->frames[static_cast<std::size_t>(k)].T_fragment_camera;
    std::normal_distribution<double> noise(0.0, options_.depth_noise_m);
    std::vector<float> depth;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        double z = 0;
        (void)cast(truth_.back() * T_fragment_camera, camera, u, v, &z);
        depth.push_back(static_cast<float>(z + (options_.depth_noise_m > 0 ? noise(random_) : 0.0)));
      }
    }
    s->depths.push_back(std::move(depth));  // moving a vector keeps its elements in place
    s->views.push_back(
        {k, camera, {s->depths.back().data(), camera.width, camera.height}, T_fragment_camera});
  }
  [[nodiscard]] Eigen::Vector3d cast(const Se3& T_world_camera, const PinholeCamera& camera, int u, int v,
                                     double* depth) const {
    const Eigen::Vector3d ray =
        T_world_camera.rotation() *
        camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0F).cast<double>();
    const double z = scene_.cast(T_world_camera.translation(), ray);
    if (depth != nullptr) *depth = z;
    return T_world_camera.translation() + z * ray;
  }
  [[nodiscard]] Eigen::Vector3d normal_at(const Eigen::Vector3d& p) const {
    for (const Sphere& sphere : scene_.spheres)
      if (std::fabs((p - sphere.center).norm() - sphere.radius) < 1e-6)
        return (p - sphere.center).normalized();
    for (const Plane& plane : scene_.planes)
      if (std::fabs(plane.normal.dot(p) - plane.offset) < 1e-6) return plane.normal;
    return Eigen::Vector3d::Zero();
  }

  FragmentWorldOptions options_;
  AnalyticScene scene_;
  std::vector<std::unique_ptr<Stores>> stores_;
  std::vector<Fragment> fragments_;
  std::vector<Se3> truth_, odometry_;
  std::mt19937 random_{7};
};

}  // namespace loopsift::test
