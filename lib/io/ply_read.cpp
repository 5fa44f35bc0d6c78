// Reading of the elements of a PLY file.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "io/bytes.hpp"
#include "io/cloud_columns.hpp"
#include "io/ply.hpp"
#include "io/ply_header.hpp"

namespace cairn::io {
namespace {

using geometry::PointCloud;
using geometry::ScalarType;
using ply::Element;
using ply::Encoding;
using ply::Property;

constexpr std::size_t kPiecePoints = 4096;

// The columns of the vertices; lists among them are skipped.
std::vector<NamedColumn> columns_of(const Element& vertex, SourceFacts& facts) {
  std::vector<NamedColumn> columns;
  for (const Property& p : vertex.properties) {
    if (p.count_type) facts.warnings.push_back("the list '" + p.name + "' of each vertex is not read");
    // "rgb" packed in a float is a habit of PCD alone.
    columns.push_back({p.name, p.type, p.count_type.has_value()});
  }
  return columns;
}

// Reads one element after another, in the file's order.
class Body {
 public:
  Body(const FileBytes& file, const ply::Header& header)
      : file_(file),
        header_(header),
        swap_(header.encoding == Encoding::big),
        words_(file.text().substr(header.body), file.name(), header.body_line),
        position_(header.body) {}

  // A count that the rest of the file cannot hold is refused before anything is reserved.
  void check_count(const Element& element) const {
    const std::uint64_t left = ascii() ? words_.remaining() : file_.bytes().size() - position_;
    // A word and a separator; the last word of the file may lack its separator.
    const std::uint64_t least = ascii() ? 2 * element.properties.size() : element.least_bytes();
    if (least == 0) return;
    const std::uint64_t room = (left + (ascii() ? 1 : 0)) / least;
    if (element.count > room)
      throw at(position_, "the header promises more '" + element.name.substr(0, 40) + "' records than the file holds")
          .found(std::to_string(element.count))
          .allowed("at most " + std::to_string(room) + " in the " + std::to_string(left) + " bytes that are left")
          .hint("The file is truncated or its header is wrong");
  }

  // body(property, value index, value); lists tell their length through begin_list(property, length).
  template <typename Value, typename List>
  void each_record(const Element& element, const Value& value, const List& begin_list) {
    if (element.properties.empty()) return;
    for (std::uint64_t i = 0; i < element.count; ++i)
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        if (!property.count_type) {
          value(i, p, next(property.type, element));
          continue;
        }
        const double length = next(*property.count_type, element);
        const std::uint64_t left =
            ascii() ? (words_.remaining() + 1) / 2 : (file_.bytes().size() - position_) / size_of(property.type);
        if (!(length >= 0.0 && length <= static_cast<double>(left)) || length != std::floor(length))
          throw at(position_, "a list is longer than the rest of the file")
              .found(base::to_text(length))
              .allowed("0 to " + std::to_string(left));
        begin_list(i, p, static_cast<std::size_t>(length));
        for (double k = 0.0; k < length; k += 1.0) value(i, p, next(property.type, element));
      }
  }

  void skip(const Element& element) {
    if (!ascii() && !element.has_lists()) {
      position_ += static_cast<std::size_t>(element.count) * element.least_bytes();
      return;
    }
    each_record(
        element, [](std::uint64_t, std::size_t, double) {}, [](std::uint64_t, std::size_t, std::size_t) {});
  }

  void read_vertices(const Element& vertex, const std::vector<Slot>& slots, PointCloud& cloud) {
    if (ascii() || vertex.has_lists()) {
      each_record(
          vertex,
          [&](std::uint64_t i, std::size_t p, double v) { put_value(cloud, slots[p], static_cast<std::size_t>(i), v); },
          [](std::uint64_t, std::size_t, std::size_t) {});
      return;
    }
    const std::size_t stride = vertex.least_bytes();
    const std::byte* begin = file_.bytes().data() + position_;
    base::parallel_for(static_cast<std::size_t>(vertex.count), kPiecePoints, [&](std::size_t first, std::size_t last) {
      std::size_t offset = 0;
      for (std::size_t p = 0; p < slots.size(); ++p) {
        const Slot slot = slots[p];
        with_type(slot.type, [&](auto kind) {
          const std::byte* from = begin + first * stride + offset;
          for (std::size_t i = first; i < last; ++i, from += stride)
            put_value(cloud, slot, i, static_cast<double>(load<decltype(kind)>(from, swap_)));
        });
        offset += size_of(slot.type);
      }
    });
    position_ += static_cast<std::size_t>(vertex.count) * stride;
  }

  [[nodiscard]] base::Error at(std::size_t offset, std::string message) const {
    return ascii() ? words_.error(std::move(message)) : bad_bytes(file_.name(), offset, std::move(message));
  }
  [[nodiscard]] std::size_t position() const { return position_; }

 private:
  [[nodiscard]] bool ascii() const { return header_.encoding == Encoding::ascii; }

  double next(ScalarType type, const Element& element) {
    if (ascii()) {
      const auto word = words_.next_word();
      if (!word)
        throw words_.error("the file ends inside the '" + element.name.substr(0, 40) + "' records")
            .hint("The file is truncated");
      const auto v = parse_number(*word);
      if (!v)
        throw words_.error("not a number")
            .found("'" + printable_text(std::as_bytes(std::span(word->substr(0, 40)))) + "'");
      return *v;
    }
    const std::size_t size = size_of(type);
    if (file_.bytes().size() - position_ < size)
      throw at(position_, "the file ends inside the '" + element.name.substr(0, 40) + "' records")
          .hint("The file is truncated");
    const double v = load_any(file_.bytes().data() + position_, type, swap_);
    position_ += size;
    return v;
  }

  const FileBytes& file_;
  const ply::Header& header_;
  bool swap_;
  TextReader words_;
  std::size_t position_;
};

void read_faces(Body& body, const Element& face, std::size_t vertices, MeshData& data) {
  std::size_t list = face.properties.size();
  for (std::size_t p = 0; p < face.properties.size(); ++p)
    if (face.properties[p].count_type &&
        (face.properties[p].name == "vertex_indices" || face.properties[p].name == "vertex_index"))
      list = p;
  if (list == face.properties.size()) {
    data.facts.warnings.emplace_back("the faces have no list 'vertex_indices': not read");
    body.skip(face);
    return;
  }
  std::size_t corner = 0;
  geometry::Triangle t{};
  body.each_record(
      face,
      [&](std::uint64_t i, std::size_t p, double v) {
        if (p != list) return;
        if (!(v >= 0.0 && v < static_cast<double>(vertices)) || v != std::floor(v))
          throw body.at(body.position(), "face " + std::to_string(i) + " names a vertex that does not exist")
              .found(base::to_text(v))
              .allowed("0 to " + std::to_string(vertices) + ", exclusive");
        const auto index = static_cast<std::uint32_t>(v);
        if (corner == 0) {
          t[0] = index;
        } else {
          t[1] = t[2];
          t[2] = index;
          if (corner >= 2) data.mesh.triangles.push_back(t);
        }
        ++corner;
      },
      [&](std::uint64_t, std::size_t p, std::size_t length) {
        if (p != list) return;
        corner = 0;
        if (length < 3) ++data.facts.dropped_faces;
      });
  if (data.facts.dropped_faces > 0)
    data.facts.warnings.push_back(std::to_string(data.facts.dropped_faces) +
                                  " faces with fewer than 3 vertices were dropped");
}

CloudData read_ply(const std::filesystem::path& path, MeshData* mesh) {
  const FileBytes file(path);
  const ply::Header header = ply::parse_header(file.text(), file.name());
  CloudData data;
  data.facts.format = "PLY";
  data.facts.version = "1.0, " + std::string(ply::name_of(header.encoding));
  data.facts.crs = header.crs;
  data.facts.comments = header.comments;
  Body body(file, header);
  bool has_vertices = false;
  for (const Element& element : header.elements) {
    body.check_count(element);
    if (element.name == "vertex" && !has_vertices) {
      has_vertices = true;
      data.facts.declared_points = element.count;
      const std::vector<NamedColumn> columns = columns_of(element, data.facts);
      int positions = 0;
      std::vector<Slot> slots = assign_slots(columns, positions);
      if (positions != 3)
        throw bad_line(file.name(), header.body_line - 1, "the vertices lack a coordinate")
            .found(std::to_string(positions) + " of x, y, z")
            .allowed("x, y and z");
      make_columns(data.cloud, columns, slots, static_cast<std::size_t>(element.count));
      body.read_vertices(element, slots, data.cloud);
    } else if (element.name == "face") {
      data.facts.declared_faces += element.count;
      if (mesh == nullptr) break;  // nothing behind the faces is needed
      if (!has_vertices) throw bad_line(file.name(), header.body_line - 1, "the faces stand before the vertices");
      if (data.cloud.size() >= std::numeric_limits<std::uint32_t>::max())
        throw bad_line(file.name(), header.body_line - 1, "too many vertices for a mesh")
            .found(std::to_string(data.cloud.size()))
            .allowed("below 4294967295");
      read_faces(body, element, data.cloud.size(), *mesh);
    } else {
      if (element.name == "tristrips") data.facts.warnings.emplace_back("triangle strips are not read");
      body.skip(element);
    }
  }
  if (!has_vertices)
    throw bad_line(file.name(), header.body_line - 1, "the file has no vertices").allowed("an element 'vertex'");
  return data;
}

}  // namespace

CloudData read_ply_cloud(const std::filesystem::path& path) {
  CloudData data = read_ply(path, nullptr);
  drop_non_finite(data);
  return data;
}

MeshData read_ply_mesh(const std::filesystem::path& path) {
  MeshData data;
  CloudData vertices = read_ply(path, &data);
  vertices.facts.dropped_faces = data.facts.dropped_faces;
  std::ranges::move(data.facts.warnings, std::back_inserter(vertices.facts.warnings));
  data.facts = std::move(vertices.facts);
  data.mesh.vertices = std::move(vertices.cloud.positions);
  for (const auto& c : vertices.cloud.colours)
    data.mesh.colours.push_back({static_cast<std::uint8_t>(c[0] >> 8U), static_cast<std::uint8_t>(c[1] >> 8U),
                                 static_cast<std::uint8_t>(c[2] >> 8U)});
  drop_non_finite(data);
  return data;
}

}  // namespace cairn::io
