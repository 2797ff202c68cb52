// SPDX-License-Identifier: MIT
#include "drivers/synth/renderer.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
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
  if (buffer != nullptr) std::memcpy(buffer, values.data(), values.size() * sizeof(T));
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

  [[nodiscard]] bool hit(int lane) const { return rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID; }
  [[nodiscard]] Eigen::Vector3f direction(int lane) const {
    return {rays.ray.dir_x[lane], rays.ray.dir_y[lane], rays.ray.dir_z[lane]};
  }
  [[nodiscard]] Eigen::Vector3f origin(int lane) const {
    return {rays.ray.org_x[lane], rays.ray.org_y[lane], rays.ray.org_z[lane]};
  }
  /// Unit length, towards the camera.
  [[nodiscard]] Eigen::Vector3f normal(int lane) const {
    const Eigen::Vector3f n =
        Eigen::Vector3f(rays.hit.Ng_x[lane], rays.hit.Ng_y[lane], rays.hit.Ng_z[lane]).normalized();
    return n.dot(direction(lane)) > 0.0F ? Eigen::Vector3f(-n) : n;
  }

  /// Rays whose parameter is the z depth: direction (x, y, 1) in the camera, turned into the world.
  void aim(const PinholeCamera& camera, const Se3f& T_world_camera, int x, int y) {
    for (int lane = 0; lane < kLanes; ++lane) {
      const int u = x + lane % kBlockWidth, v = y + lane / kBlockWidth;
      valid[static_cast<std::size_t>(lane)] = u < camera.width && v < camera.height ? -1 : 0;
      const Eigen::Vector3f d =
          T_world_camera.R * camera.unproject(static_cast<float>(u), static_cast<float>(v), 1.0F);
      rays.ray.org_x[lane] = T_world_camera.t.x();
      rays.ray.org_y[lane] = T_world_camera.t.y();
      rays.ray.org_z[lane] = T_world_camera.t.z();
      rays.ray.dir_x[lane] = d.x();
      rays.ray.dir_y[lane] = d.y();
      rays.ray.dir_z[lane] = d.z();
      rays.ray.tnear[lane] = 0.0F;
      rays.ray.tfar[lane] = std::numeric_limits<float>::infinity();
      rays.ray.time[lane] = 0.0F;
      rays.ray.mask[lane] = ~0U;
      rays.ray.id[lane] = 0;
      rays.ray.flags[lane] = 0;
      rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
  }
};

Renderer::Renderer(const Scene& scene, std::unique_ptr<Embree> embree)
    : scene_(scene), embree_(std::move(embree)) {}
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
  const Eigen::Vector3f normal = packet.normal(lane);
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
      const Eigen::Vector3f p = packet.origin(lane) + packet.rays.ray.tfar[lane] * packet.direction(lane);
      int axis = 0;
      (void)normal.cwiseAbs().maxCoeff(&axis);
      uv = {p((axis + 1) % 3), p((axis + 2) % 3)};
    }
    color = sample_material(scene_.materials[scene_.material_of[prim]], uv.x(), uv.y());
  }
  color *= light(normal);
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
  const Se3f T(T_world_camera);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  Packet packet;
  for (int y = 0; y < camera.height; y += kBlockHeight)
    for (int x = 0; x < camera.width; x += kBlockWidth) {
      packet.aim(camera, T, x, y);
      rtcIntersect8(packet.valid.data(), embree_->scene, &context, &packet.rays);
      for (int lane = 0; lane < kLanes; ++lane) {
        if (packet.valid[static_cast<std::size_t>(lane)] == 0) continue;
        const auto pixel =
            static_cast<std::size_t>((y + lane / kBlockWidth) * camera.width + x + lane % kBlockWidth);
        const bool hit = packet.hit(lane);
        out->depth[pixel] = hit ? packet.rays.ray.tfar[lane] : 0.0F;
        out->cosine[pixel] =
            hit ? -packet.normal(lane).dot(packet.direction(lane)) / packet.direction(lane).norm() : 0.0F;
        if (want_color) out->color[pixel] = hit ? shade(packet, lane) : Rgb8{};
      }
    }
}

}  // namespace loopsift
