// SPDX-License-Identifier: MIT
// Steps of a registration, on the furnished corner that the unit tests use.
#include <benchmark/benchmark.h>

#include "core/proposal/proposer.hpp"
#include "tests/unit/core/proposal/scene.hpp"

namespace loopsift {
namespace {

RegistrationCloud thinned_corner(const Se3& T_world_camera) {
  test::SurfelCloud surfels = test::furnished_corner(T_world_camera);
  RegistrationCloud cloud;
  VoxelThinner(RegistrationCloudOptions()).thin(surfels.span(), &cloud);
  return cloud;
}

const Se3 kElsewhere = test::motion(1, -2, 0.5, 0.3, 0.4, 1.6);

void bench_thin(benchmark::State& state) {
  test::SurfelCloud surfels = test::furnished_corner(Se3());
  VoxelThinner thinner{RegistrationCloudOptions()};
  RegistrationCloud cloud;
  for (auto _ : state) thinner.thin(surfels.span(), &cloud);
  state.counters["points"] = static_cast<double>(cloud.size());
}
BENCHMARK(bench_thin)->Unit(benchmark::kMillisecond);

void bench_features(benchmark::State& state) {
  const RegistrationCloud cloud = thinned_corner(Se3());
  FpfhExtractor extractor{FpfhOptions()};
  Keypoints keypoints;
  for (auto _ : state) extractor.extract(cloud, &keypoints);
  state.counters["points"] = static_cast<double>(cloud.size());
}
BENCHMARK(bench_features)->Unit(benchmark::kMillisecond);

void bench_match(benchmark::State& state) {
  FpfhExtractor extractor{FpfhOptions()};
  Keypoints target, source;
  extractor.extract(thinned_corner(Se3()), &target);
  extractor.extract(thinned_corner(kElsewhere), &source);
  FeatureMatcher matcher;
  matcher.set_target(target.features);
  std::vector<Match> matches;
  for (auto _ : state) matcher.match(source.features, 1024, &matches);
  state.counters["keypoints"] = static_cast<double>(source.size());
}
BENCHMARK(bench_match)->Unit(benchmark::kMillisecond);

void bench_refine(benchmark::State& state) {
  const RegistrationCloud target = thinned_corner(Se3()), source = thinned_corner(kElsewhere);
  NearestField field;
  field.build(target.points, 0.2F, 0.05F, 1 << 20);
  const Se3 start = kElsewhere * test::motion(0.05, 0.05, -0.05, 0.02, 0.02, 0.02);
  for (auto _ : state) benchmark::DoNotOptimize(refine(IcpOptions(), {&target, &field}, source, start));
}
BENCHMARK(bench_refine)->Unit(benchmark::kMillisecond);

/// One fragment against one other, both starts, with everything that comes before.
void bench_pair(benchmark::State& state) {
  std::vector<test::SurfelCloud> surfels = {test::furnished_corner(Se3()), test::flat_floor(),
                                            test::furnished_corner(kElsewhere)};
  std::vector<Fragment> fragments(surfels.size());
  Arena measuring;
  { const Proposer sized(ProposalOptions(), measuring); }
  Arena arena(measuring.used_bytes());
  Proposer proposer(ProposalOptions(), arena);
  for (std::size_t k = 0; k < surfels.size(); ++k) {
    fragments[k].id.value = static_cast<std::int32_t>(k);
    fragments[k].surfels = surfels[k].span();
    proposer.add_fragment(fragments[k]);
  }
  const std::vector<Se3> estimate = {Se3(), Se3(), kElsewhere * test::motion(0.05, 0, 0, 0, 0, 0.02)};
  std::vector<Loop> loops;
  for (auto _ : state) {
    loops.clear();
    proposer.propose(fragments[2].id, estimate, {}, &loops);
  }
}
BENCHMARK(bench_pair)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace loopsift
