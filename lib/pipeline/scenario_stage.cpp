#include "pipeline/scenario_stage.hpp"

#include <cmath>
#include <numbers>
#include <optional>

#include "base/number_text.hpp"
#include "ground/jump_points.hpp"
#include "io/csv.hpp"
#include "io/movingai.hpp"

namespace cairn::pipeline {
namespace {

// Published lengths have six digits.
constexpr double kSame = 1e-5;
constexpr std::uint64_t kProgressStep = 100;

ground::BlockedBits bits_of(const geometry::Grid<char>& terrain, bool water) {
  geometry::Grid<std::uint8_t> blocked(terrain.geometry, 0);
  for (std::size_t i = 0; i < terrain.values.size(); ++i) {
    const bool free = water ? terrain.values[i] == 'W' : io::is_free_terrain(terrain.values[i]);
    blocked.values[i] = free ? 0 : 1;
  }
  std::vector<std::uint8_t> table(256, 1);
  table[0] = 0;
  return ground::BlockedBits(blocked, table);
}

// Relative to the published length; equal zeros differ by nothing.
double difference(double found, double published) {
  if (found == published) return 0.0;
  return std::abs(found - published) / std::max(published, kSame);
}

}  // namespace

Outcome scenario_stage(const std::filesystem::path& map, const std::filesystem::path& scenario,
                       const std::filesystem::path& csv, base::RunContext& ctx) {
  const auto terrain = io::read_octile_map(map);
  const auto queries = io::read_scenario(scenario, terrain.geometry.rows, terrain.geometry.columns);
  const ground::BlockedBits land = bits_of(terrain, false);
  std::optional<ground::BlockedBits> water;
  std::optional<io::CsvWriter> table;
  if (!csv.empty())
    table.emplace(csv, std::initializer_list<std::string_view>{"line", "bucket", "start_x", "start_y", "goal_x",
                                                               "goal_y", "published_m", "length_m", "expansions"});
  Outcome outcome;
  double largest = 0.0, sum = 0.0, total = 0.0;
  std::uint64_t found = 0, different = 0, expansions = 0, worst = 0;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (i % kProgressStep == 0) ctx.progress("queries", i, queries.size());
    ctx.check_stop();
    const io::ScenarioQuery& query = queries[i];
    const bool swims = terrain.at(query.start.first, query.start.second) == 'W';
    if (swims && !water) water = bits_of(terrain, true);
    const ground::BlockedBits& bits = swims ? *water : land;
    const auto place = [](const std::pair<std::size_t, std::size_t>& cell) {
      return std::pair(static_cast<std::int64_t>(cell.first), static_cast<std::int64_t>(cell.second));
    };
    const auto blocked = [&](const std::pair<std::size_t, std::size_t>& cell) {
      return bits.blocked(place(cell).first + 1, place(cell).second + 1);
    };
    std::string reason = blocked(query.start) ? "start_blocked" : (blocked(query.goal) ? "goal_blocked" : "");
    std::optional<double> length;
    if (reason.empty()) {
      const auto path = ground::jump_path(bits, place(query.start), place(query.goal), ctx);
      expansions += path.expansions;
      if (path.corners.empty()) reason = "no_path";
      else length = static_cast<double>(path.straight) + std::numbers::sqrt2 * static_cast<double>(path.diagonal);
      if (table)
        table->cell(query.line)
            .cell(query.bucket)
            .cell(query.start.second)
            .cell(query.start.first)
            .cell(query.goal.second)
            .cell(query.goal.first)
            .cell(query.optimal)
            .cell(length)
            .cell(path.expansions)
            .end_row();
    }
    if (!length) {
      outcome.rejects.push_back({"query of line " + std::to_string(query.line), reason,
                                 "no path of the published length " + base::to_text(query.optimal)});
      continue;
    }
    ++found;
    total += *length;
    const double relative = difference(*length, query.optimal);
    sum += relative;
    if (relative > kSame) ++different;
    if (relative > largest) {
      largest = relative;
      worst = query.line;
    }
  }
  if (table) table->finish();
  outcome.summary = io::Json::object({{"queries", static_cast<std::int64_t>(queries.size())},
                                      {"found", static_cast<std::int64_t>(found)},
                                      {"largest_relative_difference", largest},
                                      {"largest_difference_line", static_cast<std::int64_t>(worst)},
                                      {"mean_relative_difference", found == 0 ? 0.0 : sum / static_cast<double>(found)},
                                      {"different", static_cast<std::int64_t>(different)},
                                      {"total_length_m", total},
                                      {"expansions", static_cast<std::int64_t>(expansions)},
                                      {"rejects", count_by_reason(outcome.rejects)}});
  return outcome;
}

}  // namespace cairn::pipeline
