#include "experiment_table.hpp"

#include <cmath>

#include "base/number_text.hpp"
#include "base/random.hpp"
#include "evaluation/statistics.hpp"

namespace cairn::acceptance {
namespace {

using base::to_fixed;
using evaluation::Interval;
using io::Json;

struct Counts {
  std::size_t tp = 0, fp = 0, fn = 0;

  void add(const Json& json) {
    const auto count = [&](const char* name) { return static_cast<std::size_t>(json.at(name).as_integer()); };
    tp += count("tp");
    fp += count("fp");
    fn += count("fn");
  }
};

std::string percent(std::size_t part, std::size_t whole) {
  if (whole == 0) return "-";
  const Interval i = evaluation::wilson(part, whole);
  return to_fixed(100.0 * static_cast<double>(part) / static_cast<double>(whole), 1) + " (" + to_fixed(100 * i.low, 1) +
         " to " + to_fixed(100 * i.high, 1) + ")";
}

std::string row(const std::string& name, const Counts& c, const std::string& paper) {
  return "| " + name + " | " + std::to_string(c.tp) + " | " + std::to_string(c.fp) + " | " + std::to_string(c.fn) +
         " | " + percent(c.tp, c.tp + c.fp) + " | " + percent(c.tp, c.tp + c.fn) + " | " + paper + " |\n";
}

constexpr std::pair<const char*, const char*> kBiases[] = {
    {"errors_raw", "as recorded"},
    {"errors", "less the flight's mean pose bias"},
    {"errors_target_bias", "less the mean pose bias of its own frames"}};

// Values of one kind, seed by seed.
using BySeed = std::vector<std::vector<double>>;

template <typename Figure>
BySeed collect(const std::vector<Json>& lines, const char* errors, const char* estimator, Figure&& figure) {
  BySeed values;
  for (const auto& line : lines) {
    values.emplace_back();
    for (const auto& target : line.at("modes").at("robust").at(errors).at(estimator).as_array())
      if (const auto value = figure(target)) values.back().push_back(*value);
  }
  return values;
}

std::string with_interval(const BySeed& values, double q, int decimals) {
  std::vector<double> pooled;
  for (const auto& seed : values) pooled.insert(pooled.end(), seed.begin(), seed.end());
  const auto value = evaluation::quantile(pooled, q);
  if (!value) return "-";
  base::Random random(1, "bootstrap", 0);
  const auto i = evaluation::bootstrap(
      values, [q](std::vector<double> v) { return evaluation::quantile(std::move(v), q).value_or(0.0); }, random);
  return to_fixed(*value, decimals) + " (" + to_fixed(i->low, decimals) + " to " + to_fixed(i->high, decimals) + ")";
}

std::optional<double> member(const Json& target, const char* name) {
  const Json* value = target.find(name);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  return value->as_real();
}

std::string centre_rows(const std::vector<Json>& lines, const char* errors, const char* label) {
  std::string text;
  for (const char* estimator : {"filter", "refined"}) {
    const auto figure = [&](auto&& f) {
      const auto values =
          collect(lines, errors, estimator, [&](const Json& t) { return std::optional(f(t.at("error_m").as_vec3())); });
      return with_interval(values, 0.5, 3) + " | " + with_interval(values, 0.95, 3);
    };
    text += std::string("| ") + estimator + ", " + label + " | " + figure([](const auto& e) { return e.norm(); }) +
            " | " + figure([](const auto& e) { return e.template head<2>().norm(); }) + " | " +
            figure([](const auto& e) { return std::abs(e.z()); }) + " |\n";
  }
  return text;
}

// One target a seed, drawn by the seed: targets of one flight share its poses' errors.
std::string nees_row(const std::vector<Json>& lines, const char* errors, const char* estimator, const char* label) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const auto& line : lines) {
    const auto& targets = line.at("modes").at("robust").at(errors).at(estimator).as_array();
    if (targets.empty()) continue;
    base::Random random(static_cast<std::uint64_t>(line.at("seed").as_integer()), "one target a seed", 0);
    const auto nees = member(targets[random.below(targets.size())], "nees");
    if (!nees) continue;
    sum += *nees;
    ++count;
  }
  if (count == 0) return "";
  const Interval band = evaluation::mean_nees_band(count);
  return std::string("| ") + estimator + ", " + label + " | " + std::to_string(count) + " | " +
         to_fixed(sum / static_cast<double>(count), 2) + " | " + to_fixed(band.low, 2) + " to " +
         to_fixed(band.high, 2) + " |\n";
}

}  // namespace

std::string pooled_tables(const std::vector<Json>& all, const std::string& grade) {
  std::vector<Json> lines;
  for (const auto& line : all)
    if (line.at("grade").as_string() == grade) lines.push_back(line);
  if (lines.empty()) return "";
  std::string text = "Poses `" + grade + "`, " + std::to_string(lines.size()) + " seeds pooled.\n\n";
  text +=
      "| stage | true | false | missed | precision %, 95 % interval | recall %, 95 % interval | paper A, Table I |\n";
  text += "|---|---|---|---|---|---|---|\n";
  Counts detector;
  for (const auto& line : lines) detector.add(line.at("detector"));
  text += row("detections (IoU > 0.5)", detector, "88.7 / 78.3");
  const std::vector<std::pair<const char*, const char*>> stages{
      {"generated", "84.6 / 100"}, {"converging", "88.9 / 100"}, {"converged", "100 / 87.5"}, {"mapped", "100 / 100"}};
  for (const char* mode : {"robust", "paper", "paper_coasted"})
    for (const auto& [stage, published] : stages) {
      Counts counts;
      std::size_t seeds = 0;
      for (const auto& line : lines)
        if (const Json* result = line.at("modes").find(mode); result != nullptr) {
          counts.add(result->at("stages").at(stage));
          ++seeds;
        }
      if (seeds > 0 && counts.tp + counts.fp > 0) text += row(std::string(mode) + ", " + stage, counts, published);
    }
  std::erase_if(lines, [](const Json& line) { return line.at("modes").find("robust") == nullptr; });
  if (lines.empty()) return text;
  text += "\n| centre error, m (robust) | 3-D median | 95 % | horizontal median | 95 % | vertical median | 95 % |\n";
  text += "|---|---|---|---|---|---|---|\n";
  for (const auto& [errors, label] : kBiases) text += centre_rows(lines, errors, label);
  text +=
      "\n| cylinder (robust) | share of the exposed surface inside, median | volume over the smallest, median | IoU, "
      "median |\n";
  text += "|---|---|---|---|\n";
  for (const char* estimator : {"filter", "refined"}) {
    const auto figure = [&](const char* name) {
      return with_interval(
          collect(lines, "errors_target_bias", estimator, [&](const Json& t) { return member(t, name); }), 0.5, 3);
    };
    text += std::string("| ") + estimator + " | " + figure("contained") + " | " + figure("volume_ratio") + " | " +
            figure("iou") + " |\n";
  }
  text += "\n| normalised error squared, one target a seed | targets | mean | 95 % band |\n|---|---|---|---|\n";
  for (const char* estimator : {"filter", "refined"})
    for (const auto& [errors, label] : kBiases) text += nees_row(lines, errors, estimator, label);
  return text;
}

}  // namespace cairn::acceptance
