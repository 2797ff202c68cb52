// SPDX-License-Identifier: MIT
#include "drivers/synth/renderer.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace loopsift {
namespace {

constexpr int kLanes = 8;
constexpr int kBlockWidth = 4, kBlockHeight = 2;  // the pixels of one packet

/// Two fixed directions of light besides the ambient: every face of a box has its own brightness.
float light(const Eigen::Vector3f& normal) {
  static const Eigen::Vector3f kAbove = Eigen::Vector3f(0.35F, 0.2F, 0.91F).normalized();
  static const Eigen::Vector3f kSide = Eigen::Vector3f(-0.8F, 0.55F, 0.2F).normalized();
  return 0.62F + 0.24F * std::max(0.0F, normal.dot(kAbove)) + 0.14F * std::max(0.0F, normal.dot(kSide));
}

unsigned char to_byte(float v) {
  return static_cast<unsigned char>(std::clamp(v, 0.0F, 1.0F) * 255.0F + 0.5F);
}

template <class T>
void upload(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const std::vector<T>& values) {
  static_assert(sizeof(T) == 12, "three packed 32-bit numbers");
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), values.size());
  if (buffer != nullptr) std::copy(values.begin(), values.end(), static_cast<T*>(buffer));
}

}  // namespace

struct Renderer::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Embree() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

/// Eight rays and what they hit.
struct Renderer::Packet {
  RTCRayHit8 rays;
  alignas(32) std::array<int, kLanes> valid;
  alignas(32) std::array<float, kLanes> cosine;

  explicit Packet(const Eigen::Vector3f& origin) {
    for (int lane = 0; lane < kLanes; ++lane) {
      rays.ray.org_x[lane] = origin.x();
      rays.ray.org_y[lane] = origin.y();
      rays.ray.org_z[lane] = origin.z();
      rays.ray.tnear[lane] = 0.0F;
      rays.ray.time[lane] = 0.0F;
      rays.ray.mask[lane] = ~0U;
      rays.ray.id[lane] = 0;
      rays.ray.flags[lane] = 0;
      rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
  }

  [[nodiscard]] bool hit(int lane) const { return rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID; }
  [[nodiscard]] Eigen::Vector3f point(int lane) const {
    const float z = rays.ray.tfar[lane];
    return {rays.ray.org_x[lane] + z * rays.ray.dir_x[lane], rays.ray.org_y[lane] + z * rays.ray.dir_y[lane],
            rays.ray.org_z[lane] + z * rays.ray.dir_z[lane]};
  }

  /// Rays whose parameter is the z depth: direction (x, y, 1) in the camera, turned into the world.
  void aim(const PinholeCamera& camera, const Eigen::Matrix3f& R, int x, int y) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int u = x + lane % kBlockWidth, v = y + lane / kBlockWidth;
      const float dx = (static_cast<float>(u) - camera.cx) / camera.fx;
      const float dy = (static_cast<float>(v) - camera.cy) / camera.fy;
      valid[static_cast<std::size_t>(lane)] = u < camera.width && v < camera.height ? -1 : 0;
      rays.ray.dir_x[lane] = R(0, 0) * dx + R(0, 1) * dy + R(0, 2);
      rays.ray.dir_y[lane] = R(1, 0) * dx + R(1, 1) * dy + R(1, 2);
      rays.ray.dir_z[lane] = R(2, 0) * dx + R(2, 1) * dy + R(2, 2);
      rays.ray.tfar[lane] = std::numeric_limits<float>::infinity();
      rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
  }

  /// The cosine between ray and normal; negative where the triangle is seen from inside.
  void measure_cosines() {
    for (int lane = 0; lane < kLanes; ++lane) {
      const float dx = rays.ray.dir_x[lane], dy = rays.ray.dir_y[lane], dz = rays.ray.dir_z[lane];
      const float nx = rays.hit.Ng_x[lane], ny = rays.hit.Ng_y[lane], nz = rays.hit.Ng_z[lane];
      const float squared_lengths = (dx * dx + dy * dy + dz * dz) * (nx * nx + ny * ny + nz * nz);
      cosine[static_cast<std::size_t>(lane)] = -(dx * nx + dy * ny + dz * nz) / std::sqrt(squared_lengths);
    }
  }
};

Renderer::Renderer(const Scene& scene, std::unique_ptr<Embree> embree)
    : scene_(scene), embree_(std::move(embree)) {
  const auto corner = [&](int i) -> const Eigen::Vector3f& {
    return scene_.mesh.vertices[static_cast<std::size_t>(i)];
  };
  for (const Eigen::Vector3i& t : scene_.mesh.triangles) {
    const Eigen::Vector3f normal =
        (corner(t.y()) - corner(t.x())).cross(corner(t.z()) - corner(t.x())).normalized();
    int axis = 0;
    (void)normal.cwiseAbs().maxCoeff(&axis);
    faces_.push_back({light(normal), light(-normal), axis});
  }
}
Renderer::~Renderer() = default;

Expected<std::unique_ptr<Renderer>> Renderer::create(const Scene& scene) {
  auto embree = std::make_unique<Embree>();
  embree->device = rtcNewDevice("threads=1");
  if (embree->device == nullptr)
    return Error{ErrorCode::kUnsupported, "synth: Embree does not start on this machine (error " +
                                              std::to_string(rtcGetDeviceError(nullptr)) + ")"};
  embree->scene = rtcNewScene(embree->device);
  rtcSetSceneFlags(embree->scene, RTC_SCENE_FLAG_ROBUST);  // no ray slips through between two triangles
  RTCGeometry geometry = rtcNewGeometry(embree->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  upload(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, scene.mesh.vertices);
  upload(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, scene.mesh.triangles);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(embree->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(embree->scene);
  if (const RTCError error = rtcGetDeviceError(embree->device); error != RTC_ERROR_NONE)
    return Error{ErrorCode::kUnsupported,
                 "synth: Embree cannot take the scene (error " + std::to_string(error) + ")"};
  return std::unique_ptr<Renderer>(new Renderer(scene, std::move(embree)));
}

Rgb8 Renderer::shade(const Packet& packet, int lane) const {
  const auto prim = static_cast<std::size_t>(packet.rays.hit.primID[lane]);
  const Eigen::Vector3i& t = scene_.mesh.triangles[prim];
  const float b = packet.rays.hit.u[lane], c = packet.rays.hit.v[lane], a = 1.0F - b - c;
  const auto i = static_cast<std::size_t>(t.x()), j = static_cast<std::size_t>(t.y()),
             k = static_cast<std::size_t>(t.z());
  const Face& face = faces_[prim];
  Eigen::Vector3f color;
  if (!scene_.mesh.colors.empty()) {
    const auto at = [&](std::size_t n) {
      const Rgb8& v = scene_.mesh.colors[n];
      return Eigen::Vector3f(v.r, v.g, v.b);
    };
    color = (a * at(i) + b * at(j) + c * at(k)) * (1.0F / 255.0F);
  } else {
    Eigen::Vector2f uv;
    if (!scene_.uv.empty()) {
      uv = a * scene_.uv[i] + b * scene_.uv[j] + c * scene_.uv[k];
    } else {  // projected along the axis that the surface faces most
      const Eigen::Vector3f p = packet.point(lane);
      uv = {p((face.axis + 1) % 3), p((face.axis + 2) % 3)};
    }
    color = sample_material(scene_.materials[scene_.material_of[prim]], uv.x(), uv.y());
  }
  color *= packet.cosine[static_cast<std::size_t>(lane)] >= 0.0F ? face.light_front : face.light_back;
  return {to_byte(color.x()), to_byte(color.y()), to_byte(color.z())};
}

void Renderer::render(const PinholeCamera& camera, const Se3& T_world_camera, bool want_color,
                      RenderedFrame* out) const {
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  out->width = camera.width;
  out->height = camera.height;
  out->depth.resize(pixels);
  out->cosine.resize(pixels);
  out->color.resize(want_color ? pixels : 0);
  const Eigen::Matrix3f R = T_world_camera.rotation().cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  Packet packet(T_world_camera.translation().cast<float>());
  for (int y = 0; y < camera.height; y += kBlockHeight)
    for (int x = 0; x < camera.width; x += kBlockWidth) {
      packet.aim(camera, R, x, y);
      rtcIntersect8(packet.valid.data(), embree_->scene, &context, &packet.rays);
      packet.measure_cosines();
      store(packet, x, y, want_color, out);
    }
}

void Renderer::store(const Packet& packet, int x, int y, bool want_color, RenderedFrame* out) const {
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto l = static_cast<std::size_t>(lane);
    if (packet.valid[l] == 0) continue;
    const auto pixel =
        static_cast<std::size_t>((y + lane / kBlockWidth) * out->width + x + lane % kBlockWidth);
    const bool hit = packet.hit(lane);
    out->depth[pixel] = hit ? packet.rays.ray.tfar[lane] : 0.0F;
    out->cosine[pixel] = hit ? std::abs(packet.cosine[l]) : 0.0F;
    if (want_color) out->color[pixel] = hit ? shade(packet, lane) : Rgb8{};
  }
}

}  // namespace loopsift
