#include "pipeline/scene_drive.hpp"

#include <string>

#include "io/json.hpp"

namespace cairn::pipeline {
namespace {

void place(JsonFields& f, std::string_view name, geometry::Vec2& value) {
  f.require(name);
  if (const auto v = f.reals(name, 2)) value = {(*v)[0], (*v)[1]};
}

void prior(JsonFields& f, simulation::DriveSpec& drive) {
  f.list("prior_blocked", [&](JsonFields& item) {
    geometry::Ring ring;
    item.require("area");
    item.area("area", ring);
    drive.prior_blocked.push_back(std::move(ring));
  });
}

}  // namespace

simulation::DriveSpec read_scene_drive(JsonFields& f) {
  simulation::DriveSpec drive;
  place(f, "start", drive.start);
  place(f, "goal", drive.goal);
  f.require("area");
  f.area("area", drive.area);
  f.real("heading_deg", drive.heading_deg);
  f.real("start_s", drive.start_s);
  f.real("limit_s", drive.limit_s);
  f.real("goal_tolerance_m", drive.goal_tolerance_m);
  f.text("link", drive.link);
  f.object("body", [&](JsonFields& b) {
    b.text("class", drive.body.object_class);
    b.real("length_m", drive.body.length_m);
    b.real("width_m", drive.body.width_m);
    b.real("height_m", drive.body.height_m);
  });
  f.object("scanner", [&](JsonFields& s) {
    auto& scanner = drive.scanner;
    s.real("height_m", scanner.height_m);
    s.real("rate_hz", scanner.rate_hz);
    s.real("turn_s", scanner.turn_s);
    s.real("field_deg", scanner.field_deg);
    s.real("step_deg", scanner.step_deg);
    s.real("range_min_m", scanner.range_min_m);
    s.real("range_max_m", scanner.range_max_m);
    s.real("sigma_m", scanner.sigma_m);
    s.real("dropout_share", scanner.dropout_share);
  });
  f.object("inertial", [&](JsonFields& i) {
    i.real("rate_hz", drive.inertial.rate_hz);
    i.real("velocity_noise_m_s", drive.inertial.velocity_noise_m_s);
    i.real("velocity_bias_m_s", drive.inertial.velocity_bias_m_s);
    i.real("heading_deg", drive.inertial.heading_deg);
  });
  prior(f, drive);
  return drive;
}

}  // namespace cairn::pipeline
