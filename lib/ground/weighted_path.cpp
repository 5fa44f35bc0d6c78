#include "ground/weighted_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <numbers>

namespace cairn::ground {
namespace {

using geometry::Grid;

constexpr double kDiagonal = std::numbers::sqrt2;
constexpr std::uint64_t kStopInterval = 1 << 16;
// Distances are kept with this added, so that zero means "not reached".
constexpr double kOffset = 1.0;

struct Move {
  std::int64_t row, column;
  double length;  // cells
};
// Straight moves first: north, west, east, south; then the diagonals between them.
constexpr std::array<Move, 8> kMoves{{{-1, 0, 1.0},
                                      {0, -1, 1.0},
                                      {0, 1, 1.0},
                                      {1, 0, 1.0},
                                      {-1, -1, kDiagonal},
                                      {-1, 1, kDiagonal},
                                      {1, -1, kDiagonal},
                                      {1, 1, kDiagonal}}};
// The two straight moves that a diagonal needs open.
constexpr std::array<std::array<std::size_t, 2>, 4> kBeside{{{0, 1}, {0, 2}, {3, 1}, {3, 2}}};

// Zeroed pages that the system hands out on first touch, so that a short path over a large map stays cheap.
template <typename T>
class ZeroedPages {
 public:
  explicit ZeroedPages(std::size_t count) : values_(static_cast<T*>(std::calloc(count, sizeof(T)))) {
    if (values_ == nullptr) throw std::bad_alloc();
  }
  T& operator[](std::int64_t i) { return values_.get()[i]; }
  const T& operator[](std::int64_t i) const { return values_.get()[i]; }

 private:
  struct Free {
    void operator()(T* p) const { std::free(p); }
  };
  std::unique_ptr<T[], Free> values_;
};

// Cells waiting, by estimate. Estimates of cells pushed lie within `span` of the bucket being emptied.
class Buckets {
 public:
  struct Entry {
    std::int64_t index;
    double travelled;
  };
  Buckets(double lowest, double span)
      : width_(std::max(kNarrowest, span / kMost)),
        lowest_(lowest),
        ring_(static_cast<std::size_t>(std::ceil(span / width_)) + 2) {}

  void push(double estimate, const Entry& entry) {
    // Rounding may put an estimate a hair below the bucket in work.
    const auto wanted = static_cast<std::int64_t>(std::max(0.0, (estimate - lowest_) / width_));
    ring_[static_cast<std::size_t>(std::max(wanted, current_)) % ring_.size()].push_back(entry);
    ++waiting_;
  }
  // Empty = none waits.
  [[nodiscard]] bool empty() const { return waiting_ == 0; }
  Entry pop() {
    while (ring_[at_].empty()) {
      ++current_;
      at_ = at_ + 1 == ring_.size() ? 0 : at_ + 1;
    }
    const Entry entry = ring_[at_].back();
    ring_[at_].pop_back();
    --waiting_;
    return entry;
  }
  // No cell waiting has an estimate below this, once the bucket in work is the one given by pop().
  [[nodiscard]] double floor() const { return lowest_ + width_ * static_cast<double>(current_); }

 private:
  static constexpr double kNarrowest = 0.25;  // cells
  static constexpr double kMost = 4096.0;     // buckets
  double width_, lowest_;
  std::int64_t current_ = 0;
  std::size_t at_ = 0, waiting_ = 0;
  std::vector<std::vector<Entry>> ring_;
};

class Search {
 public:
  Search(const Grid<std::uint8_t>& cost, const StepFactors& factors)
      : columns_(static_cast<std::int64_t>(cost.geometry.columns) + 2),
        padded_(cost.geometry.columns + 2, cost.geometry.rows + 2, cost),
        travelled_((cost.geometry.columns + 2) * (cost.geometry.rows + 2)) {
    for (std::size_t i = 0; i < 256; ++i) half_[i] = 0.5 * factors[i];
    for (std::size_t m = 0; m < 8; ++m) step_[m] = kMoves[m].row * columns_ + kMoves[m].column;
    // A value that is blocked, for the border.
    std::size_t border = 0;
    while (border < 255 && factors[border] > 0.0) ++border;
    padded_.set_border(static_cast<std::uint8_t>(border));
    half_[border] = 0.0;
    least_ = most_ = 0.0;
    std::array<bool, 256> present{};
    for (const std::uint8_t value : cost.values) present[value] = true;
    for (std::size_t i = 0; i < 256; ++i) {
      if (!present[i] || !(factors[i] > 0.0)) continue;
      least_ = least_ > 0.0 ? std::min(least_, factors[i]) : factors[i];
      most_ = std::max(most_, factors[i]);
    }
  }

  WeightedPath run(std::pair<std::int64_t, std::int64_t> start, std::pair<std::int64_t, std::int64_t> goal,
                   base::RunContext& ctx) {
    WeightedPath result;
    goal_row_ = goal.first + 1;
    goal_column_ = goal.second + 1;
    const std::int64_t source = (start.first + 1) * columns_ + start.second + 1;
    const std::int64_t target = goal_row_ * columns_ + goal_column_;
    Buckets open(estimate(start.first + 1, start.second + 1) + kOffset, kDiagonal * (most_ + least_) + 1.0);
    travelled_[source] = kOffset;
    open.push(estimate(start.first + 1, start.second + 1) + kOffset, {source, kOffset});
    while (!open.empty()) {
      const Buckets::Entry entry = open.pop();
      if (travelled_[target] > 0.0 && open.floor() >= travelled_[target]) break;
      if (entry.travelled > travelled_[entry.index]) continue;
      if (++result.expansions % kStopInterval == 0) ctx.check_stop();
      if (entry.index == target) continue;
      expand(entry, open);
    }
    if (travelled_[target] == 0.0) return result;
    result.weighted = travelled_[target] - kOffset;
    trace(source, target, result);
    return result;
  }

 private:
  // The map within a border of blocked cells.
  class Padded {
   public:
    Padded(std::size_t columns, std::size_t rows, const Grid<std::uint8_t>& cost)
        : columns_(columns), rows_(rows), values_(columns * rows) {
      for (std::size_t r = 0; r + 2 < rows; ++r)
        std::copy_n(&cost.values[r * (columns - 2)], columns - 2, &values_[(r + 1) * columns + 1]);
    }
    void set_border(std::uint8_t value) {
      std::fill_n(values_.begin(), columns_, value);
      std::fill_n(values_.end() - static_cast<std::ptrdiff_t>(columns_), columns_, value);
      for (std::size_t r = 0; r < rows_; ++r) values_[r * columns_] = values_[r * columns_ + columns_ - 1] = value;
    }
    std::uint8_t operator[](std::int64_t i) const { return values_[static_cast<std::size_t>(i)]; }

   private:
    std::size_t columns_, rows_;
    std::vector<std::uint8_t> values_;
  };

  [[nodiscard]] double estimate(std::int64_t row, std::int64_t column) const {
    const auto a = static_cast<double>(std::abs(row - goal_row_));
    const auto b = static_cast<double>(std::abs(column - goal_column_));
    return least_ * (std::max(a, b) + (kDiagonal - 1.0) * std::min(a, b));
  }

  // Half factors of the eight neighbours, 0 where the move is not open.
  [[nodiscard]] std::array<double, 8> open_moves(std::int64_t index) const {
    std::array<double, 8> there;
    for (std::size_t m = 0; m < 8; ++m) there[m] = half_[padded_[index + step_[m]]];
    for (std::size_t d = 0; d < 4; ++d)
      if (there[kBeside[d][0]] == 0.0 || there[kBeside[d][1]] == 0.0) there[4 + d] = 0.0;
    return there;
  }

  void expand(const Buckets::Entry& entry, Buckets& open) {
    const std::int64_t row = entry.index / columns_, column = entry.index - row * columns_;
    const double here = half_[padded_[entry.index]];
    const std::array<double, 8> there = open_moves(entry.index);
    for (std::size_t m = 0; m < 8; ++m) {
      if (there[m] == 0.0) continue;
      const std::int64_t next = entry.index + step_[m];
      const double travelled = entry.travelled + kMoves[m].length * (here + there[m]);
      double& known = travelled_[next];
      if (known != 0.0 && known <= travelled) continue;
      known = travelled;
      open.push(travelled + estimate(row + kMoves[m].row, column + kMoves[m].column), {next, travelled});
    }
  }

  // Backwards, each time to the neighbour by which the way is shortest; the first of kMoves where several are.
  void trace(std::int64_t source, std::int64_t target, WeightedPath& result) const {
    std::int64_t at = target;
    for (;;) {
      result.cells.emplace_back(at / columns_ - 1, at % columns_ - 1);
      if (at == source) break;
      const double here = half_[padded_[at]];
      const std::array<double, 8> there = open_moves(at);
      double least = std::numeric_limits<double>::infinity();
      std::int64_t before = source;
      for (std::size_t m = 0; m < 8; ++m) {
        const std::int64_t from = at + step_[m];
        if (there[m] == 0.0 || travelled_[from] == 0.0) continue;
        const double travelled = travelled_[from] + kMoves[m].length * (there[m] + here);
        if (travelled >= least) continue;
        least = travelled;
        before = from;
      }
      at = before;
    }
    std::reverse(result.cells.begin(), result.cells.end());
  }

  std::int64_t columns_, goal_row_ = 0, goal_column_ = 0;
  Padded padded_;
  ZeroedPages<double> travelled_;
  std::array<double, 256> half_{};
  std::array<std::int64_t, 8> step_{};
  double least_ = 0.0, most_ = 0.0;
};

}  // namespace

WeightedPath weighted_path(const Grid<std::uint8_t>& cost, const StepFactors& factors,
                           std::pair<std::int64_t, std::int64_t> start, std::pair<std::int64_t, std::int64_t> goal,
                           base::RunContext& ctx) {
  return Search(cost, factors).run(start, goal, ctx);
}

}  // namespace cairn::ground
