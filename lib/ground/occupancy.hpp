// What is known of each cell of a ground vehicle's map, and how several sources become one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "geometry/grid.hpp"
#include "geometry/primitives.hpp"
#include "survey/obstacle.hpp"

namespace cairn::ground {

enum class Occupancy : std::uint8_t { free = 0, occupied = 1, unknown = 2 };
using OccupancyGrid = geometry::Grid<Occupancy>;

// Rectangle of cells of a grid.
struct CellRegion {
  std::size_t row = 0, column = 0;    // of its north-western cell
  std::size_t rows = 0, columns = 0;  // 0 = empty

  [[nodiscard]] bool empty() const { return rows == 0 || columns == 0; }
  [[nodiscard]] std::size_t end_row() const { return row + rows; }
  [[nodiscard]] std::size_t end_column() const { return column + columns; }
  friend bool operator==(const CellRegion&, const CellRegion&) = default;
};

[[nodiscard]] CellRegion whole(const geometry::GridGeometry& grid);
// Cells that touch the box [min, max] (local east, north, m), clipped to the grid.
[[nodiscard]] CellRegion cells_of(const geometry::GridGeometry& grid, const geometry::Vec2& min,
                                  const geometry::Vec2& max);
// The region with `margin` cells more on each side, clipped to the grid; empty stays empty.
[[nodiscard]] CellRegion widened(const CellRegion& region, std::size_t margin, const geometry::GridGeometry& grid);
// Smallest region that holds both.
[[nodiscard]] CellRegion joined(const CellRegion& a, const CellRegion& b);

struct MarkedObstacles {
  CellRegion cells;                     // holds every cell that was marked
  std::vector<std::size_t> outside;     // indices of obstacles that touch no cell of the grid
  std::vector<std::size_t> not_finite;  // indices of obstacles whose place or width is no finite number
};

// Marks as occupied the cells whose centre lies within half the width of an obstacle, and always the cell its
// position is in. `ignored` obstacles and vehicles leave no mark. Moving obstacles are marked where they were last
// seen. Cost: cells covered.
[[nodiscard]] MarkedObstacles mark_obstacles(std::span<const survey::Obstacle> obstacles, OccupancyGrid& grid);
// The same for the rows of `full` from first_row on that `strip` holds (as many as it has); `cells` and `outside` are
// those of `full`. Strip by strip the marks are the same as in one go.
MarkedObstacles mark_obstacles(std::span<const survey::Obstacle> obstacles, const geometry::GridGeometry& full,
                               std::size_t first_row, OccupancyGrid& strip);

// Polygons of a prior map. Each is an outer ring and its holes; a cell belongs to a polygon where its centre lies
// inside (even-odd rule over all rings). Sets those cells to `value`; false where no cell was. Cost: rows times edges,
// then cells.
bool mark_polygon(std::span<const geometry::Ring> rings, Occupancy value, OccupancyGrid& grid);
bool mark_polygon(std::span<const geometry::Ring> rings, Occupancy value, const geometry::GridGeometry& full,
                  std::size_t first_row, OccupancyGrid& strip);

// Which source overrules which. The paper gives no rule (B13); by default no source may take away what another one
// holds as an obstacle: the scanner looks over low obstacles that the aircraft saw, and prior maps block what
// no sensor sees (water, kerbs, property).
struct CombineOptions {
  bool scans_free_unknown = true;      // ground that the scanner saw through is free where the prior map is unknown
  bool scans_clear_prior = false;      // ... and where the prior map is occupied
  bool scans_clear_obstacles = false;  // ... and where an obstacle from the air is

  void visit(base::OptionVisitor& v) {
    v.flag("scans-free-unknown", scans_free_unknown, "scans free ground that the prior map does not know");
    v.flag("scans-clear-prior", scans_clear_prior, "scans free ground that the prior map holds as occupied");
    v.flag("scans-clear-obstacles", scans_clear_obstacles, "scans free ground of obstacles from the air");
  }
};

// One cell. obstacle and scan: `unknown` = that source says nothing; a free `obstacle` says nothing either.
//   1. occupied where the scan is occupied; where an obstacle is, or the prior is occupied, unless the scan is free and
//      may clear it;
//   2. else free where the prior is free, or the scan is free and may (it clears, or frees unknown ground);
//   3. else unknown.
[[nodiscard]] Occupancy combine(Occupancy prior, Occupancy obstacle, Occupancy scan, const CombineOptions& options);

// The cells of `region`, into `out`. obstacles and scans may be null (they say nothing). All have the geometry of
// `out`. Throws invalid_argument otherwise.
void combine(const OccupancyGrid& prior, const OccupancyGrid* obstacles, const OccupancyGrid* scans,
             const CombineOptions& options, const CellRegion& region, OccupancyGrid& out);

}  // namespace cairn::ground
