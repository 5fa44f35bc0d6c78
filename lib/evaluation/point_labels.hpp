// Labelled points against true labels: overlap of each class and of each rock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cairn::evaluation {

// Codes of docs/formats/clouds_and_meshes.md: 0 none, 1 terrain, 2 rock, 3 pedestal, 4 basal contact.
inline constexpr std::size_t kLabels = 5;
inline constexpr std::uint32_t kNoInstance = 0xffffffffU;

// The same points twice: what was found and what is true. All spans of equal length.
struct LabelPairs {
  std::span<const std::uint8_t> label, true_label;         // above 4 counts as 0
  std::span<const std::uint32_t> instance, true_instance;  // kNoInstance = of no rock
};

struct Overlap {
  std::size_t both = 0, found_only = 0, true_only = 0;  // points

  [[nodiscard]] std::optional<double> iou() const;        // both / all three; empty where there is no point
  [[nodiscard]] std::optional<double> dice() const;       // 2 both / (2 both + the others)
  [[nodiscard]] std::optional<double> precision() const;  // both / found
  [[nodiscard]] std::optional<double> recall() const;     // both / true
};

// One true rock and the found one that shares most with it (least id of equals); none where they share no point.
struct RockOverlap {
  std::uint32_t true_id = 0;
  std::optional<std::uint32_t> id;
  Overlap overlap;
  bool matched = false;  // IoU at or above the threshold, one found rock to one true rock
};

struct LabelScores {
  Overlap rock;                              // labels 2 and 4: a basal point lies on the rock or on what bears it
  std::array<Overlap, kLabels> classes;      // each label by itself
  std::vector<RockOverlap> rocks;            // every true rock, ascending id
  std::size_t found_rocks = 0, matched = 0;  // instances with a point of label 2 or 4
  [[nodiscard]] double precision() const;    // matched / found; 0 where none was found
  [[nodiscard]] double recall() const;       // matched / true; 0 where there is none
};

// A rock = points of label 2 or 4 of one instance. Pairs of rocks are matched one to one in the order of their IoU; an
// IoU above one half decides by itself (a point belongs to one rock only). Cost linear in points.
// Throws invalid_argument where the spans differ in length or the threshold is not in 0 < t <= 1.
[[nodiscard]] LabelScores score_labels(const LabelPairs& pairs, double least_iou = 0.5);

}  // namespace cairn::evaluation
