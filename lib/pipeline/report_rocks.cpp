#include <cmath>
#include <string>

#include "io/json.hpp"
#include "io/ply.hpp"
#include "io/rocks_json.hpp"
#include "pipeline/report_parts.hpp"

namespace cairn::pipeline {
namespace {

constexpr double kOnPlane_m = 1e-5;          // files hold doubles; the cap's vertices were put on the plane exactly
constexpr double kFractionTolerance = 0.02;  // of the area; a different closure shows up as more

// Contact points of rocks/<id>.json; empty where there is no such file.
std::vector<geometry::Vec3> contact_points(const std::filesystem::path& file) {
  std::vector<geometry::Vec3> points;
  if (file.empty()) return points;
  const io::Json json = io::read_json(file);
  const io::Json* contact = json.find("contact");
  const io::Json* list = contact == nullptr || !contact->is_object() ? nullptr : contact->find("line");
  if (list == nullptr || !list->is_array()) return points;
  for (const io::Json& point : list->as_array()) points.push_back(point.at("position_m").as_vec3());
  return points;
}

}  // namespace

std::vector<std::uint8_t> seen_triangles(const geometry::TriangleMesh& mesh, const std::vector<geometry::Vec3>& contact,
                                         double unseen_area_fraction) {
  if (contact.size() < 3) return {};
  geometry::Vec3 middle = geometry::Vec3::Zero();
  for (const auto& p : contact) middle += p;
  middle /= static_cast<double>(contact.size());
  // Plane z = z0 + gx x + gy y by least squares.
  geometry::Mat2 a = geometry::Mat2::Zero();
  geometry::Vec2 b = geometry::Vec2::Zero();
  for (const auto& p : contact) {
    const geometry::Vec2 d = (p - middle).head<2>();
    a += d * d.transpose();
    b += d * (p.z() - middle.z());
  }
  const double determinant = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  if (!(std::abs(determinant) > 1e-12)) return {};
  const geometry::Vec2 slope((a(1, 1) * b.x() - a(0, 1) * b.y()) / determinant,
                             (a(0, 0) * b.y() - a(1, 0) * b.x()) / determinant);
  const auto on_plane = [&](const geometry::Vec3& p) {
    return std::abs(p.z() - middle.z() - slope.dot((p - middle).head<2>())) < kOnPlane_m;
  };
  std::vector<std::uint8_t> touches(mesh.vertices.size()), seen(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) touches[i] = on_plane(mesh.vertices[i]) ? 1 : 0;
  double area = 0.0, unseen = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const geometry::Triangle& v = mesh.triangles[t];
    seen[t] = touches[v[0]] == 0 && touches[v[1]] == 0 && touches[v[2]] == 0 ? 1 : 0;
    const double own = mesh.area_vector(t).norm();
    area += own;
    if (seen[t] == 0) unseen += own;
  }
  if (!(area > 0.0) || std::abs(unseen / area - unseen_area_fraction) > kFractionTolerance) return {};
  return seen;
}

std::vector<report::RockView> read_rock_views(const ReportInputs& in, base::RunContext& ctx) {
  std::vector<report::RockView> views;
  const auto file = in.product("fragility", "rocks.json");
  if (file.empty()) return views;
  for (survey::Rock& rock : io::read_rocks(file).rocks) {
    ctx.check_stop();
    report::RockView view;
    const std::string id = std::to_string(rock.target.value);
    const auto mesh = in.product("surface", "rocks/" + id + ".ply");
    if (!rock.rejected && !mesh.empty()) {
      view.mesh = io::read_ply_mesh(mesh).mesh;
      std::vector<geometry::Vec3> contact = contact_points(in.product("surface", "rocks/" + id + ".json"));
      if (contact.empty()) contact = rock.tipping.contact;
      if (rock.cap == survey::CapModel::plane)
        view.facet_seen = seen_triangles(*view.mesh, contact, rock.unseen_area_fraction);
    }
    if (!in.product("surface", "rocks/" + id + ".glb").empty()) view.model_file = "rocks/" + id + ".glb";
    view.rock = std::move(rock);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace cairn::pipeline
