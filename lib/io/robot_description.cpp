#include "io/robot_description.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/obj.hpp"

namespace cairn::io {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr double kSameInertia = 0.01;                            // relative, of a principal moment
constexpr double kLeastDensity = 1500.0, kMostDensity = 3500.0;  // kg/m^3: tuff to peridotite
constexpr double kLeastBoxShare = 0.2, kMostBoxShare = 1.5;      // of the solid box's tr(I)/m

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '&') out += "&amp;";
    else if (c == '"') out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20) out += c;
  }
  return out;
}

std::string triple(const Vec3& v) {
  return base::to_text(v.x()) + " " + base::to_text(v.y()) + " " + base::to_text(v.z());
}

Vec3 principal(const Mat3& inertia) {
  return Eigen::SelfAdjointEigenSolver<Mat3>(inertia).eigenvalues();
}

const char* const kAxes = "xyz";

// inertia entries ixx .. izz in the order of both formats, each by `entry`.
template <typename Entry>
std::string inertia_entries(const Mat3& i, Entry entry) {
  std::string text;
  for (int r = 0; r < 3; ++r)
    for (int c = r; c < 3; ++c) text += entry(std::string("i") + kAxes[r] + kAxes[c], base::to_text(i(r, c)));
  return text;
}

std::string urdf_text(const RobotModelOptions& o, double mass_kg, const Mat3& inertia) {
  const std::string geometry =
      "<origin xyz=\"0 0 0\" rpy=\"0 0 0\"/><geometry><mesh filename=\"mesh.obj\" scale=\"1 1 1\"/></geometry>";
  return "<?xml version=\"1.0\"?>\n<robot name=\"" + xml_text(o.name) + "\">\n  <link name=\"rock\">\n    <contact>\n" +
         "      <lateral_friction value=\"" + base::to_text(o.friction) + "\"/>\n      <restitution value=\"" +
         base::to_text(o.restitution) + "\"/>\n    </contact>\n    <inertial>\n" +
         "      <origin xyz=\"0 0 0\" rpy=\"0 0 0\"/>\n      <mass value=\"" + base::to_text(mass_kg) +
         "\"/>\n      <inertia" +
         inertia_entries(inertia,
                         [](const std::string& n, const std::string& v) { return " " + n + "=\"" + v + "\""; }) +
         "/>\n    </inertial>\n    <visual>" + geometry + "</visual>\n    <collision>" + geometry +
         "</collision>\n  </link>\n</robot>\n";
}

std::string sdf_text(const RobotModelOptions& o, double mass_kg, const Mat3& inertia, const Vec3& centre) {
  const std::string geometry = "<geometry><mesh><uri>mesh.obj</uri><scale>1 1 1</scale></mesh></geometry>";
  return "<?xml version=\"1.0\"?>\n<sdf version=\"1.7\">\n  <model name=\"" + xml_text(o.name) + "\">\n    <pose>" +
         triple(centre) +
         " 0 0 0</pose>\n    <link name=\"rock\">\n      <inertial>\n        <pose>0 0 0 0 0 0</pose>\n" +
         "        <mass>" + base::to_text(mass_kg) + "</mass>\n        <inertia>\n" +
         inertia_entries(inertia, [](const std::string& n,
                                     const std::string& v) { return "          <" + n + ">" + v + "</" + n + ">\n"; }) +
         "        </inertia>\n      </inertial>\n      <visual name=\"visual\">" + geometry +
         "</visual>\n      <collision name=\"collision\">" + geometry + "<surface><bounce><restitution_coefficient>" +
         base::to_text(o.restitution) + "</restitution_coefficient></bounce><friction><ode><mu>" +
         base::to_text(o.friction) + "</mu><mu2>" + base::to_text(o.friction) +
         "</mu2></ode></friction></surface></collision>\n    </link>\n  </model>\n</sdf>\n";
}

}  // namespace

std::vector<base::Reject> link_findings(const RobotLink& link, const geometry::TriangleMesh& mesh) {
  std::vector<base::Reject> findings;
  const auto find = [&](const char* reason, const std::string& message) {
    findings.push_back({"link " + link.name, reason, message});
  };
  const auto mass = geometry::mass_properties(mesh);
  const Vec3 own = principal(link.inertia_kg_m2), true_unit = principal(mass.inertia_per_density) / mass.volume;
  const double asymmetry = (link.inertia_kg_m2 - link.inertia_kg_m2.transpose()).norm();
  if (!(own[0] > 0.0) || own[2] > (own[0] + own[1]) * (1.0 + 1e-9) || asymmetry > 1e-9 * own.norm())
    find("inertia_not_a_body", "principal moments " + triple(own) + " kg m2");
  const double box = mesh.bounds().size().squaredNorm() / 6.0;
  const double spread = link.inertia_kg_m2.trace() / link.mass_kg;
  if (!(spread >= kLeastBoxShare * box && spread <= kMostBoxShare * box))
    find("inertia_not_the_box", "tr(I)/m is " + base::to_text(spread) + " m2, a solid box of the mesh's size has " +
                                    base::to_text(box) + " m2");
  const Vec3 expected = link.mass_kg * true_unit;
  if (!((own - expected).cwiseAbs().maxCoeff() <= kSameInertia * expected.maxCoeff()))
    find("inertia_not_the_mesh", "principal moments " + triple(own) + " kg m2, the mesh has " + triple(expected) +
                                     " kg m2 at " + base::to_text(link.mass_kg) + " kg");
  const double density = link.mass_kg / mass.volume;
  if (!(density >= kLeastDensity && density <= kMostDensity))
    find("density_not_a_rock", base::to_text(density) + " kg/m3, rocks have " + base::to_text(kLeastDensity) + " to " +
                                   base::to_text(kMostDensity) + " kg/m3");
  return findings;
}

void write_robot_model(const std::filesystem::path& folder, const geometry::TriangleMesh& mesh,
                       const geometry::MassProperties& mass, const RobotModelOptions& options) {
  if (!(mass.volume > 0.0) || !mass.inertia_per_density.allFinite() || !(options.density_kg_m3 > 0.0))
    throw base::Error(base::ErrorCode::invalid_argument, "no body to describe")
        .found(base::to_text(mass.volume) + " m3, " + base::to_text(options.density_kg_m3) + " kg/m3")
        .allowed("a closed outward mesh and a positive density");
  geometry::TriangleMesh centred = mesh;
  for (auto& v : centred.vertices) v -= mass.centre_of_mass;
  const double mass_kg = options.density_kg_m3 * mass.volume;
  const Mat3 inertia = options.density_kg_m3 * mass.inertia_per_density;
  ObjWriteOptions obj;
  obj.comments = {"Origin: the centre of mass, at " + triple(mass.centre_of_mass) + " m of the surveyed mesh's frame",
                  "Metres, z up"};
  write_obj(folder / "mesh.obj", centred, obj);
  base::write_file(folder / "model.urdf", urdf_text(options, mass_kg, inertia));
  base::write_file(folder / "model.sdf", sdf_text(options, mass_kg, inertia, mass.centre_of_mass));
  base::write_file(folder / "model.config",
                   "<?xml version=\"1.0\"?>\n<model>\n  <name>" + xml_text(options.name) +
                       "</name>\n  <version>1.0</version>\n  <sdf version=\"1.7\">model.sdf</sdf>\n" +
                       "  <description>Rock; density " + base::to_text(options.density_kg_m3) +
                       " kg/m3</description>\n</model>\n");
}

}  // namespace cairn::io
