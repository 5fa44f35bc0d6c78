// What survey.json holds: where the survey is, in which frames its parts are, and how sure we are.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/time.hpp"
#include "geometry/geodetic.hpp"
#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::survey {

// Heights always name their datum.
enum class HeightType { ellipsoidal, orthometric, relative_takeoff, unknown };

[[nodiscard]] std::string_view name_of(HeightType type);
[[nodiscard]] std::optional<HeightType> height_type_from(std::string_view name);

struct Origin {
  geometry::Geodetic position;
  HeightType height_type = HeightType::unknown;
  std::string geoid;  // with orthometric: "egm96"
};

enum class Confidence { declared, inferred, assumed };
[[nodiscard]] std::string_view name_of(Confidence confidence);

// A file (or folder) the survey draws on, with the frame it is in.
struct Source {
  std::string kind;        // "images", "cloud", "poses", "detections", "ties"
  std::string path;        // relative to the survey folder where inside it, else absolute
  std::string convention;  // one sentence: which convention was read, and how it was converted
  Confidence confidence = Confidence::declared;
  std::string crs;  // "EPSG:32615", WKT, or "local" for the survey's own frame; "" = none declared
  HeightType height_type = HeightType::unknown;
  // Where the source does not share the poses' frame: world <- source (after CRS -> local).
  std::optional<geometry::Similarity> T_world_source;
};

struct Manifest {
  int schema_version = 1;
  std::string name;
  Origin origin;
  base::TimeBase time_base = base::TimeBase::unknown;
  std::vector<Camera> cameras;
  std::vector<Source> sources;
  std::vector<std::string> notes;  // sentences an importer wants people to read
};

}  // namespace cairn::survey
