// Names of the closed sets, as they stand in files.
#include <array>
#include <utility>

#include "survey/camera.hpp"
#include "survey/manifest.hpp"
#include "survey/mission.hpp"
#include "survey/obstacle.hpp"
#include "survey/rock.hpp"
#include "survey/target.hpp"
#include "survey/tracklet.hpp"

namespace cairn::survey {
namespace {

template <typename Enum, std::size_t N>
using Names = std::array<std::pair<Enum, std::string_view>, N>;

constexpr Names<CameraModel, 4> kCameraModels{{{CameraModel::pinhole, "pinhole"},
                                               {CameraModel::radial, "radial"},
                                               {CameraModel::brown, "brown"},
                                               {CameraModel::fisheye, "fisheye"}}};
constexpr Names<TargetState, 5> kTargetStates{{{TargetState::generated, "generated"},
                                               {TargetState::converging, "converging"},
                                               {TargetState::converged, "converged"},
                                               {TargetState::mapped, "mapped"},
                                               {TargetState::deregistered, "deregistered"}}};
constexpr Names<TrackState, 2> kTrackStates{{{TrackState::detected, "detected"}, {TrackState::coasted, "coasted"}}};
constexpr Names<Grade, 4> kGrades{{{Grade::measured, "measured"},
                                   {Grade::bounded, "bounded"},
                                   {Grade::screening, "screening"},
                                   {Grade::not_measurable, "not_measurable"}}};
constexpr Names<CapModel, 4> kCapModels{
    {{CapModel::none, "none"}, {CapModel::plane, "plane"}, {CapModel::patch, "patch"}, {CapModel::wrap, "wrap"}}};
constexpr Names<ObstacleKind, 3> kObstacleKinds{
    {{ObstacleKind::obstacle, "obstacle"}, {ObstacleKind::ignored, "ignored"}, {ObstacleKind::vehicle, "vehicle"}}};
constexpr Names<HeightType, 4> kHeightTypes{{{HeightType::ellipsoidal, "ellipsoidal"},
                                             {HeightType::orthometric, "orthometric"},
                                             {HeightType::relative_takeoff, "relative_takeoff"},
                                             {HeightType::unknown, "unknown"}}};
constexpr Names<MissionKind, 3> kMissionKinds{
    {{MissionKind::lawnmower, "lawnmower"}, {MissionKind::cylinder, "cylinder"}, {MissionKind::gaps, "gaps"}}};
constexpr Names<WaypointRole, 4> kWaypointRoles{{{WaypointRole::lane, "lane"},
                                                 {WaypointRole::circle, "circle"},
                                                 {WaypointRole::view, "view"},
                                                 {WaypointRole::transit, "transit"}}};
constexpr Names<Confidence, 3> kConfidences{
    {{Confidence::declared, "declared"}, {Confidence::inferred, "inferred"}, {Confidence::assumed, "assumed"}}};

template <typename Enum, std::size_t N>
std::string_view name_in(const Names<Enum, N>& names, Enum value) {
  for (const auto& [known, name] : names)
    if (known == value) return name;
  return "unknown";
}

template <typename Enum, std::size_t N>
std::optional<Enum> value_in(const Names<Enum, N>& names, std::string_view text) {
  for (const auto& [value, name] : names)
    if (name == text) return value;
  return std::nullopt;
}

}  // namespace

std::string_view name_of(CameraModel model) {
  return name_in(kCameraModels, model);
}
std::optional<CameraModel> camera_model_from(std::string_view name) {
  return value_in(kCameraModels, name);
}
std::string_view name_of(TrackState state) {
  return name_in(kTrackStates, state);
}
std::optional<TrackState> track_state_from(std::string_view name) {
  return value_in(kTrackStates, name);
}
std::string_view name_of(TargetState state) {
  return name_in(kTargetStates, state);
}
std::optional<TargetState> target_state_from(std::string_view name) {
  return value_in(kTargetStates, name);
}
std::string_view name_of(Grade grade) {
  return name_in(kGrades, grade);
}
std::optional<Grade> grade_from(std::string_view name) {
  return value_in(kGrades, name);
}
std::string_view name_of(CapModel cap) {
  return name_in(kCapModels, cap);
}
std::string_view name_of(ObstacleKind kind) {
  return name_in(kObstacleKinds, kind);
}
std::string_view name_of(HeightType type) {
  return name_in(kHeightTypes, type);
}
std::optional<HeightType> height_type_from(std::string_view name) {
  return value_in(kHeightTypes, name);
}
std::string_view name_of(MissionKind kind) {
  return name_in(kMissionKinds, kind);
}
std::optional<MissionKind> mission_kind_from(std::string_view name) {
  return value_in(kMissionKinds, name);
}
std::string_view name_of(WaypointRole role) {
  return name_in(kWaypointRoles, role);
}
std::optional<WaypointRole> waypoint_role_from(std::string_view name) {
  return value_in(kWaypointRoles, name);
}
std::string_view name_of(Confidence confidence) {
  return name_in(kConfidences, confidence);
}

}  // namespace cairn::survey
