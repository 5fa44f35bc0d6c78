#include "visibility/scene.hpp"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>

#include "base/error.hpp"

namespace cairn::visibility {
namespace {

using geometry::Box3;
using geometry::Triangle;
using geometry::TriangleMesh;
using geometry::Vec3;

constexpr std::size_t kPacket = 16;
constexpr double kFarthest = 1e8;  // m; beyond it single precision holds nothing of a survey
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Embree reports errors through a callback that must not throw.
struct ErrorSlot {
  std::mutex mutex;
  RTCError code = RTC_ERROR_NONE;
  std::string message;

  static void receive(void* self, RTCError code, const char* message) {
    auto& slot = *static_cast<ErrorSlot*>(self);
    const std::scoped_lock lock(slot.mutex);
    if (slot.code != RTC_ERROR_NONE) return;
    slot.code = code;
    slot.message = message == nullptr ? "" : message;
  }
  void raise() {
    const std::scoped_lock lock(mutex);
    if (code == RTC_ERROR_NONE) return;
    throw base::Error(code == RTC_ERROR_OUT_OF_MEMORY ? base::ErrorCode::resource_exhausted : base::ErrorCode::internal,
                      "the ray-casting scene cannot be built")
        .found(message);
  }
};

template <auto Release>
struct Releaser {
  template <typename Handle>
  void operator()(Handle* handle) const {
    Release(handle);
  }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Releaser<rtcReleaseDevice>>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, Releaser<rtcReleaseScene>>;
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Releaser<rtcReleaseGeometry>>;

bool usable_vertex(const Vec3& v) {
  return v.allFinite() && v.cwiseAbs().maxCoeff() <= kFarthest;
}

bool usable(const TriangleMesh& mesh, const Triangle& t) {
  const std::size_t count = mesh.vertices.size();
  if (t[0] >= count || t[1] >= count || t[2] >= count) return false;
  const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  if (!usable_vertex(a) || !usable_vertex(b) || !usable_vertex(c)) return false;
  return (b - a).cross(c - a).squaredNorm() > 0.0;
}

// Offset taken off before rounding to single precision. A mesh that is not far from the origin
// for its size loses nothing by staying where it is, and its vertices keep their exact bits.
Vec3 single_precision_offset(const Box3& bounds) {
  if (bounds.empty()) return Vec3::Zero();
  const double extent = bounds.size().maxCoeff();
  const Vec3 centre = bounds.centre();
  Vec3 offset = Vec3::Zero();
  for (int i = 0; i < 3; ++i)
    if (std::abs(centre[i]) > extent) offset[i] = std::round(centre[i]);
  return offset;
}

// Of two triangles hit at one distance the lower index must win, in whatever order a leaf holds them.
struct CastContext {
  RTCIntersectContext embree;  // first: Embree hands back a pointer to it
  float distance;
  unsigned primitive;
};
static_assert(std::is_standard_layout_v<CastContext>);

void keep_lower_index(const RTCFilterFunctionNArguments* args) {
  auto* context = reinterpret_cast<CastContext*>(args->context);
  const float distance = RTCRayN_tfar(args->ray, args->N, 0);
  const unsigned primitive = RTCHitN_primID(args->hit, args->N, 0);
  if (distance == context->distance && primitive > context->primitive) {
    args->valid[0] = 0;
  } else {
    context->distance = distance;
    context->primitive = primitive;
  }
}

struct Packet {
  RTCRay16 ray;
  alignas(64) std::array<int, kPacket> valid;

  void clear(float far) {
    valid.fill(0);
    for (std::size_t i = 0; i < kPacket; ++i) {
      ray.org_x[i] = ray.org_y[i] = ray.org_z[i] = 0.0F;
      ray.dir_x[i] = ray.dir_y[i] = 0.0F;
      ray.dir_z[i] = 1.0F;
      ray.tnear[i] = ray.time[i] = 0.0F;
      ray.tfar[i] = far;
      ray.mask[i] = 0xFFFFFFFFU;
      ray.id[i] = static_cast<unsigned>(i);
      ray.flags[i] = 0;
    }
  }
  void set(std::size_t lane, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
    ray.org_x[lane] = origin.x();
    ray.org_y[lane] = origin.y();
    ray.org_z[lane] = origin.z();
    ray.dir_x[lane] = direction.x();
    ray.dir_y[lane] = direction.y();
    ray.dir_z[lane] = direction.z();
    valid[lane] = -1;
  }
};

}  // namespace

struct Scene::Impl {
  ErrorSlot errors;  // outlives the device that reports to it
  Device device;
  SceneHandle scene;
  Vec3 offset = Vec3::Zero();
  std::vector<std::uint32_t> triangle_of;  // primitive -> triangle of the mesh; empty where they are the same
  std::size_t skipped = 0;

  Impl(const TriangleMesh& mesh, Tracing tracing);

  [[nodiscard]] std::uint32_t triangle(unsigned primitive) const {
    return triangle_of.empty() ? primitive : triangle_of[primitive];
  }
  // Traces one packet; writes the results of its valid lanes to out[0..count).
  void trace_occlusion(Packet& packet, std::uint8_t* out, std::size_t count) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded16(packet.valid.data(), scene.get(), &context, &packet.ray);
    for (std::size_t i = 0; i < count; ++i)
      if (packet.valid[i] != 0) out[i] = packet.ray.tfar[i] < 0.0F ? 1 : 0;
  }
};

Scene::Impl::Impl(const TriangleMesh& mesh, Tracing tracing) {
  std::vector<std::uint32_t> kept;
  kept.reserve(mesh.triangles.size());
  Box3 bounds;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    if (!usable(mesh, t)) continue;
    kept.push_back(static_cast<std::uint32_t>(i));
    for (const std::uint32_t v : t) bounds.extend(mesh.vertices[v]);
  }
  skipped = mesh.triangles.size() - kept.size();
  offset = single_precision_offset(bounds);

  device.reset(rtcNewDevice(nullptr));
  if (!device) throw base::Error(base::ErrorCode::internal, "Embree cannot start");
  rtcSetDeviceErrorFunction(device.get(), &ErrorSlot::receive, &errors);
  scene.reset(rtcNewScene(device.get()));
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_MEDIUM);
  const auto robust = tracing == Tracing::watertight ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE;
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(robust | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
  if (!kept.empty()) {
    const Geometry geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
    rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_MEDIUM);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), kept.size()));
    errors.raise();
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      // Vertices of triangles left out are not used, but may not hold NaN.
      const Vec3 p = usable_vertex(mesh.vertices[v]) ? Vec3(mesh.vertices[v] - offset) : Vec3(Vec3::Zero());
      for (int i = 0; i < 3; ++i) vertices[3 * v + static_cast<std::size_t>(i)] = static_cast<float>(p[i]);
    }
    for (std::size_t k = 0; k < kept.size(); ++k)
      for (std::size_t i = 0; i < 3; ++i) indices[3 * k + i] = mesh.triangles[kept[k]][i];
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene.get(), geometry.get());
  }
  rtcCommitScene(scene.get());
  errors.raise();
  if (skipped > 0) triangle_of = std::move(kept);
}

Scene::Scene(const TriangleMesh& mesh, Tracing tracing) : impl_(std::make_unique<Impl>(mesh, tracing)) {}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

std::size_t Scene::skipped_triangles() const {
  return impl_->skipped;
}

std::vector<Hit> Scene::cast(std::span<const geometry::Ray> rays, double max_distance) const {
  std::vector<Hit> hits(rays.size());
  const float far = max_distance < static_cast<double>(std::numeric_limits<float>::max())
                        ? static_cast<float>(max_distance)
                        : kInfinity;
  // One ray at a time: Embree's packets round distances differently from its single rays, and switch between the
  // two by the company a ray keeps, so that ties between neighbours would depend on the batch.
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const geometry::Ray& ray = rays[i];
    if (!ray.origin.allFinite() || !ray.direction.allFinite() || !(ray.direction.squaredNorm() > 0.0)) continue;
    const Eigen::Vector3f origin = (ray.origin - impl_->offset).cast<float>();
    const Eigen::Vector3f direction = ray.direction.cast<float>();
    CastContext context;
    rtcInitIntersectContext(&context.embree);
    context.embree.filter = &keep_lower_index;
    context.distance = kInfinity;
    context.primitive = kNoTriangle;
    RTCRayHit query{};
    query.ray.org_x = origin.x();
    query.ray.org_y = origin.y();
    query.ray.org_z = origin.z();
    query.ray.dir_x = direction.x();
    query.ray.dir_y = direction.y();
    query.ray.dir_z = direction.z();
    query.ray.tfar = far;
    query.ray.mask = 0xFFFFFFFFU;
    query.hit.geomID = kNoTriangle;
    query.hit.primID = kNoTriangle;
    rtcIntersect1(impl_->scene.get(), &context.embree, &query);
    if (query.hit.geomID == kNoTriangle) continue;
    hits[i] = {static_cast<double>(query.ray.tfar), impl_->triangle(query.hit.primID)};
  }
  return hits;
}

std::vector<std::uint8_t> Scene::blocked(std::span<const Segment> segments, double end_gap) const {
  std::vector<std::uint8_t> result(segments.size(), 0);
  Packet packet;
  const float far = static_cast<float>(1.0 - end_gap);
  for (std::size_t begin = 0; begin < segments.size(); begin += kPacket) {
    const std::size_t count = std::min(kPacket, segments.size() - begin);
    packet.clear(far);
    for (std::size_t i = 0; i < count; ++i) {
      const Segment& s = segments[begin + i];
      const Vec3 direction = s.to - s.from;
      if (!direction.allFinite()) {
        result[begin + i] = 1;
      } else if (direction.squaredNorm() > 0.0) {
        packet.set(i, (s.from - impl_->offset).cast<float>(), direction.cast<float>());
      }
    }
    impl_->trace_occlusion(packet, result.data() + begin, count);
  }
  return result;
}

void Scene::blocked_from(const Vec3& from, std::span<const Vec3> to, std::span<std::uint8_t> blocked,
                         double end_gap) const {
  if (to.size() != blocked.size())
    throw base::Error(base::ErrorCode::internal, "one result is needed for each segment")
        .found(std::to_string(blocked.size()))
        .allowed(std::to_string(to.size()));
  const float far = static_cast<float>(1.0 - end_gap);
  const Eigen::Vector3f origin = (from - impl_->offset).cast<float>();
  Packet packet;
  for (std::size_t begin = 0; begin < to.size(); begin += kPacket) {
    const std::size_t count = std::min(kPacket, to.size() - begin);
    packet.clear(far);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 direction = to[begin + i] - from;
      const bool finite = direction.allFinite();
      blocked[begin + i] = finite ? 0 : 1;
      if (finite && direction.squaredNorm() > 0.0) packet.set(i, origin, direction.cast<float>());
    }
    impl_->trace_occlusion(packet, blocked.data() + begin, count);
  }
}

}  // namespace cairn::visibility
