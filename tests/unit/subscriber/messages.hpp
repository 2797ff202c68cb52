// SPDX-License-Identifier: MIT
// Messages as the program sends them, made by hand.
#pragma once
#include <cstdint>
#include <loopsift/correction_t.hpp>
#include <loopsift/fragment_t.hpp>
#include <loopsift/graph_t.hpp>
#include <loopsift/health_t.hpp>
#include <loopsift/loop_t.hpp>
#include <loopsift/pose_t.hpp>

namespace loopsift::test {

inline constexpr std::int64_t kRun = 1'700'000'000'000'000;

inline transform_t at(double x, double y = 0, double z = 0) { return {{x, y, z}, {1, 0, 0, 0}}; }

/// The body is at x in odom; odom is at y = epoch in map.
inline pose_t pose_message(std::int64_t utime, double x, std::int32_t epoch = 0) {
  pose_t m{};
  m.utime = utime;
  m.run = kRun;
  m.epoch = epoch;
  m.anchored = 1;
  m.T_odom_body = at(x);
  m.T_map_body = at(x, epoch);
  m.covariance[0] = 1e-4;
  return m;
}

inline correction_t correction_message(std::int32_t epoch) {
  correction_t m{};
  m.run = kRun;
  m.epoch = epoch;
  m.T_map_odom = {0, {0, static_cast<double>(epoch), 0}, {1, 0, 0, 0}};
  return m;
}

inline loop_t loop_message(std::int32_t id) {
  loop_t m{};
  m.run = kRun;
  m.id = id;
  m.fragment_j = 2;
  m.T_i_j = at(1);
  m.reason = "because";
  return m;
}

inline health_t health_message(double uptime_s, std::int32_t graph_version = 0) {
  health_t m{};
  m.run = kRun;
  m.uptime_s = uptime_s;
  m.state = health_t::TRACKING;
  m.graph_version = graph_version;
  return m;
}

/// A chunk of a fragment; the x of surfel i is i.
inline fragment_t fragment_message(std::int32_t fragment, std::int32_t surfel_count, std::int32_t chunk) {
  constexpr std::int32_t kPerChunk = fragment_t::SURFELS_PER_CHUNK;
  fragment_t m{};
  m.run = kRun;
  m.fragment = fragment;
  m.surfel_count = surfel_count;
  m.chunk_count = surfel_count <= kPerChunk ? 1 : (surfel_count + kPerChunk - 1) / kPerChunk;
  m.chunk = chunk;
  m.n = surfel_count - chunk * kPerChunk < kPerChunk ? surfel_count - chunk * kPerChunk : kPerChunk;
  for (int i = 0; i < m.n; ++i) {
    m.x[i] = static_cast<float>(chunk * kPerChunk + i);
    m.nx[i] = 1;
    m.radius[i] = 0.01F;
  }
  return m;
}

/// Fragment f is turned by 90° about Z and lies at x = f; no nodes or edges.
inline graph_t graph_message(std::int32_t version, std::int32_t fragments, std::int32_t surfel_count,
                             std::int32_t chunk) {
  constexpr std::int32_t kPerChunk = graph_t::ELEMENTS_PER_CHUNK;
  graph_t m{};
  m.run = kRun;
  m.version = version;
  m.epoch = 1;
  m.fragment_count = fragments;
  m.chunk_count = fragments <= kPerChunk ? 1 : (fragments + kPerChunk - 1) / kPerChunk;
  m.chunk = chunk;
  m.n_fragments = fragments - chunk * kPerChunk < kPerChunk ? fragments - chunk * kPerChunk : kPerChunk;
  for (int k = 0; k < m.n_fragments; ++k) {
    graph_fragment_t& place = m.fragments[k];
    place.surfel_count = surfel_count;
    place.R[1] = -1;
    place.R[3] = 1;
    place.R[8] = 1;
    place.t[0] = chunk * kPerChunk + k;
    place.anchored = true;
  }
  return m;
}

}  // namespace loopsift::test
