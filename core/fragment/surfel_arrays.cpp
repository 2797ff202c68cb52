// SPDX-License-Identifier: MIT
#include "core/fragment/surfel_arrays.hpp"

#include <algorithm>

namespace loopsift {
namespace {

// Calls f with the pointer to each array member.
template <class F>
void for_each_array(F f) {
  f(&SurfelSpan::x);
  f(&SurfelSpan::y);
  f(&SurfelSpan::z);
  f(&SurfelSpan::nx);
  f(&SurfelSpan::ny);
  f(&SurfelSpan::nz);
  f(&SurfelSpan::radius);
  f(&SurfelSpan::weight);
  f(&SurfelSpan::rgb);
  f(&SurfelSpan::first_frame);
  f(&SurfelSpan::last_frame);
}

template <class T>
Span<T> carve_array(Span<T> /*type only*/, Arena& arena, const std::string& owner, std::size_t count) {
  return arena.carve<T>(owner, count);
}

}  // namespace

SurfelSpan carve_surfels(Arena& arena, const std::string& owner, std::size_t count) {
  SurfelSpan s;
  for_each_array([&](auto array) { s.*array = carve_array(s.*array, arena, owner, count); });
  return s;
}

SurfelSpan slice(const SurfelSpan& surfels, std::size_t first, std::size_t count) {
  SurfelSpan s;
  for_each_array([&](auto array) { s.*array = {(surfels.*array).data() + first, count}; });
  return s;
}

void copy_surfel_arrays(const SurfelSpan& source, const SurfelSpan& target) {
  for_each_array([&](auto array) {
    std::copy((source.*array).begin(), (source.*array).end(), (target.*array).begin());
  });
}

void move_surfel(const SurfelSpan& surfels, std::size_t from, std::size_t to) {
  for_each_array([&](auto array) { (surfels.*array)[to] = (surfels.*array)[from]; });
}

}  // namespace loopsift
