#include "ground_case.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "evaluation/statistics.hpp"
#include "pipeline/drive_stage.hpp"

namespace cairn::acceptance {
namespace {

using base::to_fixed;
using io::Json;

std::string text(const Json& line, const char* name) {
  return line.at(name).as_string();
}

// By the vehicle's own reckoning and in truth.
bool arrived(const Json& line) {
  constexpr double kAtGoal_m = 2.0;
  return line.at("arrived").as_bool() && line.at("goal_error_m").as_real() < kAtGoal_m;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

evaluation::Interval interval_of(const std::vector<double>& values) {
  std::vector<std::vector<double>> groups;
  for (const double v : values) groups.push_back({v});
  base::Random random(1, "acceptance ground bootstrap", 0);
  return evaluation::bootstrap(groups, mean_of, random).value_or(evaluation::Interval{});
}

std::string share(std::size_t hits, std::size_t trials) {
  const auto wilson = evaluation::wilson(hits, trials);
  return std::to_string(hits) + "/" + std::to_string(trials) + " (" + to_fixed(100.0 * wilson.low, 0) + ".." +
         to_fixed(100.0 * wilson.high, 0) + " %)";
}

std::string with_interval(const std::vector<double>& values, double factor, int digits) {
  const auto interval = interval_of(values);
  return to_fixed(factor * mean_of(values), digits) + " (" + to_fixed(factor * interval.low, digits) + ".." +
         to_fixed(factor * interval.high, digits) + ")";
}

double most(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

std::vector<double> shortenings(const std::vector<Json>& lines, const std::string& scene, const std::string& variant) {
  std::map<std::int64_t, double> ways, without;
  for (const Json& line : lines)
    if (text(line, "scene") == scene && arrived(line)) {
      if (text(line, "variant") == variant) ways[line.at("seed").as_integer()] = line.at("path_m").as_real();
      if (text(line, "variant") == "no_map") without[line.at("seed").as_integer()] = line.at("path_m").as_real();
    }
  std::vector<double> result;
  for (const auto& [seed, way] : ways)
    if (const auto other = without.find(seed); other != without.end()) result.push_back(1.0 - way / other->second);
  return result;
}

std::string row(const std::vector<Json>& lines, const std::string& scene, const std::string& variant) {
  std::size_t runs = 0, there = 0, clean = 0;
  std::vector<double> ways, times, clearances, rms, worst, periods, longest;
  for (const Json& line : lines) {
    if (text(line, "scene") != scene || text(line, "variant") != variant) continue;
    ++runs;
    clean += line.at("contacts").as_integer() == 0 ? 1U : 0U;
    clearances.push_back(-line.at("least_clearance_m").as_real());
    rms.push_back(line.at("pose_rms_m").as_real());
    worst.push_back(line.at("pose_max_m").as_real());
    periods.push_back(line.at("update_period_mean_s").as_real());
    longest.push_back(line.at("update_period_max_s").as_real());
    if (!arrived(line)) continue;
    ++there;
    ways.push_back(line.at("path_m").as_real());
    times.push_back(line.at("drive_s").as_real());
  }
  if (runs == 0) return "";
  const auto shorter = shortenings(lines, scene, variant);
  return "| " + scene + " | " + variant + " | " + share(there, runs) + " | " + share(clean, runs) + " | " +
         with_interval(ways, 1.0, 1) + " | " + to_fixed(mean_of(times), 1) + " | " +
         (variant == "no_map" ? "-" : with_interval(shorter, 100.0, 1)) + " | " + to_fixed(-most(clearances), 2) +
         " | " + to_fixed(mean_of(rms), 2) + " | " + to_fixed(most(worst), 2) + " | " + to_fixed(mean_of(periods), 2) +
         " | " + to_fixed(most(longest), 2) + " |\n";
}

}  // namespace

const std::vector<std::string>& ground_variants() {
  static const std::vector<std::string> names{"aerial", "no_map", "outage_10", "outage_20"};
  return names;
}

Json ground_case(const simulation::DriveRehearsal& rehearsal, const std::string& scene, const std::string& variant,
                 std::uint64_t seed, base::RunContext& ctx) {
  pipeline::GroundRunOptions options;
  if (variant == "no_map") options.aerial_map = false;
  else if (variant == "outage_10") options.outage_s = 10.0;
  else if (variant == "outage_20") options.outage_s = 20.0;
  else if (variant != "aerial") throw base::Error(base::ErrorCode::invalid_argument, "unknown variant").found(variant);
  const auto record = pipeline::run_ground(rehearsal, options, seed, ctx);
  Json line = Json::object({{"scene", scene}, {"variant", variant}, {"seed", static_cast<std::int64_t>(seed)}});
  const Json drive = pipeline::drive_json(record);
  for (const auto& [key, value] : drive.as_object())
    if (key != "plans") line.set(key, value);
  return line;
}

std::string ground_table(const std::vector<Json>& lines) {
  std::set<std::string> scenes;
  for (const Json& line : lines) scenes.insert(text(line, "scene"));
  std::string table =
      "| scene | variant | arrived | without contact | way, m | time, s | shorter, % | least clearance, m | pose RMS, "
      "m "
      "| pose worst, m | update mean, s | update max, s |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& scene : scenes)
    for (const auto& variant : ground_variants()) table += row(lines, scene, variant);
  return table;
}

Shortening shortening(const std::vector<Json>& lines, const std::string& scene, const std::string& variant) {
  const auto values = shortenings(lines, scene, variant);
  const auto interval = interval_of(values);
  return {values.size(), mean_of(values), interval.low, interval.high};
}

}  // namespace cairn::acceptance
