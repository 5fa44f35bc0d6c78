#include "report/mesh_pack.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>

#include "report/base64.hpp"

namespace cairn::report {
namespace {

void put_u32(std::string& out, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift & 0xFFU);
}
void put_f32(std::string& out, double value) {
  put_u32(out, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

FlaggedMesh cluster_once(const FlaggedMesh& in, double cell) {
  using Key = std::tuple<std::int64_t, std::int64_t, std::int64_t>;
  std::map<Key, std::uint32_t> index;  // ordered: the result must not depend on hashing
  std::vector<std::uint32_t> of(in.mesh.vertices.size());
  std::vector<std::size_t> count;
  std::vector<std::array<std::size_t, 3>> colour_sum;
  const bool coloured = in.mesh.colours.size() == in.mesh.vertices.size();
  FlaggedMesh out;
  for (std::size_t i = 0; i < in.mesh.vertices.size(); ++i) {
    const geometry::Vec3& p = in.mesh.vertices[i];
    const auto k = [cell](double v) { return static_cast<std::int64_t>(std::floor(v / cell)); };
    const auto [it, fresh] =
        index.try_emplace(Key{k(p.x()), k(p.y()), k(p.z())}, static_cast<std::uint32_t>(out.mesh.vertices.size()));
    if (fresh) {
      out.mesh.vertices.push_back(geometry::Vec3::Zero());
      count.push_back(0);
      colour_sum.push_back({});
    }
    of[i] = it->second;
    out.mesh.vertices[it->second] += p;
    ++count[it->second];
    if (coloured)
      for (std::size_t c = 0; c < 3; ++c) colour_sum[it->second][c] += in.mesh.colours[i][c];
  }
  for (std::size_t i = 0; i < out.mesh.vertices.size(); ++i) {
    out.mesh.vertices[i] /= static_cast<double>(count[i]);
    if (!coloured) continue;
    std::array<std::uint8_t, 3> colour{};
    for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<std::uint8_t>(colour_sum[i][c] / count[i]);
    out.mesh.colours.push_back(colour);
  }
  const bool flagged = in.facet_seen.size() == in.mesh.triangles.size();
  for (std::size_t t = 0; t < in.mesh.triangles.size(); ++t) {
    const geometry::Triangle& v = in.mesh.triangles[t];
    const geometry::Triangle w{of[v[0]], of[v[1]], of[v[2]]};
    if (w[0] == w[1] || w[1] == w[2] || w[2] == w[0]) continue;
    out.mesh.triangles.push_back(w);
    if (flagged) out.facet_seen.push_back(in.facet_seen[t]);
  }
  return out;
}

io::Json rounded(const geometry::Vec3& p) {
  return io::Json(
      std::vector<double>{std::round(p.x() * 1e4) / 1e4, std::round(p.y() * 1e4) / 1e4, std::round(p.z() * 1e4) / 1e4});
}

}  // namespace

FlaggedMesh clustered(const FlaggedMesh& mesh, std::size_t max_triangles) {
  if (mesh.mesh.triangles.size() <= max_triangles) return mesh;
  // A closed surface of n triangles spans about sqrt(n / 12) cells of its box's side.
  double cell = mesh.mesh.bounds().size().maxCoeff() / std::sqrt(static_cast<double>(max_triangles) / 4.0);
  if (!(cell > 0.0)) return {};
  FlaggedMesh out = cluster_once(mesh, cell);
  while (out.mesh.triangles.size() > max_triangles) out = cluster_once(mesh, cell *= 1.25);
  return out;
}

io::Json packed_rock(const RockView& rock, std::size_t max_triangles) {
  const survey::Rock& r = rock.rock;
  io::Json out = io::Json::object({{"id", r.target.value}});
  if (!rock.mesh || rock.mesh->triangles.empty()) return out;
  const FlaggedMesh small = clustered({*rock.mesh, rock.facet_seen}, max_triangles);
  const geometry::Box3 box = rock.mesh->bounds();
  const geometry::Vec3 origin{box.centre().x(), box.centre().y(), r.base_height_m};
  out.set("origin", rounded(origin));
  std::string positions, indices, seen, colours;
  for (const geometry::Vec3& p : small.mesh.vertices)
    for (Eigen::Index k = 0; k < 3; ++k) put_f32(positions, p[k] - origin[k]);
  for (const geometry::Triangle& t : small.mesh.triangles)
    for (const std::uint32_t i : t) put_u32(indices, i);
  for (const std::uint8_t s : small.facet_seen) seen += static_cast<char>(s != 0 ? 1 : 0);
  for (const auto& c : small.mesh.colours)
    for (const std::uint8_t v : c) colours += static_cast<char>(v);
  out.set("p", base64(positions)).set("t", base64(indices));
  if (seen.size() == small.mesh.triangles.size()) out.set("s", base64(seen));
  if (small.mesh.colours.size() == small.mesh.vertices.size()) out.set("c", base64(colours));
  out.set("triangles", small.mesh.triangles.size()).set("of", rock.mesh->triangles.size());
  if (r.mass) out.set("com", rounded(r.mass->centre_of_mass - origin));
  if (!r.tipping.contact.empty()) {
    io::Json contact = io::Json::array();
    for (const geometry::Vec3& q : r.tipping.contact) contact.push(rounded(q - origin));
    out.set("contact", contact).set("assumed", r.tipping.contact_assumed);
  }
  if (r.tipping.grade != survey::Grade::not_measurable && r.tipping.critical)
    out.set("topple_toward_deg", r.tipping.critical->azimuth_deg);
  return out;
}

}  // namespace cairn::report
