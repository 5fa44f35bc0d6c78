#include "evaluation/point_labels.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::evaluation {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kRock = 2, kBasal = 4;

std::optional<double> share(std::size_t part, std::size_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

std::size_t code(std::uint8_t label) {
  return label < kLabels ? label : 0;
}

bool is_rock(std::size_t label) {
  return label == kRock || label == kBasal;
}

void count(Overlap& overlap, bool found, bool in_truth) {
  overlap.both += found && in_truth ? 1 : 0;
  overlap.found_only += found && !in_truth ? 1 : 0;
  overlap.true_only += !found && in_truth ? 1 : 0;
}

void check(const LabelPairs& pairs, double least_iou) {
  const std::size_t n = pairs.true_label.size();
  for (const std::size_t size : {pairs.label.size(), pairs.instance.size(), pairs.true_instance.size()})
    if (size != n)
      throw Error(ErrorCode::invalid_argument, "labels and true labels are not of the same points")
          .found(std::to_string(size))
          .allowed(std::to_string(n));
  if (!(least_iou > 0.0 && least_iou <= 1.0))
    throw Error(ErrorCode::invalid_argument, "the least IoU is out of range")
        .found(base::to_text(least_iou))
        .allowed("above 0, at most 1");
}

// Points of each instance on either side, and of each pair of instances.
struct Counts {
  std::map<std::uint32_t, std::size_t> found, in_truth;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> both;  // (true, found)
};

Overlap overlap_of(const Counts& counts, std::uint32_t truth, std::uint32_t found, std::size_t both) {
  return {both, counts.found.at(found) - both, counts.in_truth.at(truth) - both};
}

std::vector<RockOverlap> overlaps(const Counts& counts, double least_iou) {
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> order;  // -IoU, true, found
  for (const auto& [ids, both] : counts.both)
    order.emplace_back(-*overlap_of(counts, ids.first, ids.second, both).iou(), ids.first, ids.second);
  std::sort(order.begin(), order.end());
  std::map<std::uint32_t, RockOverlap> rocks;
  for (const auto& [id, points] : counts.in_truth) rocks[id] = {id, std::nullopt, {0, 0, points}, false};
  std::set<std::uint32_t> taken;
  for (const auto& [minus_iou, truth, found] : order) {
    RockOverlap& rock = rocks.at(truth);
    if (!rock.id) {
      rock.id = found;
      rock.overlap = overlap_of(counts, truth, found, counts.both.at({truth, found}));
    }
    if (rock.matched || -minus_iou < least_iou || !taken.insert(found).second) continue;
    rock.id = found;
    rock.overlap = overlap_of(counts, truth, found, counts.both.at({truth, found}));
    rock.matched = true;
  }
  std::vector<RockOverlap> result;
  for (auto& [id, rock] : rocks) result.push_back(rock);
  return result;
}

}  // namespace

std::optional<double> Overlap::iou() const {
  return share(both, both + found_only + true_only);
}

std::optional<double> Overlap::dice() const {
  return share(2 * both, 2 * both + found_only + true_only);
}

std::optional<double> Overlap::precision() const {
  return share(both, both + found_only);
}

std::optional<double> Overlap::recall() const {
  return share(both, both + true_only);
}

double LabelScores::precision() const {
  return share(matched, found_rocks).value_or(0.0);
}

double LabelScores::recall() const {
  return share(matched, rocks.size()).value_or(0.0);
}

LabelScores score_labels(const LabelPairs& pairs, double least_iou) {
  check(pairs, least_iou);
  LabelScores scores;
  Counts counts;
  for (std::size_t i = 0; i < pairs.label.size(); ++i) {
    const std::size_t found = code(pairs.label[i]), truth = code(pairs.true_label[i]);
    for (std::size_t k = 0; k < kLabels; ++k) count(scores.classes[k], found == k, truth == k);
    count(scores.rock, is_rock(found), is_rock(truth));
    const bool found_one = is_rock(found) && pairs.instance[i] != kNoInstance;
    const bool true_one = is_rock(truth) && pairs.true_instance[i] != kNoInstance;
    if (found_one) ++counts.found[pairs.instance[i]];
    if (true_one) ++counts.in_truth[pairs.true_instance[i]];
    if (found_one && true_one) ++counts.both[{pairs.true_instance[i], pairs.instance[i]}];
  }
  scores.rocks = overlaps(counts, least_iou);
  scores.found_rocks = counts.found.size();
  for (const auto& rock : scores.rocks) scores.matched += rock.matched ? 1 : 0;
  return scores;
}

}  // namespace cairn::evaluation
