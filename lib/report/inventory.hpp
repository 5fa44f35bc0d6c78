// Many surveys' rocks as one inventory: the record of each rock, and the tables it is published as.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/time.hpp"
#include "geometry/rigid_transform.hpp"
#include "io/json.hpp"
#include "io/vector_layer.hpp"
#include "survey/manifest.hpp"
#include "survey/rock.hpp"
#include "survey/target.hpp"

namespace cairn::report {

struct InventorySurvey {
  std::string name;                      // "Brighton Beach"
  std::string slug;                      // "brighton-beach": the first part of its rocks' ids
  std::optional<survey::Origin> origin;  // empty = the rocks stand in no known frame: no position is given
  std::string result;                    // the folder's own name, without its path
  std::string version;                   // of the program that made the result; "" = not known
  std::optional<std::int64_t> seed;
};

// A photograph that shows a rock.
struct InventoryPhoto {
  std::string file;          // its name, without the path
  std::string sha256;        // "" = the file is not there
  std::int64_t time_ns = 0;  // on time_base; 0 = not known
  base::TimeBase time_base = base::TimeBase::unknown;
  std::int64_t camera = 0;
  double score = 0.0;                       // of the rock's box in it, 0..1
  geometry::RigidTransform T_world_camera;  // local ENU of the survey
};

using FieldValues = std::vector<std::pair<std::string, std::string>>;  // by field, as written

struct InventoryRock {
  std::string id;          // unique in the inventory, persistent: "brighton-beach-0012"
  std::size_t survey = 0;  // in Inventory::surveys
  survey::Rock rock;       // local ENU of the survey
  std::optional<survey::Target> target;
  std::optional<double> undulation_m;            // of EGM96 at the rock; empty = not known
  std::vector<std::string> aliases, supersedes;  // inventory ids
  std::string revisit_of;                        // the id of the same rock in a survey given before; "" = none
  // Decisions.
  std::string judgement, reviewer, reviewed_utc, review_reason, review_notes;
  // Field notes and values set in review (these go first).
  FieldValues field;
  std::string note_match;                 // "id", "position", or ""
  std::optional<double> note_distance_m;  // of a note joined by position, metres in plan
  std::size_t notes = 0;
  // Evidence.
  std::vector<InventoryPhoto> photos;  // best first
  std::size_t photo_count = 0;         // all that show it
  std::string mesh_file, mesh_sha256;
};

// Public copies: positions are rounded to a grid, and whatever else tells the place is rounded or left out.
struct Protection {
  bool on = false;
  double step_deg = 0.01;      // of latitude and longitude
  double height_step_m = 100;  // of every height above a datum
};

struct Inventory {
  std::vector<InventorySurvey> surveys;
  std::vector<InventoryRock> rocks;       // in the order of their ids within surveys
  std::vector<std::string> note_columns;  // of field notes, those without a column of their own
  Protection protection;
};

// A field that people write: in notes, or by "set" in review.
struct InventoryField {
  std::string name;
  io::ColumnType type = io::ColumnType::text;
  std::string unit, definition;
};
[[nodiscard]] const std::vector<InventoryField>& inventory_fields();
// The field's own name for a column of notes ("status" -> "field_status"); empty where there is no such field.
[[nodiscard]] std::optional<std::string> inventory_field(std::string_view name);
// Empty where `value` fits the field, else what would fit ("a number").
[[nodiscard]] std::string field_problem(std::string_view field, std::string_view value);

// "Brighton Beach, north" -> "brighton-beach-north"; never empty.
[[nodiscard]] std::string slug_of(std::string_view name);
// slug-0012
[[nodiscard]] std::string inventory_id(std::string_view slug, survey::TargetId rock);

// Tables, in this order: inventory (points at the centres of mass), contacts (support polygons; not in a protected
// inventory), tipping_edges, tipping_by_azimuth, uncertainty, photos (at the camera; not in a protected inventory),
// rejects, surveys. Every quantity's unit is in its
// column's name or in Column::unit, its definition in Column::definition. What a grade of not_measurable forbids is
// empty.
[[nodiscard]] std::vector<io::Layer> inventory_layers(const Inventory& inventory);

// One rock as JSON: its row by column name, and its rows of the other tables.
[[nodiscard]] io::Json rock_json(const std::vector<io::Layer>& layers, std::size_t row);

// Text without what could tell a place: numbers of three or more decimals below 180 are rounded to the step, degrees
// and minutes, grid references of six digits and more and web addresses are replaced by "[withheld]".
[[nodiscard]] std::string protected_text(std::string_view text, const Protection& protection);
// One sentence for metadata.
[[nodiscard]] std::string protection_text(const Protection& protection);

// Where a rock is: its centre of mass, else the centre of its target.
[[nodiscard]] std::optional<geometry::Vec3> place_of(const survey::Rock& rock,
                                                     const std::optional<survey::Target>& target);

}  // namespace cairn::report
