#include "report/layer_table.hpp"

#include <initializer_list>

#include "base/error.hpp"

namespace cairn::report {
namespace {

using io::Column;
using io::ColumnType;
using io::GeometryKind;

Column integer(const char* name, const char* definition) {
  return {name, ColumnType::integer, "", definition};
}
Column real(const char* name, const char* unit, const char* definition) {
  return {name, ColumnType::real, unit, definition};
}
Column text(const char* name, const char* definition) {
  return {name, ColumnType::text, "", definition};
}
Column boolean(const char* name, const char* definition) {
  return {name, ColumnType::boolean, "", definition};
}

// Where a record is: on Earth, and in the survey's local frame.
std::vector<Column> position_columns() {
  return {real("latitude_deg", "deg", "WGS84 latitude"),
          real("longitude_deg", "deg", "WGS84 longitude"),
          real("height_m", "m", "height, of the type that height_type names"),
          text("height_type", "what height_m and the coordinates' z are measured from"),
          real("east_m", "m", "local frame: east of the survey's origin"),
          real("north_m", "m", "local frame: north of the survey's origin"),
          real("up_m", "m", "local frame: up from the survey's origin")};
}

std::vector<Column> joined(std::initializer_list<std::vector<Column>> parts) {
  std::vector<Column> out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

std::vector<Column> target_columns() {
  return joined(
      {{integer("id", "id of the target, the same in every product"), text("name", "class and id"),
        text("class", "what the detector called it"),
        text("state", "generated, converging, converged, mapped or deregistered")},
       position_columns(),
       {real("sigma_horizontal_m", "m", "1 sigma along the worst horizontal direction"),
        real("sigma_vertical_m", "m", "1 sigma of the height"), integer("detections", "boxes it was located from"),
        integer("keyframes", "frames that updated its points"),
        real("mean_score", "", "mean score of its boxes, 0 to 1"),
        real("cylinder_radius_m", "m", "radius of the upright bounding cylinder"),
        real("cylinder_height_m", "m", "height of the upright bounding cylinder"),
        real("entropy_nats", "nat", "differential entropy of the points after the last keyframe"),
        text("reasons", "reason codes for its state, separated by semicolons")}});
}

std::vector<Column> rock_columns() {
  return joined(
      {{integer("id", "id of the located target the rock belongs to"), text("name", "class and id"),
        text("class", "what the detector called it"),
        text("status", "candidate, or rejected (reasons tell why); precarious is a judgement made in review")},
       position_columns(),
       {real("base_height_m", "m", "height of the ground at the rock, of the type that height_type names"),
        real("sigma_horizontal_m", "m", "1 sigma of the located target along the worst horizontal direction"),
        real("sigma_vertical_m", "m", "1 sigma of the located target's height"),
        real("length_m", "m", "longer side of the least-area rectangle seen from above"),
        real("width_m", "m", "shorter side of that rectangle"),
        real("rock_height_m", "m", "highest point above the base"),
        real("hwr", "", "height to width ratio: rock_height_m / width_m"),
        real("length_azimuth_deg", "deg", "direction of the longer side, clockwise from north, 0 to 180"),
        real("volume_m3", "m3", "volume of the closed mesh"),
        real("hull_volume_m3", "m3", "volume of the convex hull: an upper bound"),
        real("mass_kg", "kg", "volume times density"),
        real("density_kg_m3", "kg/m3", "density used"),
        boolean("density_assumed", "true: a usual value was taken; false: given for this rock"),
        text("cap", "how the unseen base was closed: none, plane or wrap"),
        real("unseen_area_fraction", "", "share of the closed surface that no point supports, 0 to 1"),
        text("grade", "measured, bounded, screening or not_measurable: how far alpha and what follows can be trusted"),
        text("grade_reasons", "reason codes for the grade, separated by semicolons"),
        boolean("contact_assumed", "true: the support was taken as a band at the base; false: observed"),
        real("alpha_min_deg", "deg", "least tipping angle; empty when not_measurable"),
        real("topple_toward_deg", "deg", "direction of the least tipping angle, clockwise from north"),
        real("r_m", "m", "distance from the centre of mass to that tipping edge"),
        real("p_rad_s", "rad/s", "frequency parameter about that edge"),
        real("a_qs_g", "g", "quasi-static tipping acceleration along that direction (screening only)"),
        real("v_min_m_s", "m/s", "least velocity step that topples over that edge"),
        integer("points", "points of the cloud on the rock"),
        real("point_spacing_m", "m", "median distance of a point to its nearest neighbour"),
        integer("detections", "boxes the target was located from"),
        text("reasons", "reason codes for a rejection, separated by semicolons")}});
}

std::vector<Column> obstacle_columns() {
  return joined(
      {{integer("id", "id of the target, or of the obstacle map"), text("class", "what the detector called it"),
        text("kind", "obstacle, ignored (seen, but passable below: a tree's crown) or vehicle")},
       position_columns(),
       {real("sigma_horizontal_m", "m", "1 sigma along the worst horizontal direction"),
        real("width_m", "m", "diameter of the smallest upright cylinder around it"),
        real("obstacle_height_m", "m", "height of that cylinder"), real("score", "", "0 to 1"),
        integer("observations", "boxes it was seen in"),
        real("variance_east_m2", "m2", "of the position; empty when not known"),
        real("variance_north_m2", "m2", "of the position; empty when not known"),
        real("covariance_east_north_m2", "m2", "of the position; empty when not known"),
        real("sigma_width_m", "m", "1 sigma of the width; empty when not known"),
        real("sigma_obstacle_height_m", "m", "1 sigma of the height; empty when not known"),
        integer("misses", "images that showed its place and not it, since it was last seen"),
        integer("first_seen_ns", "capture time on the survey's time base; empty when not known"),
        integer("last_seen_ns", "capture time on the survey's time base; empty when not known"),
        real("velocity_east_m_s", "m/s", "of a moving object at last_seen_ns; empty at rest"),
        real("velocity_north_m_s", "m/s", "of a moving object at last_seen_ns; empty at rest"),
        real("sigma_velocity_m_s", "m/s", "1 sigma along the worst direction; empty at rest")}});
}

std::vector<Column> frame_columns() {
  return joined({{integer("id", "id of the frame"), text("image", "file, as the survey names it"),
                  integer("camera", "id of the camera"),
                  integer("time_ns", "time on the survey's time base; empty when not known"),
                  text("time_base", "utc, gps, boot or unknown")},
                 position_columns(),
                 {real("above_ground_m", "m", "height above the ground taken for the footprints"),
                  real("axis_azimuth_deg", "deg",
                       "direction of the optical axis, clockwise from north; empty when it is vertical"),
                  real("axis_depression_deg", "deg", "optical axis below the horizon: 90 looks straight down"),
                  real("image_top_azimuth_deg", "deg", "direction of the image's upper edge, clockwise from north"),
                  real("sigma_horizontal_m", "m", "1 sigma of the position; empty when not known"),
                  real("sigma_vertical_m", "m", "1 sigma of the height; empty when not known"),
                  real("sigma_rotation_deg", "deg", "1 sigma of the attitude; empty when not known")}});
}

std::vector<Column> footprint_columns() {
  return {integer("frame", "id of the frame"), text("image", "file, as the survey names it"),
          real("area_m2", "m2", "area on the horizontal plane"),
          real("ground_height_m", "m", "height of that plane, of the type that height_type names"),
          text("height_type", "what ground_height_m is measured from")};
}

std::vector<Column> gap_columns() {
  return joined({{integer("id", "id of the gap"), text("reason", "reason code: which gate the surface fails"),
                  real("area_m2", "m2", "area of the surface"), integer("facets", "facets of the audited surface")},
                 position_columns(),
                 {text("nearest_frames", "frames nearest to seeing it, nearest first, separated by semicolons"),
                  real("view_latitude_deg", "deg", "suggested camera: WGS84 latitude; empty where none was found"),
                  real("view_longitude_deg", "deg", "suggested camera: WGS84 longitude"),
                  real("view_height_m", "m", "suggested camera: height, of the type that height_type names"),
                  real("view_azimuth_deg", "deg", "suggested camera: direction of sight, clockwise from north"),
                  real("view_depression_deg", "deg", "suggested camera: sight below the horizon")}});
}

}  // namespace

const std::vector<LayerSpec>& layer_table() {
  static const std::vector<LayerSpec> table{
      {"targets", "Located objects: the centre of each, with its uncertainty", GeometryKind::point, true,
       target_columns()},
      {"rocks", "Candidate rocks cut from the cloud: size, mass and tipping, at the centre of mass",
       GeometryKind::point, true, rock_columns()},
      {"obstacles", "What a ground vehicle must not drive into, at its foot", GeometryKind::point, true,
       obstacle_columns()},
      {"frames", "Camera positions of the images", GeometryKind::point, true, frame_columns()},
      {"footprints", "What each image shows of the ground, taken as a horizontal plane", GeometryKind::polygon, false,
       footprint_columns()},
      {"gaps", "Parts of the surface that the flight did not see well enough (predicted visibility)",
       GeometryKind::polygon, true, gap_columns()}};
  return table;
}

const LayerSpec& layer_spec(std::string_view name) {
  for (const auto& spec : layer_table())
    if (spec.name == name) return spec;
  throw base::Error(base::ErrorCode::internal, "a layer that is not in the table").found(name);
}

std::string layer_table_markdown() {
  std::string out;
  for (const auto& spec : layer_table()) {
    out += "## " + std::string(spec.name) + "\n\n" + std::string(spec.title) +
           ". Geometry: " + std::string(io::name_of(spec.kind)) + (spec.with_heights ? " with heights" : "") +
           ".\n\n| column | type | unit | meaning |\n|---|---|---|---|\n";
    for (const auto& column : spec.columns)
      out += "| `" + column.name + "` | " + std::string(io::name_of(column.type)) + " | " +
             (column.unit.empty() ? "-" : column.unit) + " | " + column.definition + " |\n";
    out += "\n";
  }
  return out;
}

}  // namespace cairn::report
