#include "pipeline/segment_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include "base/error.hpp"
#include "base/memory.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "segmentation/find_rocks.hpp"
#include "segmentation/plan_index.hpp"

namespace cairn::pipeline {
namespace {

using geometry::GridGeometry;
using geometry::Vec2;
using geometry::Vec3;
using segmentation::Candidate;
using segmentation::Label;
using segmentation::PointClass;

constexpr std::uint64_t kPiece = 65536;       // points read at once
constexpr std::size_t kBlock = 64;            // cells: interpolation pyramids of tiles and whole agree on it
constexpr double kBufferObjects = 4.0;        // widest objects: reach of openings and interpolation
constexpr std::uint64_t kBytesPerPoint = 64;  // of a tile at work: position, class, index, patches
constexpr std::uint64_t kBytesPerCell = 60;   // of its grids
constexpr double kDefaultBudget = 4.0 * 1024 * 1024 * 1024;  // bytes, without a limit
constexpr std::uint64_t kMostTilePoints = 4'000'000'000ULL;  // indices of 32 bits

struct PieceBox {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = Vec2::Constant(-std::numeric_limits<double>::infinity());
  std::uint64_t finite = 0;
};

// Boxes of the pieces, in order.
std::vector<PieceBox> piece_boxes(const PointSource& source, base::RunContext& ctx) {
  std::vector<PieceBox> boxes((source.count + kPiece - 1) / kPiece);
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    if (b % 64 == 0) ctx.check_stop();
    for (const Vec3& p : source.read(b * kPiece, kPiece)) {
      if (!p.allFinite()) continue;
      boxes[b].low = boxes[b].low.cwiseMin(p.head<2>());
      boxes[b].high = boxes[b].high.cwiseMax(p.head<2>());
      ++boxes[b].finite;
    }
  }
  return boxes;
}

// Blocks of kBlock cells from first on, `count` of them, along one axis; the last may be shorter.
struct Range {
  std::size_t first = 0, end = 0;  // cells
};

struct Tile {
  Range rows, columns;            // own cells
  Range wide_rows, wide_columns;  // with buffer
};

GridGeometry part_of(const GridGeometry& g, const Range& rows, const Range& columns) {
  return {g.west + g.cell * static_cast<double>(columns.first), g.north - g.cell * static_cast<double>(rows.first),
          g.cell, columns.end - columns.first, rows.end - rows.first};
}

std::vector<Tile> tiles_of(const GridGeometry& g, std::size_t edge, std::size_t buffer) {
  const auto ranges = [&](std::size_t count) {
    std::vector<Range> r;
    for (std::size_t first = 0; first < count; first += edge) r.push_back({first, std::min(first + edge, count)});
    return r;
  };
  const auto widened = [&](const Range& r, std::size_t count) {
    return Range{r.first > buffer ? r.first - buffer : 0, std::min(r.end + buffer, count)};
  };
  std::vector<Tile> tiles;
  for (const Range& rows : ranges(g.rows))
    for (const Range& columns : ranges(g.columns))
      tiles.push_back({rows, columns, widened(rows, g.rows), widened(columns, g.columns)});
  return tiles;
}

// Cells along the edge of a tile, a multiple of kBlock.
std::size_t tile_edge(const GridGeometry& g, std::uint64_t points, std::size_t buffer,
                      const SegmentTilesOptions& options, const base::RunContext& ctx) {
  const std::size_t longest = std::max(g.rows, g.columns);
  const auto up_to_blocks = [](std::size_t cells) {
    return std::max((cells + kBlock - 1) / kBlock, std::size_t{1}) * kBlock;
  };
  if (options.tile_m > 0.0) return up_to_blocks(static_cast<std::size_t>(std::ceil(options.tile_m / g.cell)));
  // Twice the mean density, as points are never spread evenly.
  const double per_cell = static_cast<double>(points) / static_cast<double>(g.cells());
  const double bytes_per_cell =
      2.0 * per_cell * static_cast<double>(kBytesPerPoint) + static_cast<double>(kBytesPerCell);
  const std::uint64_t kept = base::resident_bytes() + 2 * points;
  double budget = kDefaultBudget;
  if (ctx.memory_limit_bytes > 0)
    budget = ctx.memory_limit_bytes > kept ? static_cast<double>(ctx.memory_limit_bytes - kept) : 0.0;
  const auto bytes = [&](std::size_t edge) {
    const auto wide = [&](std::size_t count) { return static_cast<double>(std::min(edge + 2 * buffer, count)); };
    return wide(g.rows) * wide(g.columns) * bytes_per_cell;
  };
  std::size_t edge = up_to_blocks(longest);
  while (edge > kBlock && bytes(edge) > budget)
    edge = up_to_blocks(edge * 3 / 4 > kBlock ? edge * 3 / 4 - kBlock / 2 : 1);
  if (bytes(edge) > budget)
    throw base::Error(base::ErrorCode::resource_exhausted, "a tile of the cloud does not fit the memory limit")
        .found(base::to_text(bytes(edge) / 1e6) + " MB for a tile of " +
               base::to_text(static_cast<double>(edge) * g.cell) + " m and its buffer")
        .allowed(base::to_text(budget / 1e6) + " MB")
        .hint("Raise --memory-limit, or take smaller objects: --max-object-m.");
  return edge;
}

// What one tile has to say; written to the result by whoever called.
struct TileOutcome {
  std::vector<TiledObject> objects;
  std::vector<std::uint64_t> ground;  // points of the tile's own cells that are ground
};

struct TilePoints {
  std::vector<Vec3> positions;
  std::vector<std::uint64_t> index;  // in the cloud
};

TilePoints load(const PointSource& source, const std::vector<PieceBox>& boxes, const GridGeometry& wide) {
  TilePoints points;
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    const PieceBox& box = boxes[b];
    if (box.finite == 0 || box.low.x() >= wide.east() || box.high.x() < wide.west || box.low.y() > wide.north ||
        box.high.y() <= wide.south())
      continue;
    const auto piece = source.read(b * kPiece, kPiece);
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const Vec3& p = piece[i];
      if (!p.allFinite() || !wide.cell_at(p.head<2>())) continue;
      points.positions.push_back(p);
      points.index.push_back(b * kPiece + i);
    }
    if (points.positions.size() > kMostTilePoints)
      throw base::Error(base::ErrorCode::resource_exhausted, "a tile has more than 4 billion points")
          .hint("Take smaller tiles: --tile-m.");
  }
  return points;
}

TiledObject label_object(const TilePoints& tile, const segmentation::PlanIndex& plan,
                         const segmentation::GroundSurface& ground, Candidate candidate, double margin,
                         const LabelObject& label) {
  const auto members = plan.within(candidate.centre, candidate.radius + margin);
  std::vector<Vec3> points;
  points.reserve(members.size());
  for (const std::size_t i : members) points.push_back(tile.positions[i]);
  // Both lists ascend: indices of the tile become indices of the patch.
  std::vector<std::uint32_t> inside;
  inside.reserve(candidate.points.size());
  std::size_t at = 0;
  for (const std::uint32_t i : candidate.points) {
    while (at < members.size() && members[at] < i) ++at;
    if (at < members.size() && members[at] == i) inside.push_back(static_cast<std::uint32_t>(at));
  }
  candidate.points = std::move(inside);
  ObjectLabels said = label({points, &candidate, &ground});
  TiledObject object;
  object.reason = std::move(said.reason);
  object.message = std::move(said.message);
  object.record = std::move(said.record);
  if (object.reason.empty())
    for (std::size_t i = 0; i < said.labels.size(); ++i) {
      if (said.labels[i] == Label::unlabelled || said.labels[i] == Label::terrain) continue;
      object.points.push_back(tile.index[members[i]]);
      object.labels.push_back(said.labels[i]);
      object.probability.push_back(said.probability.empty() ? 1.0F : said.probability[i]);
    }
  candidate.points.clear();
  object.candidate = std::move(candidate);
  return object;
}

TileOutcome segment_tile(const TilePoints& points, const Tile& tile, const GridGeometry& grid,
                         const SegmentTilesOptions& options, const LabelObject& label, base::RunContext& ctx) {
  TileOutcome outcome;
  if (points.positions.empty()) return outcome;
  const GridGeometry own = part_of(grid, tile.rows, tile.columns);
  const auto ground = segmentation::filter_ground(points.positions, part_of(grid, tile.wide_rows, tile.wide_columns),
                                                  options.ground, ctx);
  for (std::size_t i = 0; i < points.positions.size(); ++i)
    if (ground.classes[i] == PointClass::ground && own.cell_at(points.positions[i].head<2>()))
      outcome.ground.push_back(points.index[i]);
  const segmentation::PlanIndex plan(points.positions, std::max(grid.cell, 0.25));
  auto candidates = segmentation::find_rocks(points.positions, ground, plan, options.candidates);
  std::erase_if(candidates, [&](const Candidate& c) { return !own.cell_at(c.centre); });
  if (candidates.empty()) return outcome;
  outcome.objects.resize(candidates.size());
  base::parallel_for(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      outcome.objects[c] =
          label_object(points, plan, ground.surface, std::move(candidates[c]), options.patch_margin_m, label);
  });
  return outcome;
}

// Order and ids, and which object has which point.
void settle(TiledSegments& result, const GridGeometry& grid) {
  // In whole cells of the cloud's grid: tiles give the same cell coordinates that differ in their last bit.
  const auto place = [&](const TiledObject& object) {
    const Vec2& p = object.candidate.anchor;
    return std::pair(std::llround((grid.north - p.y()) / grid.cell - 0.5),
                     std::llround((p.x() - grid.west) / grid.cell - 0.5));
  };
  std::sort(result.objects.begin(), result.objects.end(), [&](const TiledObject& a, const TiledObject& b) {
    const Vec2 &p = a.candidate.centre, &q = b.candidate.centre;  // parts of one object may share a cell
    return std::tuple(place(a), -p.y(), p.x()) < std::tuple(place(b), -q.y(), q.x());
  });
  std::uint32_t next = 1;
  for (TiledObject& object : result.objects) object.target_id = next++;
  for (const bool rocks : {true, false})
    for (TiledObject& object : result.objects) {
      for (std::size_t i = 0; i < object.points.size(); ++i) {
        Label& there = result.labels[object.points[i]];
        const bool rock = object.labels[i] == Label::rock;
        if (rock != rocks) continue;
        if (there == Label::unlabelled || there == Label::terrain) {
          there = object.labels[i];
        } else {
          object.labels[i] = Label::unlabelled;  // another object's
        }
      }
    }
  for (TiledObject& object : result.objects) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < object.points.size(); ++i) {
      if (object.labels[i] == Label::unlabelled) continue;
      object.points[kept] = object.points[i];
      object.labels[kept] = object.labels[i];
      object.probability[kept] = object.probability[i];
      ++kept;
    }
    object.points.resize(kept);
    object.labels.resize(kept);
    object.probability.resize(kept);
  }
}

}  // namespace

void SegmentTilesOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("tile-m", tile_m, 0.0, 100000.0, "edge of a tile, m; 0: as large as --memory-limit allows");
  visitor.real("patch-margin-m", patch_margin_m, 0.0, 100.0, "surroundings looked at beyond an object's circle, m");
  ground.visit(visitor);
  candidates.visit(visitor);
}

PointSource source_of(std::span<const Vec3> points) {
  return {points.size(), [points](std::uint64_t first, std::uint64_t n) {
            const auto part = points.subspan(std::min<std::size_t>(first, points.size()));
            const auto some = part.first(std::min<std::size_t>(n, part.size()));
            return std::vector<Vec3>(some.begin(), some.end());
          }};
}

ObjectLabels label_as_rock(const ObjectPatch& patch) {
  ObjectLabels said;
  said.labels.assign(patch.points.size(), Label::unlabelled);
  for (const std::uint32_t i : patch.object->points) said.labels[i] = Label::rock;
  return said;
}

TiledSegments segment_tiles(const PointSource& source, const SegmentTilesOptions& options, const LabelObject& label,
                            base::RunContext& ctx) {
  SegmentTilesOptions checked = options;
  base::validate(base::bind_options(checked), "segment");
  ctx.check_memory(2 * source.count, "labels");
  const auto boxes = piece_boxes(source, ctx);
  PieceBox all;
  for (const PieceBox& b : boxes) {
    all.low = all.low.cwiseMin(b.low);
    all.high = all.high.cwiseMax(b.high);
    all.finite += b.finite;
  }
  if (all.finite == 0)
    throw base::Error(base::ErrorCode::invalid_input, "the cloud has no finite point")
        .hint("Check the cloud with `cairn info`.");
  const GridGeometry grid = segmentation::ground_grid(all.low, all.high, all.finite, options.ground);
  const auto reach = static_cast<std::size_t>(
      std::ceil((kBufferObjects * options.ground.max_object_m + options.patch_margin_m) / grid.cell));
  const std::size_t buffer = (reach + kBlock - 1) / kBlock * kBlock;
  const std::size_t edge = tile_edge(grid, all.finite, buffer, options, ctx);
  const auto tiles = tiles_of(grid, edge, buffer);

  TiledSegments result;
  result.tiles = tiles.size();
  result.tile_m = static_cast<double>(edge) * grid.cell;
  result.buffer_m = static_cast<double>(buffer) * grid.cell;
  result.cell_m = grid.cell;
  result.not_finite = source.count - all.finite;
  result.labels.assign(source.count, Label::unlabelled);
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    ctx.check_stop();
    ctx.progress("tiles", t, tiles.size());
    const TilePoints points = load(source, boxes, part_of(grid, tiles[t].wide_rows, tiles[t].wide_columns));
    TileOutcome outcome = segment_tile(points, tiles[t], grid, options, label, ctx);
    for (const std::uint64_t i : outcome.ground) result.labels[i] = Label::terrain;
    result.ground += outcome.ground.size();
    std::move(outcome.objects.begin(), outcome.objects.end(), std::back_inserter(result.objects));
  }
  ctx.progress("tiles", tiles.size(), tiles.size());
  settle(result, grid);
  return result;
}

}  // namespace cairn::pipeline
