#include "io/qgc_plan.hpp"

#include <cmath>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"
#include "io/records_json.hpp"

namespace cairn::io {
namespace {

using survey::HeightType;
using survey::Waypoint;

enum Command {
  kWaypoint = 16,
  kChangeSpeed = 178,
  kMountControl = 205,
  kTriggerDistance = 206,
  kImageStartCapture = 2000
};
enum Frame { kGlobalAmsl = 0, kMission = 2, kGlobalRelative = 3 };
enum AltitudeMode { kRelative = 1, kAmsl = 2 };
constexpr double kMavlinkTargeting = 2.0;  // MAV_MOUNT_MODE
constexpr double kHover_s = 1.0;           // at rest before an image is taken

class PlanWriter {
 public:
  PlanWriter(const survey::Mission& mission, std::optional<double> home_up_m)
      : mission_(mission), frame_(mission.origin.position) {
    if (mission.waypoints.empty())
      throw base::Error(base::ErrorCode::invalid_input, "a mission without a waypoint").allowed("1 or more");
    const HeightType type = mission.origin.height_type;
    amsl_ = type == HeightType::ellipsoidal || type == HeightType::orthometric;
    if (type == HeightType::unknown && !home_up_m)
      throw base::Error(base::ErrorCode::failed_precondition, "the heights are of no known datum")
          .allowed("ellipsoidal, orthometric or relative_takeoff, or the height of the launch point")
          .hint("Give --home-up-m, the local up of the launch point");
    home_ = mission.waypoints.front().position;
    home_.z() = home_up_m.value_or(0.0);
    home_height_ = frame_.to_geodetic(home_).height_m;
  }

  Json plan() {
    add(kChangeSpeed, kMission, {1.0, mission_.limits.max_speed_m_s, -1.0, 0.0, 0.0, 0.0, 0.0});
    for (const Waypoint& w : mission_.waypoints) waypoint(w);
    if (trigger_ > 0.0) trigger(0.0);
    const auto home = frame_.to_geodetic(home_);
    Json mission =
        Json::object({{"cruiseSpeed", mission_.limits.max_speed_m_s},
                      {"firmwareType", 12},
                      {"globalPlanAltitudeMode", amsl_ ? kAmsl : kRelative},
                      {"hoverSpeed", mission_.limits.max_speed_m_s},
                      {"items", std::move(items_)},
                      {"plannedHomePosition", Json(Json::Array{degrees(home.latitude_deg), degrees(home.longitude_deg),
                                                               amsl_ ? metres(amsl(home)) : Json(0)})},
                      {"vehicleType", 2},
                      {"version", 2}});
    return Json::object(
        {{"fileType", "Plan"},
         {"geoFence", Json::object({{"circles", Json::array()}, {"polygons", Json::array()}, {"version", 2}})},
         {"groundStation", "cairn DRAFT plan: advisory, check before flight"},
         {"mission", std::move(mission)},
         {"rallyPoints", Json::object({{"points", Json::array()}, {"version", 2}})},
         {"version", 1},
         {"cairn", Json::object({{"status", "DRAFT"},
                                 {"name", mission_.name},
                                 {"kind", survey::name_of(mission_.kind)},
                                 {"heights", amsl_ ? "above mean sea level (EGM96)" : "above the launch point"},
                                 {"notes", Json(mission_.notes)}})}});
  }

 private:
  // 1e-9 deg = 0.1 mm, 1 mm: the same text on every machine.
  static Json degrees(double value) { return {std::round(finite(value, "position") * 1e9) / 1e9}; }
  static Json metres(double value) { return {std::round(finite(value, "height") * 1e3) / 1e3}; }

  [[nodiscard]] double amsl(const geometry::Geodetic& p) const {
    return mission_.origin.height_type == HeightType::ellipsoidal ? p.height_m - geodesy::geoid_undulation("egm96", p)
                                                                  : p.height_m;
  }

  Json& add(int command, int frame, Json::Array params) {
    items_.push(Json::object({{"autoContinue", true},
                              {"command", command},
                              {"doJumpId", static_cast<std::int64_t>(items_.size() + 1)},
                              {"frame", frame},
                              {"params", Json(std::move(params))},
                              {"type", "SimpleItem"}}));
    return items_;
  }
  void trigger(double distance) {
    add(kTriggerDistance, kMission, {finite(distance, "trigger_m"), 0.0, 1.0, 0.0, 0.0, 0.0, 0.0});
    trigger_ = distance;
  }

  void waypoint(const Waypoint& w) {
    // What was triggered by distance up to here ends here.
    const auto p = frame_.to_geodetic(w.position);
    const Json altitude =
        metres(amsl_                                                         ? amsl(p)
               : mission_.origin.height_type == HeightType::relative_takeoff ? p.height_m
                                                                             : p.height_m - home_height_);
    double heading = std::fmod(finite(w.heading_deg, "heading_deg"), 360.0);
    if (heading < 0.0) heading += 360.0;
    if (!pitched_ || pitch_ != w.pitch_deg) {
      add(kMountControl, kMission, {finite(w.pitch_deg, "pitch_deg"), 0.0, 0.0, 0.0, 0.0, 0.0, kMavlinkTargeting});
      pitch_ = w.pitch_deg;
      pitched_ = true;
    }
    items_.push(Json::object(
        {{"AMSLAltAboveTerrain", Json()},
         {"Altitude", altitude},
         {"AltitudeMode", amsl_ ? kAmsl : kRelative},
         {"autoContinue", true},
         {"command", kWaypoint},
         {"doJumpId", static_cast<std::int64_t>(items_.size() + 1)},
         {"frame", amsl_ ? kGlobalAmsl : kGlobalRelative},
         {"params", Json(Json::Array{w.photo && w.stop ? kHover_s : 0.0, 0.0, 0.0, std::round(heading * 1e4) / 1e4,
                                     degrees(p.latitude_deg), degrees(p.longitude_deg), altitude})},
         {"type", "SimpleItem"}}));
    if (w.trigger_m != trigger_) trigger(w.trigger_m);
    if (w.photo)
      add(kImageStartCapture, kMission, {0.0, 0.0, 1.0, static_cast<double>(++images_), Json(), Json(), Json()});
  }

  const survey::Mission& mission_;
  geodesy::LocalFrame frame_;
  bool amsl_ = false, pitched_ = false;
  geometry::Vec3 home_ = geometry::Vec3::Zero();
  double home_height_ = 0.0, trigger_ = 0.0, pitch_ = 0.0;
  std::int64_t images_ = 0;
  Json items_ = Json::array();
};

}  // namespace

Json qgc_plan(const survey::Mission& mission, std::optional<double> home_up_m) {
  return PlanWriter(mission, home_up_m).plan();
}

void write_qgc_plan(const std::filesystem::path& path, const survey::Mission& mission,
                    std::optional<double> home_up_m) {
  base::write_file(path, qgc_plan(mission, home_up_m).dump() + "\n");
}

}  // namespace cairn::io
