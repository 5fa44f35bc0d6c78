#include "surface/rock_body.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/number_text.hpp"
#include "geometry/kd_tree.hpp"
#include "geometry/winding_number.hpp"
#include "surface/alpha_wrap.hpp"
#include "surface/base_outline.hpp"
#include "surface/cap_patch.hpp"
#include "surface/implicit_surface.hpp"
#include "surface/mesh_checks.hpp"
#include "surface/mesh_repair.hpp"
#include "surface/top_surface.hpp"
#include "surface/triangulation.hpp"

namespace cairn::surface {
namespace {

using geometry::Triangle;
using geometry::Vec2;
using geometry::Vec3;

constexpr const char* kGiven = "given";

base::Reject reject(const char* reason, std::string message) {
  return {"", reason, std::move(message)};
}

// Edge of the square that one point has to itself in plan.
double plan_spacing(std::span<const Vec3> points) {
  std::vector<Vec2> plan;
  for (const auto& p : points) plan.push_back((p - points.front()).head<2>());
  const double area = geometry::signed_area(geometry::convex_hull(plan));
  return std::sqrt(area / static_cast<double>(points.size()));
}

FlaggedMesh top_body(const BodyInput& input, const BodyOptions& options) {
  return close_top_surface(input.points, input.ground, options.rim_edge_factor * plan_spacing(input.points),
                           options.clearance_m);
}

// Points that close the base: the lowest band of the rock dropped to the ground, and the ground inside it.
std::vector<Vec3> base_points(const BodyInput& input, double step) {
  double lowest = 1e300;
  for (const auto& p : input.points) lowest = std::min(lowest, p.z() - input.ground(p.head<2>()));
  std::vector<Vec3> base;
  std::vector<Vec2> foot;
  for (const auto& p : input.points) {
    const double up = input.ground(p.head<2>());
    if (p.z() - up > lowest + 2.0 * step) continue;
    for (double z = p.z() - step; z > up; z -= step) base.emplace_back(p.x(), p.y(), z);
    base.emplace_back(p.x(), p.y(), up);
    foot.push_back((p - input.points.front()).head<2>());
  }
  const Vec2 origin = input.points.front().head<2>();
  const auto triangles = trim_rim(foot, delaunay(foot), 8.0 * step);
  for (const Triangle& t : triangles) {
    const Vec2 &a = foot[t[0]], &b = foot[t[1]], &c = foot[t[2]];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int parts = std::max(1, static_cast<int>(std::ceil(longest / step)));
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; i + j <= parts; ++j) {
        const Vec2 q =
            origin + a + (b - a) * (static_cast<double>(i) / parts) + (c - a) * (static_cast<double>(j) / parts);
        base.emplace_back(q.x(), q.y(), input.ground(q));
      }
  }
  return base;
}

// The contact given, or the foot of the rock where it was seen; the surface through the points and on its caps.
FlaggedMesh implicit_body(const BodyInput& input, const BodyOptions& options, RockBody& body) {
  FlaggedMesh nothing;
  const double spacing = surface_spacing(input.points);
  if (!(spacing > 0.0)) return nothing;
  body.contact = input.contact;
  body.contact_assumed = pad_outlines(body.contact).empty();
  if (body.contact_assumed) body.contact = foot_outline(input.points, input.ground, spacing);
  const bool patch = options.cap == "patch" || (options.cap == "auto" && !body.contact_assumed);
  body.cap = patch ? survey::CapModel::patch : survey::CapModel::plane;
  std::vector<CapPatch> caps;
  for (const auto& ring : pad_outlines(body.contact))
    caps.emplace_back(ring, body.cap, Vec3::UnitZ(), 0.8 * ImplicitSettings{}.step_factor * spacing);
  double sigma = 0.0;
  for (const auto& vertex : body.contact) sigma = std::max(sigma, vertex.sigma_m);
  auto made = implicit_surface(input.points, caps, spacing, {});
  body.point_spacing = spacing;
  body.noise = made.noise;
  body.cap_height_sigma = cap_height_sigma(caps, spacing, sigma);
  if (made.stray_points > input.points.size() / 100) body.notes.emplace_back("stray_points");
  if (made.pieces_dropped > 0) body.notes.emplace_back("pieces_dropped");
  return std::move(made.surface);
}

// Every vertex moved inwards by `offset` along its area-weighted normal.
geometry::TriangleMesh deflated(const geometry::TriangleMesh& mesh, double offset) {
  std::vector<Vec3> normal(mesh.vertices.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 area = mesh.area_vector(t);
    for (const auto v : mesh.triangles[t]) normal[v] += area;
  }
  geometry::TriangleMesh result = mesh;
  for (std::size_t v = 0; v < normal.size(); ++v)
    if (normal[v].norm() > 0.0) result.vertices[v] -= offset * normal[v].normalized();
  return result;
}

// A wrap that went through a gap lines the inside of the rock too: its middle lies outside then.
// Gaps are unknown beforehand (random points leave far larger ones than a regular scan), so alpha grows until
// the middle is enclosed. Empty where that would take an alpha of a third of the rock.
std::optional<geometry::TriangleMesh> tight_wrap(const std::vector<Vec3>& all, double alpha, double offset) {
  const auto middle = geometry::mass_properties(convex_hull(all)).centre_of_mass;
  geometry::Box3 box;
  for (const auto& p : all) box.extend(p);
  constexpr double kGrowth = 1.5;
  for (; alpha <= box.size().maxCoeff() / 3.0; alpha *= kGrowth) {
    auto mesh = alpha_wrap(all, alpha, offset);
    if (geometry::winding_number(mesh, middle) > 0.5) return mesh;
  }
  return std::nullopt;
}

// Empty where the wrap leaks.
FlaggedMesh wrap_body(const BodyInput& input, const BodyOptions& options, std::vector<std::string>& notes) {
  const double alpha = options.wrap_alpha_factor * input.spacing;
  const double offset = options.wrap_offset_factor * input.spacing;
  std::vector<Vec3> all(input.points.begin(), input.points.end());
  const auto base = base_points(input, 0.5 * alpha);
  all.insert(all.end(), base.begin(), base.end());
  FlaggedMesh result;
  auto wrap = tight_wrap(all, alpha, offset);
  if (!wrap) return result;
  result.mesh = deflated(*wrap, offset);
  if (self_intersects(result.mesh)) {
    notes.emplace_back("offset_kept");
    result.mesh = std::move(*wrap);
  }
  const std::vector<Vec3> rock(input.points.begin(), input.points.end());
  const geometry::KdTree tree(rock);
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
    result.seen.push_back(std::sqrt(tree.nearest(result.mesh.centroid(t), 1).front().squared_distance) <= alpha ? 1
                                                                                                                : 0);
  return result;
}

std::variant<RockBody, base::Reject> finish(FlaggedMesh flagged, RockBody body) {
  body.mesh = std::move(flagged.mesh);
  body.seen = std::move(flagged.seen);
  body.mass = geometry::mass_properties(body.mesh);
  auto& quality = body.quality;
  quality.topology = geometry::topology(body.mesh);
  if (!quality.topology.closed())
    return reject("surface_not_closed", std::to_string(quality.topology.boundary_edges) + " open, " +
                                            std::to_string(quality.topology.inconsistent_edges) + " badly turned and " +
                                            std::to_string(quality.topology.non_manifold_edges) +
                                            " non-manifold edges; none allowed");
  quality.self_intersecting = self_intersects(body.mesh);
  if (quality.self_intersecting) {
    // Our own surfaces must not; a published mesh may brush itself and its signed sums still hold.
    if (body.method != kGiven) return reject("self_intersecting", "the surface passes through itself");
    body.notes.emplace_back("self_intersecting");
  }
  if (quality.topology.components != 1)
    return reject("several_pieces", std::to_string(quality.topology.components) + " separate shells; 1 allowed");
  if (!(body.mass.volume > 0.0)) return reject("flat_points", "the closed surface holds no volume");
  quality.watertight = !quality.self_intersecting;
  double seen = 0.0;
  for (std::size_t t = 0; t < body.mesh.triangles.size(); ++t)
    if (body.seen[t] != 0) seen += body.mesh.area_vector(t).norm();
  quality.unseen_area_fraction = std::clamp(1.0 - seen / body.mass.area, 0.0, 1.0);
  body.hull_volume = geometry::mass_properties(convex_hull(body.mesh.vertices)).volume;
  return body;
}

}  // namespace

void BodyOptions::visit(base::OptionVisitor& visitor) {
  visitor.choice("method", method, {"auto", "implicit", "top", "wrap"}, "how the surface is closed");
  visitor.choice("cap", cap, {"auto", "patch", "plane"}, "implicit: how the hidden base is closed");
  visitor.integer("dense-min-points", dense_min_points, 4, 100'000'000, "fewest points for implicit under auto");
  visitor.real("dense-min-flanks", dense_min_flanks, 0.0, 1.0,
               "least share of flanks, or of the contact, seen for implicit under auto");
  visitor.real("implicit-max-unseen", implicit_max_unseen, 0.0, 1.0,
               "auto: greatest unseen share of an implicit surface");
  visitor.real("wrap-alpha-factor", wrap_alpha_factor, 1.0, 100.0, "alpha in point spacings");
  visitor.real("wrap-offset-factor", wrap_offset_factor, 0.05, 10.0, "offset in point spacings");
  visitor.real("rim-edge-factor", rim_edge_factor, 1.0, 1000.0,
               "top: outline edges longer than this many plan spacings are followed inwards");
  visitor.real("clearance-m", clearance_m, 1e-6, 1.0, "top: least height of the surface above its cap");
}

namespace {

std::variant<RockBody, base::Reject> build_wrap(const BodyInput& input, const BodyOptions& options) {
  if (!(input.spacing > 0.0)) return reject("flat_points", "all points coincide");
  RockBody body;
  body.method = "wrap";
  body.cap = survey::CapModel::wrap;
  auto mesh = wrap_body(input, options, body.notes);
  if (mesh.mesh.triangles.empty())
    return reject("wrap_leaks", "the points leave gaps of more than a third of the rock");
  return finish(std::move(mesh), std::move(body));
}

std::variant<RockBody, base::Reject> build_top(const BodyInput& input, const BodyOptions& options,
                                               std::vector<std::string> notes) {
  RockBody body;
  body.method = "top";
  body.notes = std::move(notes);
  auto mesh = top_body(input, options);
  if (mesh.mesh.triangles.empty()) return reject("flat_points", "the points span no area in plan");
  return finish(std::move(mesh), std::move(body));
}

std::variant<RockBody, base::Reject> build_implicit(const BodyInput& input, const BodyOptions& options) {
  RockBody body;
  body.method = "implicit";
  auto mesh = implicit_body(input, options, body);
  if (mesh.mesh.triangles.empty()) return reject("implicit_unsupported", "the points enclose nothing");
  return finish(std::move(mesh), std::move(body));
}

}  // namespace

std::variant<RockBody, base::Reject> build_body(const BodyInput& input, const BodyOptions& options) {
  if (input.points.size() < 4)
    return reject("too_few_points", std::to_string(input.points.size()) + " points, 4 needed");
  if (!(plan_spacing(input.points) > 0.0)) return reject("flat_points", "the points lie on one line in plan");
  if (options.method == "wrap") return build_wrap(input, options);
  std::size_t observed = 0;
  for (const auto& vertex : input.contact)
    if (vertex.observed) ++observed;
  const double contact_seen =
      input.contact.empty() ? 0.0 : static_cast<double>(observed) / static_cast<double>(input.contact.size());
  const bool dense = input.points.size() >= static_cast<std::size_t>(options.dense_min_points) &&
                     std::max(input.flanks_seen_share, contact_seen) >= options.dense_min_flanks;
  if (options.method == "top" || (options.method == "auto" && !dense)) return build_top(input, options, {});
  auto built = build_implicit(input, options);
  if (options.method == "implicit") return built;
  if (const auto* body = std::get_if<RockBody>(&built);
      body != nullptr && body->quality.unseen_area_fraction <= options.implicit_max_unseen)
    return built;
  return build_top(input, options, {"implicit_unsupported"});
}

std::variant<RockBody, base::Reject> body_of(const geometry::TriangleMesh& mesh) {
  auto repaired = repair(mesh);
  if (repaired.mesh.triangles.empty()) return reject("flat_points", "the mesh has no triangle with area");
  constexpr double kMostMade = 0.5;
  if (repaired.closed_share > kMostMade)
    return reject("surface_not_closed", base::to_fixed(100.0 * repaired.closed_share, 0) +
                                            " % of the closed surface would be made up; 50 % allowed");
  // An open base is how rocks are scanned; what lies behind a large hole in a flank nobody knows.
  constexpr double kMostHoles = 0.05;
  if (repaired.hole_share > kMostHoles)
    return reject("surface_not_closed", "holes beside the base take " + base::to_fixed(100.0 * repaired.hole_share, 0) +
                                            " % of the surface; 5 % allowed");
  RockBody body;
  body.method = kGiven;
  body.cap = repaired.base.empty() ? survey::CapModel::none : survey::CapModel::patch;
  body.contact = std::move(repaired.base);
  body.cap_height_sigma = repaired.base_roughness;
  body.notes = std::move(repaired.notes);
  FlaggedMesh flagged;
  flagged.mesh = std::move(repaired.mesh);
  for (const auto made : repaired.made) flagged.seen.push_back(made != 0 ? 0 : 1);
  return finish(std::move(flagged), std::move(body));
}

}  // namespace cairn::surface
