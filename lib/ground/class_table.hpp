// What a detected class means to a ground vehicle, and what its objects look like.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/options.hpp"
#include "survey/obstacle.hpp"

namespace cairn::ground {

struct ClassTable {
  // Comma-separated, compared without case. Paper B (B4): cones and bushes are obstacles; trees are seen but ignored,
  // because the vehicle passes below the crown; the vehicle itself is none.
  std::string obstacle_classes = "cone,bush,boulder,rock,pbr,car,wall,bench,picnic_table,table,fence,pole";
  std::string ignored_classes = "tree";
  std::string vehicle_classes = "ugv";
  // class:shape:height:sigma, comma-separated; shape = cylinder, cone or ball; height in metres ("0.7m") or as a
  // multiple of the width ("0.7x"); sigma of the height's logarithm. "*" = every other class. The cone is paper B's
  // (380 x 380 x 700 mm); the others are ours.
  std::string class_shapes =
      "cone:cone:0.7m:0.3,bush:ball:0.9x:0.4,tree:ball:1.5x:0.5,boulder:ball:0.7x:0.4,rock:ball:0.7x:0.4,"
      "pbr:ball:1x:0.5,car:cylinder:1.5m:0.2,wall:cylinder:1.2m:0.5,bench:cylinder:0.8m:0.3,"
      "picnic_table:cylinder:0.75m:0.2,table:cylinder:0.75m:0.2,fence:cylinder:1.2m:0.4,pole:cylinder:3m:0.7,"
      "ugv:cylinder:0.6m:0.4,*:cylinder:0.7x:0.6";

  void visit(base::OptionVisitor& visitor);
};

// Kind of a class by the tables; empty for a class in none of them (to be taken as an obstacle, with a warning).
[[nodiscard]] std::optional<survey::ObstacleKind> kind_of_class(std::string_view object_class, const ClassTable& table);

enum class Shape { cylinder, cone, ball };

// What is assumed of an object of which one image is known.
struct ObjectModel {
  Shape shape = Shape::cylinder;
  bool height_by_width = true;  // `height` is a multiple of the width, else metres
  double height = 0.7;
  double sigma_log_height = 0.6;     // of the height's natural logarithm
  double base_above_ground_m = 0.0;  // foot above the ground: an object on a table or a roof
  bool vehicle = false;              // handed through to the result
};

// Model of a class; the entry "*" (else the struct's defaults) for classes that have none.
// Throws invalid_argument for an entry that cannot be read, with the entry.
[[nodiscard]] ObjectModel model_of_class(std::string_view object_class, const ClassTable& table);

}  // namespace cairn::ground
