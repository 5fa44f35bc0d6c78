#include "io/obj.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

#include "base/number_text.hpp"
#include "io/bytes.hpp"

namespace cairn::io {
namespace {

constexpr std::size_t kMaxVertices = std::numeric_limits<std::uint32_t>::max() - 1;

std::string shown(std::string_view word) {
  return "'" + printable_text(std::as_bytes(std::span(word.substr(0, 40)))) + "'";
}

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& file, bool faces) : in_(text, file), file_(file), faces_(faces) {
    data_.facts.format = "OBJ";
  }

  MeshData parse() {
    std::string joined;
    while (auto next = in_.next_line()) {
      std::string_view line = *next;
      if (line.ends_with('\\')) {
        // A statement continued on the next line.
        joined.clear();
        for (;;) {
          const bool more = line.ends_with('\\');
          joined += more ? line.substr(0, line.size() - 1) : line;
          joined += ' ';
          if (!more || !(next = in_.next_line())) break;
          line = *next;
        }
        line = joined;
      }
      statement(line);
    }
    finish();
    return std::move(data_);
  }

 private:
  void statement(std::string_view line) {
    const std::string_view keyword = take_word(line);
    if (keyword.empty()) return;
    if (keyword == "v") {
      vertex(line);
    } else if (keyword == "f") {
      ++data_.facts.declared_faces;
      if (faces_) face(line);
    } else if (keyword == "p" || keyword == "l") {
      ++elements_;
    } else if (keyword == "curv" || keyword == "surf" || keyword == "curv2") {
      ++surfaces_;
    } else if (keyword == "mtllib") {
      material_ = true;
    } else if (keyword.starts_with('#')) {
      if (data_.facts.comments.size() < 16) {
        const std::string comment = printable_text(std::as_bytes(std::span(base::trim(line))));
        if (!comment.empty()) data_.facts.comments.push_back(comment);
      }
    } else if (std::ranges::any_of(keyword, [](char c) { return c < ' ' || c > '~'; })) {
      throw in_.error("not an OBJ file: a keyword is not text").found(shown(keyword));
    }
  }

  void vertex(std::string_view line) {
    std::array<double, 7> numbers{};
    std::size_t n = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (word.starts_with('#')) break;
      const auto number = parse_number(word);
      if (!number) throw in_.error("a vertex coordinate is not a number").found(shown(word));
      if (n == numbers.size()) throw in_.error("a vertex with more than 7 numbers");
      numbers[n++] = *number;
    }
    if (n < 3)
      throw in_.error("a vertex with fewer than 3 coordinates").found(std::to_string(n)).allowed("3, 4, 6 or 7");
    if (data_.mesh.vertices.size() >= kMaxVertices) throw in_.error("too many vertices for a mesh");
    data_.mesh.vertices.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (n < 6) return;
    const std::size_t first = n == 6 ? 3 : 4;
    if (colours_.size() + 1 != data_.mesh.vertices.size()) {
      colours_complete_ = false;
      return;
    }
    colours_.push_back({static_cast<float>(numbers[first]), static_cast<float>(numbers[first + 1]),
                        static_cast<float>(numbers[first + 2])});
  }

  // The vertex index of "7", "7/1", "7//3", "7/1/3"; negative counts back from the last vertex.
  std::uint32_t corner(std::string_view word) {
    std::int64_t index = 0;
    const std::size_t slash = std::min(word.find('/'), word.size());
    const auto [end, code] = std::from_chars(word.data(), word.data() + slash, index);
    if (code != std::errc{} || end != word.data() + slash)
      throw in_.error("a face corner is not a vertex number").found(shown(word));
    const auto count = static_cast<std::int64_t>(data_.mesh.vertices.size());
    const std::int64_t zero_based = index < 0 ? count + index : index - 1;
    if (index == 0 || zero_based < 0 || zero_based >= static_cast<std::int64_t>(kMaxVertices))
      throw in_.error("a face names a vertex that does not exist")
          .found(std::to_string(index))
          .allowed("1 to the number of vertices, or -1 down to its negative");
    // Some writers put faces before their vertices: proved at the end.
    if (zero_based > highest_) {
      highest_ = zero_based;
      highest_line_ = in_.line();
    }
    return static_cast<std::uint32_t>(zero_based);
  }

  void face(std::string_view line) {
    geometry::Triangle t{};
    std::size_t corners = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (word.starts_with('#')) break;
      const std::uint32_t v = corner(word);
      if (corners == 0) {
        t[0] = v;
      } else {
        t[1] = t[2];
        t[2] = v;
        if (corners >= 2) data_.mesh.triangles.push_back(t);
      }
      ++corners;
    }
    if (corners < 3) ++data_.facts.dropped_faces;
  }

  void finish() {
    auto& facts = data_.facts;
    facts.declared_points = data_.mesh.vertices.size();
    if (highest_ >= static_cast<std::int64_t>(data_.mesh.vertices.size()))
      throw bad_line(file_, highest_line_, "a face names a vertex that does not exist")
          .found(std::to_string(highest_ + 1))
          .allowed("1 to " + std::to_string(data_.mesh.vertices.size()))
          .hint("The file is truncated or damaged");
    if (data_.mesh.vertices.empty() && facts.declared_faces == 0)
      throw bad_line(file_, std::max<std::uint64_t>(in_.line(), 1), "not an OBJ file, or an empty one")
          .allowed("lines that start with 'v'");
    if (facts.dropped_faces > 0)
      facts.warnings.push_back(std::to_string(facts.dropped_faces) + " faces with fewer than 3 corners were dropped");
    if (elements_ > 0) facts.warnings.push_back(std::to_string(elements_) + " point and line elements are not read");
    if (surfaces_ > 0) facts.warnings.push_back(std::to_string(surfaces_) + " free-form elements are not read");
    if (material_) facts.warnings.emplace_back("the material library it names was not opened");
    take_colours();
  }

  void take_colours() {
    if (colours_.empty()) return;
    if (!colours_complete_ || colours_.size() != data_.mesh.vertices.size()) {
      data_.facts.warnings.emplace_back("only some vertices have colours: none are kept");
      return;
    }
    // By habit 0..1; some writers put 0..255.
    float largest = 0.0F;
    for (const auto& c : colours_)
      for (const float v : c) largest = std::max(largest, v);
    const float scale = largest > 1.0F ? 1.0F : 255.0F;
    for (const auto& c : colours_) {
      std::array<std::uint8_t, 3> bytes{};
      for (std::size_t k = 0; k < 3; ++k) {
        const float v = std::isfinite(c[k]) ? c[k] * scale : 0.0F;
        bytes[k] = static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0F, 255.0F)));
      }
      data_.mesh.colours.push_back(bytes);
    }
  }

  TextReader in_;
  const std::string& file_;
  bool faces_;
  MeshData data_;
  std::vector<std::array<float, 3>> colours_;
  bool colours_complete_ = true, material_ = false;
  std::int64_t highest_ = -1;
  std::uint64_t highest_line_ = 0;
  std::uint64_t elements_ = 0, surfaces_ = 0;
};

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r' || c == '\\') c = ' ';
  return text;
}

}  // namespace

MeshData read_obj_mesh(const std::filesystem::path& path) {
  const FileBytes file(path);
  MeshData data = ObjParser(file.text(), file.name(), true).parse();
  drop_non_finite(data);
  return data;
}

CloudData read_obj_cloud(const std::filesystem::path& path) {
  const FileBytes file(path);
  MeshData mesh = ObjParser(file.text(), file.name(), false).parse();
  CloudData data;
  data.facts = std::move(mesh.facts);
  data.cloud.positions = std::move(mesh.mesh.vertices);
  for (const auto& c : mesh.mesh.colours)
    data.cloud.colours.push_back({static_cast<std::uint16_t>(c[0] * 257), static_cast<std::uint16_t>(c[1] * 257),
                                  static_cast<std::uint16_t>(c[2] * 257)});
  drop_non_finite(data);
  return data;
}

void write_obj(const std::filesystem::path& path, const geometry::TriangleMesh& mesh, const ObjWriteOptions& options) {
  const auto bad = [&](std::string message) {
    return base::Error(base::ErrorCode::invalid_argument, std::move(message)).file(path.string());
  };
  const bool coloured = !mesh.colours.empty();
  if (coloured && mesh.colours.size() != mesh.vertices.size())
    throw bad("colours and vertices of the mesh differ in number");
  OutputFile out(path);
  for (const auto& comment : options.comments) out.write("# " + one_line(comment) + "\n");
  std::string line;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& p = mesh.vertices[i];
    if (!p.allFinite()) throw bad("a coordinate is not finite").record("vertex " + std::to_string(i));
    line = "v";
    for (int axis = 0; axis < 3; ++axis) line += " " + base::to_text(p[axis]);
    if (coloured)
      for (const std::uint8_t c : mesh.colours[i]) line += " " + base::to_fixed(c / 255.0, 4);
    out.write(line += '\n');
  }
  for (const auto& t : mesh.triangles) {
    line = "f";
    for (const std::uint32_t v : t) {
      if (v >= mesh.vertices.size()) throw bad("a triangle names a vertex that does not exist");
      line += " " + std::to_string(std::uint64_t{v} + 1);
    }
    out.write(line += '\n');
  }
  out.close();
}

}  // namespace cairn::io
