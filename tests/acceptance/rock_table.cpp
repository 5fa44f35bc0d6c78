#include "rock_table.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "base/number_text.hpp"
#include "base/random.hpp"
#include "evaluation/statistics.hpp"
#include "support/rock_scan.hpp"

namespace cairn::acceptance {
namespace {

using base::to_fixed;
using evaluation::Interval;
using io::Json;
using Lines = std::vector<const Json*>;

std::optional<double> number(const Json* json, std::initializer_list<const char*> path) {
  for (const char* key : path) {
    if (json == nullptr || !json->is_object()) return std::nullopt;
    json = json->find(key);
  }
  if (json == nullptr || !json->is_number()) return std::nullopt;
  return json->as_real();
}

// The one true rock's entry among the scores.
const Json* rock_of(const Json& line) {
  const Json* scores = line.find("scores");
  if (scores == nullptr || scores->at("rocks").as_array().empty()) return nullptr;
  return &scores->at("rocks").as_array().front();
}

using Figure = std::function<std::optional<double>(const Json&)>;

Figure of_rock(std::initializer_list<const char*> path, double scale = 1.0) {
  const std::vector<const char*> keys(path);
  return [keys, scale](const Json& line) -> std::optional<double> {
    const Json* json = rock_of(line);
    for (const char* key : keys) {
      if (json == nullptr || !json->is_object()) return std::nullopt;
      json = json->find(key);
    }
    if (json == nullptr || !json->is_number()) return std::nullopt;
    return scale * json->as_real();
  };
}

Figure magnitude(Figure figure) {
  return [figure = std::move(figure)](const Json& line) -> std::optional<double> {
    const auto value = figure(line);
    return value ? std::optional(std::abs(*value)) : std::nullopt;
  };
}

std::optional<double> contact_spacings(const Json& line) {
  const auto mean = number(rock_of(line), {"contact", "mean_m"});
  return mean ? std::optional(*mean / line.at("spacing_m").as_real()) : std::nullopt;
}

std::optional<double> alpha_share(const Json& line) {
  const auto error = number(rock_of(line), {"alpha", "error_deg"});
  const auto truth = number(rock_of(line), {"alpha", "true_rim_deg"});
  return error && truth ? std::optional(100.0 * std::abs(*error) / *truth) : std::nullopt;
}

// A rock that was not found has an IoU of whatever it has, 0 at least.
std::optional<double> iou(const Json& line) {
  const auto value = number(rock_of(line), {"iou"});
  return value ? value : std::optional(0.0);
}

std::vector<double> values_of(const Lines& lines, const Figure& figure) {
  std::vector<double> values;
  for (const Json* line : lines)
    if (const auto value = figure(*line)) values.push_back(*value);
  return values;
}

std::string with_interval(const Lines& lines, const Figure& figure, double q, int decimals) {
  const auto values = values_of(lines, figure);
  const auto value = evaluation::quantile(values, q);
  if (!value) return "-";
  std::vector<std::vector<double>> groups;
  for (const double v : values) groups.push_back({v});
  base::Random random(1, "bootstrap", 0);
  const auto i = evaluation::bootstrap(
      groups, [q](std::vector<double> v) { return evaluation::quantile(std::move(v), q).value_or(0.0); }, random);
  return to_fixed(*value, decimals) + " (" + to_fixed(i->low, decimals) + " to " + to_fixed(i->high, decimals) + ")";
}

std::string plain(const Lines& lines, const Figure& figure, double q, int decimals) {
  const auto value = evaluation::quantile(values_of(lines, figure), q);
  return value ? to_fixed(*value, decimals) : "-";
}

std::string coverage(const Lines& lines) {
  std::size_t hits = 0, trials = 0;
  for (const Json* line : lines) {
    const Json* rock = rock_of(*line);
    const Json* alpha = rock == nullptr ? nullptr : rock->find("alpha");
    if (alpha == nullptr || !alpha->is_object()) continue;
    const Json* holds = alpha->find("interval_90_holds_truth");
    if (holds == nullptr) continue;
    ++trials;
    if (holds->as_bool()) ++hits;
  }
  if (trials == 0) return "-";
  const Interval i = evaluation::wilson(hits, trials);
  return to_fixed(100.0 * static_cast<double>(hits) / static_cast<double>(trials), 0) + " (" +
         to_fixed(100 * i.low, 0) + " to " + to_fixed(100 * i.high, 0) + ")";
}

// The headline interval [inner, outer] against the bearing, which is what holds the rock.
std::string bearing_bounded(const Lines& lines) {
  std::size_t hits = 0, trials = 0;
  for (const Json* line : lines) {
    const Json* rock = rock_of(*line);
    const auto inner = number(rock, {"alpha", "inner_deg"}), outer = number(rock, {"alpha", "outer_deg"}),
               truth = number(rock, {"alpha", "true_bearing_deg"});
    if (!outer || !truth) continue;
    ++trials;
    if (inner.value_or(0.0) <= *truth && *truth <= *outer) ++hits;
  }
  if (trials == 0) return "-";
  return to_fixed(100.0 * static_cast<double>(hits) / static_cast<double>(trials), 0);
}

std::string table_head() {
  return "| rocks | n | failed | IoU median | IoU 5 % | contact, spacings | alpha error, deg | alpha error, % | alpha "
         "error 95 %, deg | alpha bias, deg | volume error, % | volume bias, % | 90 % interval holds, % | bearing in "
         "[inner, outer], % |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
}

std::string table_row(const std::string& name, const Lines& lines) {
  if (lines.empty()) return {};
  const auto failed = std::count_if(lines.begin(), lines.end(), [](const Json* l) {
    return !l->at("failed").as_string().empty() || !number(rock_of(*l), {"alpha", "error_deg"});
  });
  const Figure alpha = of_rock({"alpha", "error_deg"}), volume = of_rock({"volume", "error_share"}, 100.0);
  return "| " + name + " | " + std::to_string(lines.size()) + " | " + std::to_string(failed) + " | " +
         with_interval(lines, iou, 0.5, 3) + " | " + plain(lines, iou, 0.05, 3) + " | " +
         with_interval(lines, contact_spacings, 0.5, 2) + " | " + with_interval(lines, magnitude(alpha), 0.5, 2) +
         " | " + plain(lines, alpha_share, 0.5, 1) + " | " + with_interval(lines, magnitude(alpha), 0.95, 2) + " | " +
         plain(lines, alpha, 0.5, 2) + " | " + with_interval(lines, magnitude(volume), 0.5, 2) + " | " +
         plain(lines, volume, 0.5, 2) + " | " + coverage(lines) + " | " + bearing_bounded(lines) + " |\n";
}

Lines chosen(const Lines& lines, const std::function<bool(const Json&)>& wanted) {
  Lines result;
  for (const Json* line : lines)
    if (wanted(*line)) result.push_back(line);
  return result;
}

bool held_out(const Json& line) {
  return line.at("family").as_string() == testing::kHeldOutFamily;
}

std::string accuracy_table(const Lines& rocks) {
  if (rocks.empty()) return {};
  const Lines tuned = chosen(rocks, [](const Json& l) { return !held_out(l); });
  std::string text = "Simulated rocks\n\n" + table_head() + table_row("all families tuned on", tuned) +
                     table_row("held-out family (" + std::string(testing::kHeldOutFamily) + ")",
                               chosen(rocks, [](const Json& l) { return held_out(l); }));
  for (const char* member : {"family", "hiding"}) {
    std::map<std::string, Lines> groups;
    for (const Json* line : tuned) groups[line->at(member).as_string()].push_back(line);
    for (const auto& [name, lines] : groups) text += table_row(std::string(member) + " " + name, lines);
  }
  const std::pair<double, double> shares[] = {{0.0, 0.02}, {0.02, 0.1}, {0.1, 0.3}, {0.3, 1.01}};
  for (const auto& [low, high] : shares)
    text +=
        table_row("contact hidden " + to_fixed(100 * low, 0) + " to " + to_fixed(100 * std::min(high, 1.0), 0) + " %",
                  chosen(rocks, [lo = low, hi = high](const Json& l) {
                    const double share = l.at("hidden_share").as_real();
                    return share >= lo && share < hi;
                  }));
  text += "\nCPU seconds a rock, median: ";
  for (const char* step : {"segment", "surface", "fragility"})
    text += std::string(step) + " " +
            plain(
                rocks, [step](const Json& l) { return number(l.find("cpu_s"), {step}); }, 0.5, 2) +
            ", ";
  return text + "points " +
         plain(
             rocks, [](const Json& l) { return number(&l, {"points"}); }, 0.5, 0) +
         "\n\n";
}

std::string repeat_table(const std::map<std::int64_t, Lines>& by_seed) {
  std::string text;
  for (const auto& [seed, lines] : by_seed) {
    const auto values = values_of(lines, of_rock({"alpha", "alpha_deg"}));
    if (values.size() < 5) continue;
    double mean = 0.0, square = 0.0;
    for (const double v : values) mean += v / static_cast<double>(values.size());
    for (const double v : values) square += (v - mean) * (v - mean) / static_cast<double>(values.size() - 1);
    if (text.empty())
      text =
          "Repeatability: one rock, sampled again\n\n| seed | family | hiding | samplings | true alpha on the rim, "
          "deg | mean, deg | coefficient of variation, % |\n|---|---|---|---|---|---|---|\n";
    text += "| " + std::to_string(seed) + " | " + lines.front()->at("family").as_string() + " | " +
            lines.front()->at("hiding").as_string() + " | " + std::to_string(values.size()) + " | " +
            plain(lines, of_rock({"alpha", "true_rim_deg"}), 0.5, 2) + " | " + to_fixed(mean, 2) + " | " +
            to_fixed(100.0 * std::sqrt(square) / mean, 2) + " |\n";
  }
  return text.empty() ? text : text + "\n";
}

std::string share_text(std::size_t hits, std::size_t trials) {
  if (trials == 0) return "-";
  const Interval i = evaluation::wilson(hits, trials);
  return to_fixed(100.0 * static_cast<double>(hits) / static_cast<double>(trials), 1) + " (" +
         to_fixed(100 * i.low, 1) + " to " + to_fixed(100 * i.high, 1) + ")";
}

std::string scene_table(const Lines& scenes) {
  if (scenes.empty()) return {};
  std::size_t in_truth = 0, found = 0, matched = 0, failed = 0;
  for (const Json* line : scenes) {
    const Json* scores = line->find("scores");
    if (scores == nullptr) {
      ++failed;
      continue;
    }
    const auto count = [&](const char* name) {
      return static_cast<std::size_t>(scores->at("instances").at(name).as_integer());
    };
    in_truth += count("true");
    found += count("found");
    matched += count("matched");
  }
  return "Scenes of many rocks, unguided\n\n| scenes | failed | rocks | found | matched at IoU 0.5 | precision, % | "
         "recall, % | CPU s a scene |\n|---|---|---|---|---|---|---|---|\n| " +
         std::to_string(scenes.size()) + " | " + std::to_string(failed) + " | " + std::to_string(in_truth) + " | " +
         std::to_string(found) + " | " + std::to_string(matched) + " | " + share_text(matched, found) + " | " +
         share_text(matched, in_truth) + " | " +
         plain(
             scenes, [](const Json& l) { return number(l.find("cpu_s"), {"segment"}); }, 0.5, 1) +
         " |\n\n";
}

}  // namespace

std::string rock_tables(const std::vector<Json>& lines) {
  Lines rocks, scenes;
  std::map<std::int64_t, Lines> by_seed;
  for (const Json& line : lines) {
    if (line.at("kind").as_string() == "scene") {
      scenes.push_back(&line);
      continue;
    }
    by_seed[line.at("seed").as_integer()].push_back(&line);
    if (line.at("sampling").as_integer() == 0) rocks.push_back(&line);
  }
  return accuracy_table(rocks) + repeat_table(by_seed) + scene_table(scenes);
}

}  // namespace cairn::acceptance
