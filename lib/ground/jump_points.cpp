#include "ground/jump_points.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <queue>

namespace cairn::ground {
namespace {

constexpr std::uint64_t kStopInterval = 1 << 12;
constexpr std::uint64_t kAll = ~std::uint64_t{0};

// Transposes 64 x 64 bits: bit c of word r becomes bit r of word c (Warren, Hacker's Delight, 7-3).
void transpose(std::array<std::uint64_t, 64>& a) {
  std::uint64_t mask = 0x00000000ffffffffULL;
  for (unsigned j = 32; j != 0; j >>= 1, mask ^= mask << j)
    for (unsigned k = 0; k < 64; k = (k + j + 1) & ~j) {
      const std::uint64_t t = ((a[k] >> j) ^ a[k + j]) & mask;
      a[k] ^= t << j;
      a[k + j] ^= t;
    }
}

}  // namespace

BlockedBits::BlockedBits(const geometry::Grid<std::uint8_t>& cost, const std::vector<std::uint8_t>& blocked) {
  const std::size_t height = cost.geometry.rows, width = cost.geometry.columns;
  rows.words = (width + 2 + 63) / 64;
  columns.words = (height + 2 + 63) / 64;
  rows.bits.assign(rows.words * (height + 2), kAll);
  columns.bits.assign(columns.words * (width + 2), kAll);
  // One flag a byte, the border's first, padded with blocked cells to whole words.
  std::vector<std::uint8_t> flags(rows.words * 64, 1);
  for (std::size_t r = 0; r < height; ++r) {
    const std::uint8_t* values = &cost.values[r * width];
    for (std::size_t c = 0; c < width; ++c) flags[c + 1] = blocked[values[c]];
    std::uint64_t* line = &rows.bits[(r + 1) * rows.words];
    for (std::size_t w = 0; w < rows.words; ++w) {
      std::uint64_t word = 0;
      for (std::size_t byte = 0; byte < 8; ++byte) {
        std::uint64_t eight = 0;
        std::memcpy(&eight, &flags[w * 64 + byte * 8], sizeof eight);
        // Gathers the lowest bit of each byte (little-endian: the first flag becomes the lowest bit).
        word |= (eight * 0x0102040810204080ULL >> 56) << (8 * byte);
      }
      line[w] = word;
    }
  }
  std::array<std::uint64_t, 64> block{};
  for (std::size_t r = 0; r < columns.words; ++r)
    for (std::size_t w = 0; w < rows.words; ++w) {
      for (std::size_t k = 0; k < 64; ++k)
        block[k] = r * 64 + k < height + 2 ? rows.bits[(r * 64 + k) * rows.words + w] : kAll;
      transpose(block);
      for (std::size_t k = 0; k < 64 && w * 64 + k < width + 2; ++k)
        columns.bits[(w * 64 + k) * columns.words + r] = block[k];
    }
}

namespace {

// Row and column within the border.
struct Point {
  std::int32_t row, column;
  friend bool operator==(const Point&, const Point&) = default;
};

// Ways in which a cell is reached on shortest paths, as bits; what follows from each is different.
constexpr std::array<Point, 4> kWays{{{-1, 0}, {0, -1}, {0, 1}, {1, 0}}};
constexpr std::uint8_t kDiagonally = 16;  // the goal only
constexpr std::uint8_t kStart = 32;

std::uint8_t way_of(int row_step, int column_step) {
  if (row_step != 0 && column_step != 0) return kDiagonally;
  return row_step != 0 ? (row_step < 0 ? 1 : 8) : (column_step < 0 ? 2 : 4);
}

struct Node {
  Point at;
  std::int32_t straight, diagonal;  // steps from the start
  std::uint32_t parent;
  std::uint8_t ways, done;  // of arrival at this distance; those already followed
};

struct Entry {
  double estimate, travelled;
  std::uint32_t node;
  // The queue's top is the least estimate, then the farthest travelled, then the oldest node.
  friend bool operator<(const Entry& a, const Entry& b) {
    if (a.estimate != b.estimate) return a.estimate > b.estimate;
    if (a.travelled != b.travelled) return a.travelled < b.travelled;
    return a.node > b.node;
  }
};

// Nodes by place, open addressing. Only looked up, never walked through.
class NodeTable {
 public:
  // Slot of a key: the node's number, or a free slot that the caller fills.
  std::uint32_t& slot(std::uint64_t key) {
    if (2 * used_ >= keys_.size()) grow();
    const std::size_t i = find(key);
    if (keys_[i] == 0) {
      keys_[i] = key;
      ++used_;
    }
    return values_[i];
  }

 private:
  [[nodiscard]] std::size_t find(std::uint64_t key) const {
    std::size_t i = (key * 0x9e3779b97f4a7c15ULL) >> shift_;
    while (keys_[i] != 0 && keys_[i] != key) i = (i + 1) & (keys_.size() - 1);
    return i;
  }
  void grow() {
    --shift_;
    std::vector<std::uint64_t> keys(keys_.size() * 2, 0);
    std::vector<std::uint32_t> values(keys.size(), 0);
    keys.swap(keys_);
    values.swap(values_);
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (keys[i] == 0) continue;
      const std::size_t j = find(keys[i]);
      keys_[j] = keys[i];
      values_[j] = values[i];
    }
  }
  unsigned shift_ = 64 - 12;
  std::vector<std::uint64_t> keys_ = std::vector<std::uint64_t>(4096, 0);
  std::vector<std::uint32_t> values_ = std::vector<std::uint32_t>(4096, 0);
  std::size_t used_ = 0;
};

// First place after `at` on a line, upwards or downwards, where a path must stop: a blocked cell (then 0 is returned:
// nothing to be found this way), the goal, or a cell beside which an obstacle of a neighbouring line has just ended.
// goal: its place on this line, or 0.
std::int32_t scan_up(const BlockedBits::Lines& map, std::int32_t line, std::int32_t at, std::int32_t goal) {
  const std::uint64_t *here = map.line(line), *above = here - map.words, *below = here + map.words;
  std::size_t w = static_cast<std::size_t>(at) >> 6;
  std::uint64_t mask = kAll << (at & 63);
  mask &= mask - 1;  // beyond `at`
  // Whether the last cell of the word before was blocked beside the line.
  std::uint64_t above_before = w == 0 ? 1 : above[w - 1] >> 63, below_before = w == 0 ? 1 : below[w - 1] >> 63;
  for (;;) {
    const std::uint64_t a = above[w], b = below[w];
    const std::uint64_t ends = ((a << 1 | above_before) & ~a) | ((b << 1 | below_before) & ~b);
    const std::uint64_t stops = (ends | here[w]) & mask;
    if (stops != 0) {
      const int bit = std::countr_zero(stops);
      const auto stop = static_cast<std::int32_t>(w * 64) + bit;
      if (goal > at && goal <= stop) return goal;
      return (here[w] >> bit & 1) != 0 ? 0 : stop;
    }
    above_before = a >> 63;
    below_before = b >> 63;
    mask = kAll;
    ++w;
  }
}

std::int32_t scan_down(const BlockedBits::Lines& map, std::int32_t line, std::int32_t at, std::int32_t goal) {
  const std::uint64_t *here = map.line(line), *above = here - map.words, *below = here + map.words;
  std::size_t w = static_cast<std::size_t>(at) >> 6;
  std::uint64_t mask = (std::uint64_t{1} << (at & 63)) - 1;
  const bool last = w + 1 == map.words;
  std::uint64_t above_before = last ? 1 : above[w + 1] & 1, below_before = last ? 1 : below[w + 1] & 1;
  for (;;) {
    const std::uint64_t a = above[w], b = below[w];
    const std::uint64_t ends = ((a >> 1 | above_before << 63) & ~a) | ((b >> 1 | below_before << 63) & ~b);
    const std::uint64_t stops = (ends | here[w]) & mask;
    if (stops != 0) {
      const int bit = 63 - std::countl_zero(stops);
      const auto stop = static_cast<std::int32_t>(w * 64) + bit;
      if (goal != 0 && goal < at && goal >= stop) return goal;
      return (here[w] >> bit & 1) != 0 ? 0 : stop;
    }
    above_before = a & 1;
    below_before = b & 1;
    mask = kAll;
    --w;
  }
}

class Search {
 public:
  Search(const BlockedBits& map, Point start, Point goal) : map_(map), goal_(goal) { push(start, 0, 0, 0, kStart); }

  JumpPath run(base::RunContext& ctx) {
    JumpPath result;
    while (!open_.empty()) {
      const Entry entry = open_.top();
      open_.pop();
      Node& node = nodes_[entry.node];
      const auto ways = static_cast<std::uint8_t>(node.ways & ~node.done);
      if (ways == 0) continue;
      node.done |= ways;
      if (++result.expansions % kStopInterval == 0) ctx.check_stop();
      if (node.at == goal_) {
        trace(entry.node, result);
        return result;
      }
      expand(entry.node, ways);
    }
    return result;
  }

 private:
  [[nodiscard]] static double length(std::int32_t straight, std::int32_t diagonal) {
    return static_cast<double>(straight) + static_cast<double>(diagonal) * std::numbers::sqrt2;
  }

  void push(Point at, std::int32_t straight, std::int32_t diagonal, std::uint32_t parent, std::uint8_t way) {
    const std::uint64_t key = (static_cast<std::uint64_t>(at.row) << 32 | static_cast<std::uint64_t>(at.column)) + 1;
    std::uint32_t& number = table_.slot(key);
    if (number == 0) {
      nodes_.push_back({at, straight, diagonal, parent, way, 0});
      number = static_cast<std::uint32_t>(nodes_.size());
    } else {
      Node& known = nodes_[number - 1];
      // Equal lengths are equal numbers of steps: the square root of two is not a fraction.
      if (known.straight == straight && known.diagonal == diagonal) {
        if ((known.ways & way) != 0) return;
        known.ways |= way;
      } else {
        if (length(known.straight, known.diagonal) < length(straight, diagonal)) return;
        known = {at, straight, diagonal, parent, way, 0};
      }
    }
    // What is left at best, in whole steps of either kind.
    const std::int32_t rows = std::abs(at.row - goal_.row), columns = std::abs(at.column - goal_.column);
    const std::int32_t both = std::min(rows, columns), rest = std::max(rows, columns) - both;
    open_.push({length(straight + rest, diagonal + both), length(straight, diagonal), number - 1});
  }

  // Straight from a place; what stops the scan becomes a node.
  void straight(Point from, int row_step, int column_step, std::uint32_t parent, std::int32_t steps,
                std::int32_t diagonal) {
    if (column_step != 0) {
      const std::int32_t goal = from.row == goal_.row ? goal_.column : 0;
      const std::int32_t stop = column_step > 0 ? scan_up(map_.rows, from.row, from.column, goal)
                                                : scan_down(map_.rows, from.row, from.column, goal);
      if (stop != 0)
        push({from.row, stop}, steps + std::abs(stop - from.column), diagonal, parent, way_of(0, column_step));
    } else {
      const std::int32_t goal = from.column == goal_.column ? goal_.row : 0;
      const std::int32_t stop = row_step > 0 ? scan_up(map_.columns, from.column, from.row, goal)
                                             : scan_down(map_.columns, from.column, from.row, goal);
      if (stop != 0)
        push({stop, from.column}, steps + std::abs(stop - from.row), diagonal, parent, way_of(row_step, 0));
    }
  }

  // Diagonally from a place as far as it goes, with a look straight both ways from each cell on the way.
  void slanted(Point from, int row_step, int column_step, std::uint32_t parent, std::int32_t steps,
               std::int32_t diagonal) {
    for (;;) {
      const Point next{from.row + row_step, from.column + column_step};
      if (map_.blocked(next.row, next.column) || map_.blocked(from.row, next.column) ||
          map_.blocked(next.row, from.column))
        return;
      from = next;
      ++diagonal;
      if (from == goal_) {
        push(from, steps, diagonal, parent, kDiagonally);
        return;
      }
      straight(from, row_step, 0, parent, steps, diagonal);
      straight(from, 0, column_step, parent, steps, diagonal);
    }
  }

  void expand(std::uint32_t number, std::uint8_t ways) {
    const Node node = nodes_[number];
    const Point at = node.at;
    const auto go = [&](int row_step, int column_step) {
      if (row_step != 0 && column_step != 0) slanted(at, row_step, column_step, number, node.straight, node.diagonal);
      else straight(at, row_step, column_step, number, node.straight, node.diagonal);
    };
    if ((ways & kStart) != 0) {
      for (int row_step = -1; row_step <= 1; ++row_step)
        for (int column_step = -1; column_step <= 1; ++column_step)
          if (row_step != 0 || column_step != 0) go(row_step, column_step);
      return;
    }
    for (std::size_t way = 0; way < kWays.size(); ++way) {
      if ((ways >> way & 1) == 0) continue;
      const int dr = kWays[way].row, dc = kWays[way].column;
      go(dr, dc);
      for (const int side : {-1, 1}) {
        // Sideways of the direction of arrival; the obstacle beside the last cell has just ended.
        const int sr = dr == 0 ? side : 0, sc = dr == 0 ? 0 : side;
        if (!map_.blocked(at.row - dr + sr, at.column - dc + sc) || map_.blocked(at.row + sr, at.column + sc)) continue;
        go(sr, sc);
        go(dr + sr, dc + sc);
      }
    }
  }

  void trace(std::uint32_t number, JumpPath& result) const {
    result.straight = nodes_[number].straight;
    result.diagonal = nodes_[number].diagonal;
    const auto add = [&](Point p) {
      const std::pair<std::int64_t, std::int64_t> corner(p.row - 1, p.column - 1);
      if (result.corners.empty() || result.corners.back() != corner) result.corners.push_back(corner);
    };
    for (;;) {
      const Node& node = nodes_[number];
      add(node.at);
      if (number == node.parent) break;
      const Node& parent = nodes_[node.parent];
      // Diagonal steps came first, then the straight ones.
      const std::int32_t diagonal = node.diagonal - parent.diagonal;
      const auto sign = [](std::int32_t v) { return v > 0 ? 1 : (v < 0 ? -1 : 0); };
      add({parent.at.row + diagonal * sign(node.at.row - parent.at.row),
           parent.at.column + diagonal * sign(node.at.column - parent.at.column)});
      number = node.parent;
    }
    std::reverse(result.corners.begin(), result.corners.end());
  }

  const BlockedBits& map_;
  Point goal_;
  std::vector<Node> nodes_;
  NodeTable table_;
  std::priority_queue<Entry> open_;
};

}  // namespace

JumpPath jump_path(const BlockedBits& map, std::pair<std::int64_t, std::int64_t> start,
                   std::pair<std::int64_t, std::int64_t> goal, base::RunContext& ctx) {
  const auto inside = [](const std::pair<std::int64_t, std::int64_t>& cell) {
    return Point{static_cast<std::int32_t>(cell.first + 1), static_cast<std::int32_t>(cell.second + 1)};
  };
  return Search(map, inside(start), inside(goal)).run(ctx);
}

}  // namespace cairn::ground
