#include "coverage/facet_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace cairn::coverage {
namespace {

using geometry::Box3;
using geometry::Vec3;

constexpr std::size_t kPacketFacets = 16;  // rays of a packet should stay together
constexpr double kFarthest = 1e8;          // m; as visibility::Scene

struct Item {
  float p[3];
  std::uint32_t facet;
};

// Splits until pieces are of packet size, and notes those of tile size.
void split(std::span<Item> items, std::size_t begin, bool in_tile, FacetTiles& out) {
  if (!in_tile && items.size() <= kTileFacets) {
    out.tiles.push_back({begin, begin + items.size(), Vec3::Zero(), Vec3::Zero()});
    in_tile = true;
  }
  if (items.size() <= kPacketFacets) return;
  float lo[3], hi[3];
  for (int k = 0; k < 3; ++k) lo[k] = hi[k] = items[0].p[k];
  for (const Item& item : items)
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], item.p[k]);
      hi[k] = std::max(hi[k], item.p[k]);
    }
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (hi[k] - lo[k] > hi[axis] - lo[axis]) axis = k;
  // Whole tiles and whole packets on the left, so that none is left half filled.
  const std::size_t unit = in_tile ? kPacketFacets : kTileFacets;
  std::size_t middle = (items.size() / 2 + unit - 1) / unit * unit;
  if (middle >= items.size()) middle = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(middle), items.end(),
                   [axis](const Item& a, const Item& b) {
                     return a.p[axis] != b.p[axis] ? a.p[axis] < b.p[axis] : a.facet < b.facet;
                   });
  split(items.first(middle), begin, in_tile, out);
  split(items.subspan(middle), begin + middle, in_tile, out);
}

}  // namespace

FacetTiles sort_into_tiles(const geometry::TriangleMesh& mesh) {
  FacetTiles out;
  std::vector<Item> items;
  items.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const std::size_t count = mesh.vertices.size();
    const bool indexed = t[0] < count && t[1] < count && t[2] < count;
    const Vec3 c = indexed ? mesh.centroid(i) : Vec3(Vec3::Constant(std::nan("")));
    const bool near = indexed && mesh.vertices[t[0]].cwiseAbs().maxCoeff() <= kFarthest &&
                      mesh.vertices[t[1]].cwiseAbs().maxCoeff() <= kFarthest &&
                      mesh.vertices[t[2]].cwiseAbs().maxCoeff() <= kFarthest;
    if (!near || !c.allFinite() || !(mesh.area_vector(i).squaredNorm() > 0.0)) {
      ++out.skipped;
      continue;
    }
    items.push_back({{static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z())},
                     static_cast<std::uint32_t>(i)});
  }
  if (!items.empty()) split(items, 0, false, out);
  out.order.reserve(items.size());
  for (const Item& item : items) out.order.push_back(item.facet);
  for (FacetTile& tile : out.tiles) {
    Box3 box;
    for (std::size_t k = tile.begin; k < tile.end; ++k) box.extend(mesh.centroid(out.order[k]));
    tile.centre = box.centre();
    tile.half = 0.5 * box.size();
  }
  return out;
}

}  // namespace cairn::coverage
