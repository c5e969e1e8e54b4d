#include "laboratory/simulation/scene/ray_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>

namespace roomwise::simulation {
namespace {

constexpr unsigned kOpaqueMask = 1, kClearMask = 2;
constexpr unsigned kOpaqueGeometry = 0, kClearGeometry = 1;

struct DeviceCloser {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneCloser {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

void set_ray(RTCRay& ray, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
             float nearest, float farthest, unsigned mask) {
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = nearest;
  ray.tfar = farthest;
  ray.time = 0;
  ray.mask = mask;
  ray.id = 0;
  ray.flags = 0;
}

bool attach(RTCDevice device, RTCScene scene, std::span<const Eigen::Vector3f> positions,
            std::span<const RayCaster::Corners> triangles, unsigned id, unsigned mask) {
  if (triangles.empty()) return true;
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), positions.size()));
  auto* corners = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), triangles.size()));
  const bool has_memory = vertices != nullptr && corners != nullptr;
  if (has_memory) {
    for (const Eigen::Vector3f& position : positions) {
      vertices = std::copy_n(position.data(), 3, vertices);
    }
    for (const RayCaster::Corners& triangle : triangles) {
      corners = std::copy_n(triangle.data(), 3, corners);
    }
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
  }
  rtcReleaseGeometry(geometry);
  return has_memory;
}

// The point of a triangle that is nearest to another (C. Ericson, "Real-Time Collision Detection",
// section 5.1.5): the regions around corners and edges are told apart by barycentric weights.
Eigen::Vector3f nearest_on_triangle(const Eigen::Vector3f& point, const Eigen::Vector3f& a,
                                    const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a, ac = c - a;
  const float d1 = ab.dot(point - a), d2 = ac.dot(point - a);
  if (d1 <= 0 && d2 <= 0) return a;
  const float d3 = ab.dot(point - b), d4 = ac.dot(point - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const float d5 = ab.dot(point - c), d6 = ac.dot(point - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const float sum = va + vb + vc;
  if (!(sum > 0)) return a;  // a triangle without area
  return a + vb / sum * ab + vc / sum * ac;
}

// Looks at one triangle for rtcPointQuery and narrows the query to its distance.
bool narrow_query(RTCPointQueryFunctionArguments* arguments) {
  const auto scene = static_cast<RTCScene>(arguments->userPtr);
  const RTCGeometry geometry = rtcGetGeometry(scene, arguments->geomID);
  const auto* positions =
      static_cast<const float*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  const auto* triangles =
      static_cast<const unsigned*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0));
  const unsigned* corners = triangles + std::size_t{3} * arguments->primID;
  const auto corner = [&](int i) -> Eigen::Vector3f {
    return Eigen::Map<const Eigen::Vector3f>(positions + std::size_t{3} * corners[i]);
  };
  RTCPointQuery& query = *arguments->query;
  const Eigen::Vector3f point(query.x, query.y, query.z);
  const float distance =
      (nearest_on_triangle(point, corner(0), corner(1), corner(2)) - point).norm();
  if (!(distance < query.radius)) return false;
  query.radius = distance;
  return true;
}

}  // namespace

struct RayCaster::Handles {
  std::unique_ptr<RTCDeviceTy, DeviceCloser> device;
  std::unique_ptr<RTCSceneTy, SceneCloser> scene;
};

RayCaster::RayCaster(std::unique_ptr<Handles> handles, std::uint32_t opaque_count, bool has_clear)
    : handles_(std::move(handles)), opaque_count_(opaque_count), has_clear_(has_clear) {}

RayCaster::~RayCaster() = default;

Expected<std::unique_ptr<RayCaster>> RayCaster::build(std::span<const Eigen::Vector3f> positions,
                                                      std::span<const Corners> opaque,
                                                      std::span<const Corners> clear) {
  auto handles = std::make_unique<Handles>();
  handles->device.reset(rtcNewDevice("threads=1,set_affinity=0"));
  if (!handles->device) {
    return fail("Embree cannot be started (error {})",
                static_cast<int>(rtcGetDeviceError(nullptr)));
  }
  RTCDevice device = handles->device.get();
  handles->scene.reset(rtcNewScene(device));
  RTCScene scene = handles->scene.get();
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  const bool attached = attach(device, scene, positions, opaque, kOpaqueGeometry, kOpaqueMask) &&
                        attach(device, scene, positions, clear, kClearGeometry, kClearMask);
  if (attached) rtcCommitScene(scene);
  if (const RTCError error = rtcGetDeviceError(device); !attached || error != RTC_ERROR_NONE) {
    return fail("Embree cannot take {} triangles (error {}); is there memory enough?",
                opaque.size() + clear.size(), static_cast<int>(error));
  }
  return std::unique_ptr<RayCaster>(
      new RayCaster(std::move(handles), static_cast<std::uint32_t>(opaque.size()), !clear.empty()));
}

std::optional<RayHit> RayCaster::first_hit(const Eigen::Vector3f& origin,
                                           const Eigen::Vector3f& direction, float nearest,
                                           float farthest, Meets meets) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query;
  set_ray(query.ray, origin, direction, nearest, farthest,
          meets == Meets::kOpaque ? kOpaqueMask : kOpaqueMask | kClearMask);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(handles_->scene.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const std::uint32_t before = query.hit.geomID == kClearGeometry ? opaque_count_ : 0;
  return RayHit{query.ray.tfar, query.hit.u, query.hit.v, before + query.hit.primID};
}

std::array<std::optional<RayHit>, RayCaster::kBundle> RayCaster::first_hits(
    const Eigen::Vector3f& origin, const Bundle& bundle) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) RTCRayHit16 query{};
  alignas(64) std::array<int, kBundle> is_valid{};  // -1: to be traced
  RTCRay16& rays = query.ray;
  for (std::size_t i = 0; i < bundle.count; ++i) {
    is_valid[i] = -1;
    rays.org_x[i] = origin.x();
    rays.org_y[i] = origin.y();
    rays.org_z[i] = origin.z();
    rays.dir_x[i] = bundle.directions[i].x();
    rays.dir_y[i] = bundle.directions[i].y();
    rays.dir_z[i] = bundle.directions[i].z();
    rays.tfar[i] = bundle.farthest[i];
    rays.mask[i] = kOpaqueMask | kClearMask;
  }
  std::fill(std::begin(query.hit.geomID), std::end(query.hit.geomID), RTC_INVALID_GEOMETRY_ID);
  std::fill(std::begin(query.hit.instID[0]), std::end(query.hit.instID[0]),
            RTC_INVALID_GEOMETRY_ID);
  rtcIntersect16(is_valid.data(), handles_->scene.get(), &context, &query);
  std::array<std::optional<RayHit>, kBundle> hits;
  for (std::size_t i = 0; i < bundle.count; ++i) {
    if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const std::uint32_t before = query.hit.geomID[i] == kClearGeometry ? opaque_count_ : 0;
    hits[i] =
        RayHit{query.ray.tfar[i], query.hit.u[i], query.hit.v[i], before + query.hit.primID[i]};
  }
  return hits;
}

bool RayCaster::is_blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                           float nearest, float farthest) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray;
  set_ray(ray, origin, direction, nearest, farthest, kOpaqueMask);
  rtcOccluded1(handles_->scene.get(), &context, &ray);
  return ray.tfar < 0;
}

float RayCaster::nearest_distance(const Eigen::Vector3f& point, float most) const {
  RTCPointQuery query{point.x(), point.y(), point.z(), 0, most};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const bool found =
      rtcPointQuery(handles_->scene.get(), &query, &context, narrow_query, handles_->scene.get());
  return found ? query.radius : std::numeric_limits<float>::infinity();
}

}  // namespace roomwise::simulation
