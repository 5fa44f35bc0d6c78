// Visibility of 1.0 M facets from 500 cameras, beside loops over Embree written by hand.
// usage: bench_coverage FOLDER [counts|metrics|occluded1|occluded16] [THREADS]
//   FOLDER holds mesh_v.f32, mesh_f.u32 and cams.txt
//   (a row a camera: x y z, rotation world -> camera row by row, fx fy cx cy width height).
#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "bench/cpu_clock.hpp"
#include "coverage/coverage.hpp"

namespace {

using cairn::geometry::TriangleMesh;
using cairn::geometry::Vec3;

template <typename T>
std::vector<T> read_values(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  std::vector<T> values(static_cast<std::size_t>(in.tellg()) / sizeof(T));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
  return values;
}

TriangleMesh read_mesh(const std::string& folder) {
  TriangleMesh mesh;
  const auto v = read_values<float>(folder + "/mesh_v.f32");
  const auto f = read_values<std::uint32_t>(folder + "/mesh_f.u32");
  for (std::size_t i = 0; i + 2 < v.size(); i += 3)
    mesh.vertices.emplace_back(static_cast<double>(v[i]), static_cast<double>(v[i + 1]), static_cast<double>(v[i + 2]));
  for (std::size_t i = 0; i + 2 < f.size(); i += 3) mesh.triangles.push_back({f[i], f[i + 1], f[i + 2]});
  return mesh;
}

cairn::coverage::ViewSet read_views(const std::string& folder) {
  cairn::coverage::ViewSet set;
  std::ifstream in(folder + "/cams.txt");
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream row(line);
    double n[18];
    for (double& value : n) row >> value;
    cairn::survey::Camera camera;
    camera.fx_px = n[12];
    camera.fy_px = n[13];
    camera.cx_px = n[14];
    camera.cy_px = n[15];
    camera.width_px = static_cast<std::int64_t>(n[16]);
    camera.height_px = static_cast<std::int64_t>(n[17]);
    if (set.cameras.empty() || !(set.cameras.back() == camera)) set.cameras.push_back(camera);
    cairn::coverage::View view;
    view.camera = set.cameras.size() - 1;
    view.T_world_camera.translation = Vec3(n[0], n[1], n[2]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) view.T_world_camera.rotation(j, i) = n[3 + 3 * i + j];
    set.views.push_back(view);
  }
  return set;
}

// The plain loop: facets in file order, each pair tested as the definition says, rays one or sixteen at a time.
std::vector<std::uint32_t> by_hand(const TriangleMesh& mesh, const cairn::coverage::ViewSet& set, bool packets,
                                   std::uint64_t& rays) {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* v = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices.size()));
  auto* f = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    for (int k = 0; k < 3; ++k) v[3 * i + static_cast<std::size_t>(k)] = static_cast<float>(mesh.vertices[i][k]);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) f[3 * i + k] = mesh.triangles[i][k];
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);

  const std::size_t count = mesh.triangles.size();
  std::vector<Vec3> centroid(count), normal(count);
  for (std::size_t i = 0; i < count; ++i) {
    centroid[i] = mesh.centroid(i);
    normal[i] = mesh.area_vector(i);
  }
  std::vector<std::uint32_t> views(count, 0);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  if (packets) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  RTCRay16 packet{};
  alignas(64) int valid[16];
  std::uint32_t facet[16];
  int filled = 0;
  const auto flush = [&] {
    for (int i = 0; i < 16; ++i) valid[i] = i < filled ? -1 : 0;
    rtcOccluded16(valid, scene, &context, &packet);
    for (int i = 0; i < filled; ++i)
      if (packet.tfar[i] >= 0.0F) ++views[facet[i]];
    filled = 0;
  };
  for (const auto& view : set.views) {
    const auto& camera = set.cameras[view.camera];
    const auto& T = view.T_world_camera;
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 d = centroid[i] - T.translation;
      if (!(normal[i].dot(d) < 0.0)) continue;
      const Vec3 p = T.rotation.transpose() * d;
      if (!(p.z() > 0.0)) continue;
      const double x = camera.fx_px * p.x() / p.z() + camera.cx_px, y = camera.fy_px * p.y() / p.z() + camera.cy_px;
      if (!(x >= 0.0 && x <= static_cast<double>(camera.width_px) && y >= 0.0 &&
            y <= static_cast<double>(camera.height_px)))
        continue;
      ++rays;
      const Eigen::Vector3f o = T.translation.cast<float>(), e = d.cast<float>();
      if (packets) {
        packet.org_x[filled] = o.x();
        packet.org_y[filled] = o.y();
        packet.org_z[filled] = o.z();
        packet.dir_x[filled] = e.x();
        packet.dir_y[filled] = e.y();
        packet.dir_z[filled] = e.z();
        packet.tnear[filled] = packet.time[filled] = 0.0F;
        packet.tfar[filled] = 1.0F - 1e-4F;
        packet.mask[filled] = 0xFFFFFFFFU;
        packet.id[filled] = packet.flags[filled] = 0;
        facet[filled++] = static_cast<std::uint32_t>(i);
        if (filled == 16) flush();
      } else {
        RTCRay ray{};
        ray.org_x = o.x();
        ray.org_y = o.y();
        ray.org_z = o.z();
        ray.dir_x = e.x();
        ray.dir_y = e.y();
        ray.dir_z = e.z();
        ray.tfar = 1.0F - 1e-4F;
        ray.mask = 0xFFFFFFFFU;
        rtcOccluded1(scene, &context, &ray);
        if (ray.tfar >= 0.0F) ++views[i];
      }
    }
    if (filled > 0) flush();
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return views;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::string folder = argv[1], mode = argc > 2 ? argv[2] : "metrics";
  const cairn::base::ThreadLimit limit(argc > 3 ? std::stoi(argv[3]) : 1);
  const TriangleMesh mesh = read_mesh(folder);
  const auto set = read_views(folder);
  std::vector<std::uint32_t> views;
  std::uint64_t rays = 0;
  const double start = cairn::bench::cpu_seconds();
  double scene_seconds = 0.0;
  if (mode == "occluded1" || mode == "occluded16") {
    views = by_hand(mesh, set, mode == "occluded16", rays);
  } else {
    const cairn::visibility::Scene scene(mesh, cairn::visibility::Tracing::fast);
    scene_seconds = cairn::bench::cpu_seconds() - start;
    cairn::coverage::CoverageOptions options;
    options.metrics = mode == "metrics";
    cairn::base::RunContext ctx;
    const auto result = cairn::coverage::coverage(mesh, scene, set, options, ctx);
    views = result.views;
    rays = result.rays;
  }
  const double seconds = cairn::bench::cpu_seconds() - start;
  std::uint64_t sum = 0, hash = 1469598103934665603ULL;
  for (const std::uint32_t n : views) {
    sum += n;
    hash = (hash ^ n) * 1099511628211ULL;
  }
  std::printf("%s: %zu facets, %zu views, %llu rays, %llu seen, hash %016llx, %.2f CPU s (scene %.2f), peak %.0f MB\n",
              mode.c_str(), mesh.triangles.size(), set.views.size(), static_cast<unsigned long long>(rays),
              static_cast<unsigned long long>(sum), static_cast<unsigned long long>(hash), seconds, scene_seconds,
              cairn::bench::peak_megabytes());
  if (argc > 4) {
    std::ofstream out(argv[4], std::ios::binary);
    out.write(reinterpret_cast<const char*>(views.data()), static_cast<std::streamsize>(views.size() * 4));
  }
  return 0;
}
