// URDF and SDF links. pugixml expands no entities and reads no DTD.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <pugixml.hpp>
#include <sstream>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/robot_description.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Mat3;
using geometry::RigidTransform;
using geometry::Vec3;

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{16} << 20U;

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path.string()) {
    std::error_code code;
    const auto bytes = std::filesystem::file_size(path, code);
    if (!code && bytes > kMaxBytes)
      throw Error(ErrorCode::invalid_input, "the description is too large")
          .file(file_)
          .found(std::to_string(bytes) + " bytes");
    const FileBytes content(path);
    const auto result = document_.load_buffer(content.text().data(), content.text().size(), pugi::parse_default);
    if (!result) throw at(result.offset, result.description());
  }

  RobotDescription read() const {
    const pugi::xml_node root = document_.document_element();
    RobotDescription d;
    const bool urdf = std::strcmp(root.name(), "robot") == 0;
    if (!urdf && std::strcmp(root.name(), "sdf") != 0)
      throw error(root, "neither URDF nor SDF").found(std::string("<") + root.name() + ">").allowed("<robot> or <sdf>");
    pugi::xml_node model = root;
    if (!urdf) {
      model = root.child("model");
      if (!model) model = root.child("world").child("model");
      if (!model) throw error(root, "no <model>");
    }
    d.format = urdf ? "urdf" : "sdf";
    d.name = model.attribute("name").value();
    for (const pugi::xml_node node : model.children("link")) d.links.push_back(urdf ? urdf_link(node) : sdf_link(node));
    if (d.links.empty()) throw error(model, "no <link>");
    return d;
  }

 private:
  [[nodiscard]] Error at(std::ptrdiff_t offset, const std::string& message) const {
    return Error(ErrorCode::invalid_input, message)
        .file(file_)
        .record("byte " + std::to_string(std::max<std::ptrdiff_t>(offset, 0)));
  }
  [[nodiscard]] Error error(const pugi::xml_node& node, const std::string& message) const {
    return at(node.offset_debug(), message);
  }
  [[nodiscard]] double number(const pugi::xml_node& node, const char* what, const char* text) const {
    const auto value = base::parse_real(text);
    if (!value || !std::isfinite(*value))
      throw error(node, std::string(what) + " is not a number").found("'" + std::string(text).substr(0, 60) + "'");
    return *value;
  }
  // `count` numbers; all zero where the text is empty.
  [[nodiscard]] std::array<double, 6> numbers(const pugi::xml_node& node, const char* what, const char* text,
                                              std::size_t count) const {
    std::array<double, 6> values{};
    std::istringstream words(text);
    std::string word;
    std::size_t n = 0;
    for (; words >> word; ++n)
      if (n < count) values.at(n) = number(node, what, word.c_str());
    if (n != 0 && n != count)
      throw error(node, std::string(what) + " has not " + std::to_string(count) + " numbers").found(std::to_string(n));
    return values;
  }
  [[nodiscard]] static RigidTransform pose(const Vec3& xyz, const Vec3& rpy) {
    RigidTransform t;
    t.rotation = (Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) *
                  Eigen::AngleAxisd(rpy.x(), Vec3::UnitX()))
                     .toRotationMatrix();
    t.translation = xyz;
    return t;
  }
  static void note_mesh(RobotLink& link, const std::string& name) {
    if (!name.empty() && std::find(link.meshes.begin(), link.meshes.end(), name) == link.meshes.end())
      link.meshes.push_back(name);
  }
  [[nodiscard]] pugi::xml_node inertial_of(const pugi::xml_node& link) const {
    const pugi::xml_node inertial = link.child("inertial");
    if (!inertial || !inertial.child("mass") || !inertial.child("inertia"))
      throw error(link, "a link without mass and inertia").found(link.attribute("name").value());
    return inertial;
  }
  template <typename Entry>
  [[nodiscard]] Mat3 inertia(Entry entry) const {
    const char* const names = "xyz";
    Mat3 m;
    for (int r = 0; r < 3; ++r)
      for (int c = r; c < 3; ++c) m(r, c) = m(c, r) = entry(std::string("i") + names[r] + names[c]);
    return m;
  }

  [[nodiscard]] RobotLink urdf_link(const pugi::xml_node& node) const {
    RobotLink link;
    link.name = node.attribute("name").value();
    const pugi::xml_node inertial = inertial_of(node), tensor = inertial.child("inertia"),
                         origin = inertial.child("origin");
    link.mass_kg = number(inertial, "mass", inertial.child("mass").attribute("value").value());
    const auto xyz = numbers(inertial, "xyz", origin.attribute("xyz").value(), 3);
    const auto rpy = numbers(inertial, "rpy", origin.attribute("rpy").value(), 3);
    link.T_link_inertial = pose({xyz[0], xyz[1], xyz[2]}, {rpy[0], rpy[1], rpy[2]});
    link.inertia_kg_m2 =
        inertia([&](const std::string& n) { return number(tensor, n.c_str(), tensor.attribute(n.c_str()).value()); });
    for (const char* part : {"visual", "collision"})
      for (const pugi::xml_node shape : node.children(part))
        note_mesh(link, shape.child("geometry").child("mesh").attribute("filename").value());
    return link;
  }
  [[nodiscard]] RobotLink sdf_link(const pugi::xml_node& node) const {
    RobotLink link;
    link.name = node.attribute("name").value();
    const pugi::xml_node inertial = inertial_of(node), tensor = inertial.child("inertia");
    link.mass_kg = number(inertial, "mass", inertial.child_value("mass"));
    const auto p = numbers(inertial, "pose", inertial.child_value("pose"), 6);
    link.T_link_inertial = pose({p[0], p[1], p[2]}, {p[3], p[4], p[5]});
    link.inertia_kg_m2 =
        inertia([&](const std::string& n) { return number(tensor, n.c_str(), tensor.child_value(n.c_str())); });
    for (const char* part : {"visual", "collision"})
      for (const pugi::xml_node shape : node.children(part))
        note_mesh(link, shape.child("geometry").child("mesh").child_value("uri"));
    return link;
  }

  std::string file_;
  pugi::xml_document document_;
};

}  // namespace

RobotDescription read_robot_description(const std::filesystem::path& path) {
  return Reader(path).read();
}

}  // namespace cairn::io
