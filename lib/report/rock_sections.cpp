// Sections and side views of one rock.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "report/base64.hpp"
#include "report/rock_figures.hpp"
#include "report/rock_view.hpp"
#include "report/svg_text.hpp"

namespace cairn::report {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr const char* kRock = "fill=\"#d9cfc2\" fill-rule=\"evenodd\" stroke=\"#5b4a3a\" stroke-width=\"1.2\"";
constexpr const char* kPlumb = "stroke=\"#2b4c7e\" stroke-width=\"1.2\" stroke-dasharray=\"5 3\"";
constexpr const char* kArm = "stroke=\"#8b1a1a\" stroke-width=\"1.5\"";
constexpr const char* kBase = "stroke=\"#c0622f\" stroke-width=\"3\"";

Vec3 along(double azimuth_deg) {
  const double a = base::deg_to_rad(azimuth_deg);
  return {std::sin(a), std::cos(a), 0.0};
}

double turned(double azimuth_deg, double by) {
  const double a = std::fmod(azimuth_deg + by, 360.0);
  return a < 0.0 ? a + 360.0 : a;
}

RockingPoint point_at(double s, double z, const Vec3& centre) {
  const double height = centre.z() - z;
  return {s, z, std::atan2(std::abs(s), height), std::hypot(s, height)};
}

void require_measurable(const survey::Rock& rock) {
  if (!rock.mass || !rock.tipping.critical || rock.tipping.contact.size() < 3)
    throw base::Error(base::ErrorCode::failed_precondition, "the rock has no tipping angle to draw");
}

// Picture of a plane of s (right) and z (up).
struct Frame {
  Vec2 origin = Vec2::Zero();  // picture of (0, 0), px
  double scale = 100.0;        // px / m
  [[nodiscard]] Vec2 operator()(double s, double z) const { return {origin.x() + scale * s, origin.y() - scale * z}; }
};

std::string angle_text(double alpha_rad, double r_m) {
  return base::to_fixed(base::rad_to_deg(alpha_rad), 1) + "\u00b0, R " + base::to_fixed(r_m, 2) + " m";
}

// Centre, plumb line, both arms with their angles; s, z relative to the centre of mass.
std::string balance_svg(const Frame& frame, const RockingPair& pair, double centre_z) {
  const Vec2 com = frame(0.0, 0.0);
  const double base = std::min(pair.towards.z_m, pair.against.z_m) - centre_z;
  std::string out = svg::line(com, frame(0.0, base), kPlumb);
  for (const auto* p : {&pair.towards, &pair.against}) {
    const Vec2 q = frame(p->s_m, p->z_m - centre_z);
    out += svg::line(com, q, kArm) + svg::dot(q, 3.5, "fill=\"#8b1a1a\"");
  }
  out += svg::line(frame(pair.against.s_m, pair.against.z_m - centre_z),
                   frame(pair.towards.s_m, pair.towards.z_m - centre_z), kBase);
  out += svg::dot(com, 5.0, "fill=\"#fff\" stroke=\"#2b4c7e\" stroke-width=\"2.5\"");
  return out;
}

}  // namespace

bool rocking_pair(const std::vector<Vec3>& support, const Vec3& centre, double azimuth_deg, RockingPair& pair) {
  const Vec3 u = along(azimuth_deg);
  const Vec3 across(u.y(), -u.x(), 0.0);
  bool towards = false, against = false;
  for (std::size_t i = 0; i < support.size(); ++i) {
    const Vec3 a = support[i] - centre, b = support[(i + 1) % support.size()] - centre;
    const double ta = across.dot(a), tb = across.dot(b);
    if ((ta < 0.0) == (tb < 0.0)) continue;
    const double f = ta / (ta - tb);
    const Vec3 p = a + f * (b - a);
    const double s = u.dot(p);
    (s > 0.0 ? pair.towards : pair.against) = point_at(s, centre.z() + p.z(), centre);
    (s > 0.0 ? towards : against) = true;
  }
  return towards && against;
}

std::vector<std::vector<Vec2>> vertical_section(const geometry::TriangleMesh& mesh, const Vec3& through,
                                                double azimuth_deg) {
  const Vec3 u = along(azimuth_deg);
  const Vec3 across(u.y(), -u.x(), 0.0);
  std::vector<double> side(mesh.vertices.size());
  for (std::size_t i = 0; i < side.size(); ++i) side[i] = across.dot(mesh.vertices[i] - through);
  using Key = std::pair<std::uint32_t, std::uint32_t>;
  // The outline passes from one cut edge of the mesh to the next; a closed mesh gives each one follower.
  std::map<Key, Key> next;
  for (const auto& t : mesh.triangles) {
    std::vector<std::pair<Key, bool>> cuts;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if ((side[a] < 0.0) == (side[b] < 0.0)) continue;
      cuts.push_back({{std::min(a, b), std::max(a, b)}, side[a] < 0.0});
    }
    if (cuts.size() != 2) continue;
    const bool forward = cuts[0].second;
    next[cuts[forward ? 0 : 1].first] = cuts[forward ? 1 : 0].first;
  }
  const auto point = [&](const Key& key) {
    const Vec3 &a = mesh.vertices[key.first], &b = mesh.vertices[key.second];
    const double f = side[key.first] / (side[key.first] - side[key.second]);
    const Vec3 p = a + f * (b - a);
    return Vec2(u.dot(p - through), p.z());
  };
  std::vector<std::vector<Vec2>> outlines;
  while (!next.empty()) {
    std::vector<Vec2> ring;
    Key key = next.begin()->first;
    for (auto it = next.find(key); it != next.end(); it = next.find(key)) {
      ring.push_back(point(key));
      key = it->second;
      next.erase(it);
    }
    if (ring.size() >= 3) outlines.push_back(std::move(ring));
  }
  return outlines;
}

std::string sections_svg(const survey::Rock& rock, const geometry::TriangleMesh& mesh, std::string_view title) {
  require_measurable(rock);
  constexpr double kPanel = 360.0, kDraw = 300.0, kTop = 70.0;
  const Vec3 centre = rock.mass->centre_of_mass;
  const double critical = rock.tipping.critical->azimuth_deg;
  const auto box = mesh.bounds();
  const double scale = kDraw / std::max({std::hypot(box.size().x(), box.size().y()), box.size().z(), 1e-6});
  const double floor = kTop + scale * box.size().z();
  std::string out = svg::open(2 * kPanel + 20, floor + 150);
  out += svg::text(kPanel + 10, 24, "middle", title, 16);
  for (int k = 0; k < 2; ++k) {
    const double azimuth = turned(critical, 90.0 * k), middle = 10 + kPanel * (0.5 + k);
    const Frame frame{{middle, floor - scale * (centre.z() - box.min.z())}, scale};
    out += svg::text(middle, 50, "middle",
                     (k == 0 ? "Along the critical direction, right = " : "Across it, right = ") +
                         base::to_fixed(azimuth, 0) + "\u00b0 from north",
                     13);
    std::string path;
    for (const auto& ring : vertical_section(mesh, centre, azimuth)) {
      for (std::size_t i = 0; i < ring.size(); ++i)
        path += (i == 0 ? "M" : " L") + svg::at(frame(ring[i].x(), ring[i].y() - centre.z()));
      path += " Z ";
    }
    out += "<path d=\"" + path + "\" " + kRock + "/>\n";
    RockingPair pair;
    if (rocking_pair(rock.tipping.contact, centre, azimuth, pair)) {
      out += balance_svg(frame, pair, centre.z());
      const double below = floor + 24;
      out += svg::text(middle + 8, below, "start", "\u03b1 " + angle_text(pair.towards.alpha_rad, pair.towards.r_m), 12,
                       "#8b1a1a");
      out += svg::text(middle - 8, below, "end", "\u03b1 " + angle_text(pair.against.alpha_rad, pair.against.r_m), 12,
                       "#8b1a1a");
    } else {
      out += svg::text(middle, floor + 24, "middle", "this plane leaves the contact on one side only", 12);
    }
  }
  out += svg::scale_bar(20, floor + 60, scale, 120);
  out +=
      svg::text(2 * kPanel, floor + 64, "end",
                "\u25cb centre of mass, \u25cf rocking points of the section; heights true, local up is vertical", 11);
  out +=
      svg::text(20, floor + 104, "start",
                "least angle over all edges " + base::to_fixed(base::rad_to_deg(rock.tipping.critical->alpha_rad), 1) +
                    "\u00b0, toppling towards " + base::to_fixed(critical, 0) + "\u00b0",
                12);
  std::string grade = "grade " + std::string(survey::name_of(rock.tipping.grade));
  for (const auto& reason : rock.tipping.reasons) grade += ", " + reason;
  out += svg::text(20, floor + 126, "start", grade, 11);
  return out + "</svg>\n";
}

std::string side_views_svg(const survey::Rock& rock, const geometry::TriangleMesh& mesh, std::string_view title,
                           std::size_t view_px) {
  require_measurable(rock);
  const Vec3 centre = rock.mass->centre_of_mass;
  const double cell = static_cast<double>(view_px) + 60.0;
  std::string out = svg::open(4 * cell, cell + 100);
  out += svg::text(2 * cell, 24, "middle", title, 16);
  double scale = 1e300;
  std::vector<ShadedView> pictures;
  std::vector<SideView> views;
  for (int k = 0; k < 4; ++k) {
    views.emplace_back(turned(rock.tipping.critical->azimuth_deg, 90.0 * k - 90.0));
    pictures.push_back(shaded_view(mesh, views.back(), view_px));
    scale = std::min(scale, 1.0 / pictures.back().pixel_m);
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& picture = pictures[k];
    const double left = cell * (static_cast<double>(k) + 0.5);
    const double width = static_cast<double>(picture.image.width) * picture.pixel_m * scale,
                 height = static_cast<double>(picture.image.height) * picture.pixel_m * scale;
    const double x = left - 0.5 * width, floor = 60 + static_cast<double>(view_px);
    out += svg::text(left, 48, "middle", "looking towards " + base::to_fixed(views[k].azimuth_deg, 0) + "\u00b0", 13);
    out += "<image x=\"" + svg::px(x) + "\" y=\"" + svg::px(floor - height) + "\" width=\"" + svg::px(width) +
           "\" height=\"" + svg::px(height) + "\" href=\"data:image/png;base64," + base64(encode_png(picture.image)) +
           "\"/>\n";
    // The contact's outermost points as a photograph from here would show them.
    RockingPair pair;
    bool first = true;
    for (const auto& q : rock.tipping.contact) {
      const double s = views[k].right.dot(q - centre);
      if (first || s > pair.towards.s_m) pair.towards = point_at(s, q.z(), centre);
      if (first || s < pair.against.s_m) pair.against = point_at(s, q.z(), centre);
      first = false;
    }
    const Vec2 com = views[k](centre) - picture.low;
    const Frame frame{{x + scale * com.x(), floor - scale * com.y()}, scale};
    out += balance_svg(frame, pair, centre.z());
    out += svg::text(left - 6, floor + 22, "end", angle_text(pair.against.alpha_rad, pair.against.r_m), 12, "#8b1a1a");
    out +=
        svg::text(left + 6, floor + 22, "start", angle_text(pair.towards.alpha_rad, pair.towards.r_m), 12, "#8b1a1a");
  }
  out += svg::scale_bar(20, cell + 60, scale, 120);
  out += svg::text(4 * cell - 20, cell + 64, "end",
                   "angles as a photograph from that side would give them: each holds for its own view only; toppling "
                   "towards the right in the first view is critical",
                   11);
  return out + "</svg>\n";
}

}  // namespace cairn::report
