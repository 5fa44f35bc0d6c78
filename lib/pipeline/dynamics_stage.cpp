#include "pipeline/dynamics_stage.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "fragility/rocking_profile.hpp"
#include "fragility/rocking_response.hpp"
#include "fragility/tipping.hpp"
#include "report/outcome_plane.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;

std::vector<double> number_list(const std::string& text, const char* option) {
  std::vector<double> values;
  std::size_t start = 0;
  while (start <= text.size()) {
    const std::size_t comma = std::min(text.find(',', start), text.size());
    const auto value = base::parse_real(text.substr(start, comma - start));
    if (!value || !std::isfinite(*value) || !(*value > 0.0))
      throw Error(ErrorCode::invalid_argument, std::string(option) + " is not a list of positive numbers")
          .found("'" + text + "'")
          .allowed("0.05,0.1,0.2");
    values.push_back(*value);
    start = comma + 1;
  }
  return values;
}

// The points that an edge about which the rock can tip ends at.
std::vector<Vec3> bearing_points(const survey::Tipping& tip) {
  std::vector<Vec3> points;
  for (const auto& edge : tip.edges)
    for (const auto& end : edge.ends) points.push_back(end);
  return points.empty() ? tip.contact : points;
}

struct PlaneRun {
  bool toppled = false;
  double greatest = 0.0;  // share of the toppling angle
};

// The ground's acceleration along the profile's axis at the samples' middles, as a record with steps.
std::optional<PlaneRun> plane_run(const std::optional<fragility::RockingProfile>& profile, const NamedMotion& named) {
  if (!profile || named.motion.velocity_m_s.size() < 3) return std::nullopt;
  const double azimuth = base::deg_to_rad(named.axis_deg);
  const Vec3 along(std::sin(azimuth), std::cos(azimuth), 0.0);
  std::vector<double> horizontal, vertical;
  const auto& v = named.motion.velocity_m_s;
  for (std::size_t i = 0; i + 1 < v.size(); ++i) {
    const Vec3 a = (v[i + 1] - v[i]) / named.motion.step_s;
    horizontal.push_back(a.dot(along));
    vertical.push_back(a.z());
  }
  fragility::RockingInput input;
  input.horizontal = horizontal;
  input.vertical = vertical;
  input.dt = named.motion.step_s;
  const auto result = fragility::rock(*profile, input);
  return PlaneRun{result.overturned, std::max(std::abs(result.peak_up), std::abs(result.peak_down))};
}

struct Run {
  dynamics::ToppleResult body;
  std::optional<PlaneRun> plane;
};

io::Json run_json(const NamedMotion& motion, const Run& run) {
  const auto& b = run.body;
  auto json = io::Json::object({{"motion", motion.name},
                                {"pga_g", motion.pga_g},
                                {"pgv_over_pga_s", motion.pgv_over_pga_s},
                                {"axis_deg", motion.axis_deg},
                                {"outcome_3d", dynamics::name_of(b.outcome)},
                                {"toppled_3d", b.toppled()},
                                {"max_tilt_deg", base::rad_to_deg(b.max_tilt_rad)},
                                {"tilt_toward_deg", b.tilt_toward_deg},
                                {"rotation_vector_deg", io::Json(Vec3(b.rotation_vector_rad * base::rad_to_deg(1.0)))},
                                {"slip_m", b.slip_m},
                                {"max_lift_m", b.max_lift_m},
                                {"impacts", b.impacts},
                                {"time_s", b.time_s}});
  json.set("toppled_plane", run.plane ? io::Json(run.plane->toppled) : io::Json());
  json.set("max_tilt_plane_share", run.plane ? io::Json(run.plane->greatest) : io::Json());
  return json;
}

// Options as they were resolved: names and values of the command line.
io::Json options_json(const DynamicsOptions& options) {
  DynamicsOptions copy = options;
  io::Json json = io::Json::object();
  for (const auto& o : base::option_texts(base::bind_options(copy))) {
    const auto number = o.quoted ? std::nullopt : base::parse_real(o.value);
    json.set(o.name, number ? io::Json(*number) : io::Json(o.value));
  }
  return json;
}

io::Json study_json(const NamedMotion& motion, const dynamics::StepStudy& study) {
  io::Json rows = io::Json::array();
  for (const auto& row : study.rows)
    rows.push(io::Json::object({{"step_s", row.step_s},
                                {"outcome", dynamics::name_of(row.outcome)},
                                {"max_tilt_deg", base::rad_to_deg(row.max_tilt_rad)}}));
  return io::Json::object({{"motion", motion.name}, {"converged", study.converged}, {"rows", std::move(rows)}});
}

// The strongest run that stood and the weakest that toppled: where the step matters most.
std::vector<std::size_t> delicate(std::span<const NamedMotion> motions, const std::vector<Run>& runs) {
  std::optional<std::size_t> stood, toppled;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].body.toppled()) {
      if (!toppled || motions[i].pga_g < motions[*toppled].pga_g) toppled = i;
    } else if (!stood || runs[i].body.max_tilt_rad > runs[*stood].body.max_tilt_rad) {
      stood = i;
    }
  }
  std::vector<std::size_t> out;
  if (stood) out.push_back(*stood);
  if (toppled) out.push_back(*toppled);
  return out;
}

std::string plane_svg(const RockResult& result, const io::Json& check) {
  std::vector<report::PlaneMark> marks;
  for (const auto& run : check.at("runs").as_array()) {
    report::PlaneMark mark;
    mark.pga_g = run.at("pga_g").as_real();
    mark.pgv_over_pga_s = run.at("pgv_over_pga_s").as_real();
    mark.toppled = run.at("toppled_3d").as_bool();
    if (!run.at("toppled_plane").is_null()) mark.toppled_plane = run.at("toppled_plane").as_bool();
    marks.push_back(mark);
  }
  return report::outcome_plane_svg(marks, result.rock.tipping.critical->a_qs_g,
                                   result.rock.object_class + " " + result.stem);
}

}  // namespace

void DynamicsOptions::visit(base::OptionVisitor& visitor) {
  visitor.text("pulse-ratios-s", pulse_ratios_s, "3-D check: PGV/PGA of the one-cosine pulses, comma-separated");
  visitor.text("pulse-levels", pulse_levels, "3-D check: PGA of the pulses as multiples of the quasi-static tipping");
  visitor.integer("step-halvings", step_halvings, 0, 6, "3-D check: study in the time step; 0 = none");
  contact.visit(visitor);
  body.visit(visitor);
}

std::vector<NamedMotion> check_pulses(const survey::Rock& rock, const DynamicsOptions& options) {
  if (!rock.tipping.critical) throw Error(ErrorCode::failed_precondition, "the rock has no tipping angle");
  const auto& edge = *rock.tipping.critical;
  const double away = std::fmod(edge.azimuth_deg + 180.0, 360.0);
  std::vector<NamedMotion> motions;
  for (const double ratio : number_list(options.pulse_ratios_s, "pulse-ratios-s"))
    for (const double level : number_list(options.pulse_levels, "pulse-levels")) {
      const double pga_g = level * edge.a_qs_g;
      motions.push_back({"one cosine, PGA " + base::to_fixed(pga_g, 3) + " g, PGV/PGA " + base::to_text(ratio) + " s",
                         pga_g, ratio, edge.azimuth_deg,
                         dynamics::one_cosine(pga_g * fragility::kGravity, ratio, away)});
    }
  return motions;
}

std::vector<NamedMotion> check_record_motions(const survey::Rock& rock, std::span<const survey::Accelerogram> records,
                                              std::span<const double> scales) {
  if (!rock.tipping.critical) throw Error(ErrorCode::failed_precondition, "the rock has no tipping angle");
  const double axis = rock.tipping.critical->azimuth_deg, azimuth = base::deg_to_rad(axis);
  const Vec3 away(-std::sin(azimuth), -std::cos(azimuth), 0.0);
  std::vector<NamedMotion> motions;
  for (const auto& record : records) {
    if (record.vertical) continue;
    std::vector<Vec3> acceleration;
    double pga = 0.0, pgv = 0.0;
    for (const double a : record.acceleration) {
      acceleration.emplace_back(a * away);
      pga = std::max(pga, std::abs(a));
    }
    const auto motion = dynamics::from_acceleration(record.dt_s, acceleration);
    for (const auto& v : motion.velocity_m_s) pgv = std::max(pgv, v.norm());
    if (!(pga > 0.0)) continue;
    for (const double scale : scales)
      motions.push_back({record.name + " x " + base::to_text(scale), scale * pga / fragility::kGravity, pgv / pga, axis,
                         dynamics::scaled(motion, scale)});
  }
  return motions;
}

io::Json check_3d(const RockResult& result, std::span<const NamedMotion> motions, const DynamicsOptions& options,
                  base::RunContext& ctx) {
  if (!result.rock.tipping.critical || !result.rock.mass)
    throw Error(ErrorCode::failed_precondition, "the rock has no tipping angle").record("rock " + result.stem);
  const auto& mass = *result.rock.mass;
  const auto bearing = bearing_points(result.rock.tipping);
  const auto body = dynamics::rigid_rock(result.mesh, mass, result.rock.density_kg_m3, bearing, options.body);
  const auto edges = fragility::tipping(mass, bearing);
  std::vector<Run> runs;
  std::int64_t toppled = 0, plane_toppled = 0, compared = 0, same = 0;
  for (const auto& motion : motions) {
    ctx.check_stop();
    ctx.progress("motions", runs.size() + 1, motions.size());
    Run run{dynamics::topple(body, motion.motion, options.contact),
            plane_run(fragility::edge_profile(edges, mass, motion.axis_deg), motion)};
    toppled += run.body.toppled() ? 1 : 0;
    if (run.plane) {
      ++compared;
      plane_toppled += run.plane->toppled ? 1 : 0;
      same += run.plane->toppled == run.body.toppled() ? 1 : 0;
    }
    runs.push_back(std::move(run));
  }
  io::Json rows = io::Json::array(), studies = io::Json::array();
  for (std::size_t i = 0; i < runs.size(); ++i) rows.push(run_json(motions[i], runs[i]));
  bool converged = true;
  if (options.step_halvings > 0)
    for (const std::size_t i : delicate(motions, runs)) {
      const auto study =
          dynamics::step_convergence(body, motions[i].motion, options.contact, static_cast<int>(options.step_halvings));
      converged = converged && study.converged;
      studies.push(study_json(motions[i], study));
    }
  return io::Json::object({{"schema_version", 1},
                           {"id", result.rock.target.value},
                           {"grade", survey::name_of(result.rock.tipping.grade)},
                           {"engine", "Bullet 3, double precision, sequential impulses"},
                           {"plane_model", "rocking about the edges of the contact, Housner's impacts, no slip"},
                           {"options", options_json(options)},
                           {"corners", body.foot_m.size()},
                           {"corners_off_plane_m", body.foot_off_plane_m},
                           {"pad_normal", io::Json(body.pad_normal)},
                           {"flank_pieces", body.pieces_m.size()},
                           {"toppled_3d", toppled},
                           {"toppled_plane", plane_toppled},
                           {"compared", compared},
                           {"same_answer", same},
                           {"step_converged", options.step_halvings > 0 ? io::Json(converged) : io::Json()},
                           {"step_studies", std::move(studies)},
                           {"runs", std::move(rows)}});
}

Outcome dynamics_files(const std::vector<RockResult>& results, std::span<const survey::Accelerogram> records,
                       std::span<const double> scales, const std::filesystem::path& out, const DynamicsOptions& options,
                       base::RunContext& ctx) {
  DynamicsOptions checked = options;
  base::validate(base::bind_options(checked), "dynamics");
  io::Json rows = io::Json::array();
  Outcome outcome;
  for (const auto& result : results) {
    if (!result.rock.tipping.critical || result.mesh.triangles.empty()) continue;
    try {
      const auto motions =
          records.empty() ? check_pulses(result.rock, options) : check_record_motions(result.rock, records, scales);
      const auto check = check_3d(result, motions, options, ctx);
      base::write_file(out / (result.stem + "_dynamics.json"), check.dump() + "\n");
      base::write_file(out / (result.stem + "_dynamics.svg"), plane_svg(result, check));
      rows.push(io::Json::object({{"id", result.rock.target.value},
                                  {"name", result.stem},
                                  {"runs", check.at("runs").size()},
                                  {"toppled_3d", check.at("toppled_3d")},
                                  {"toppled_plane", check.at("toppled_plane")},
                                  {"same_answer", check.at("same_answer")},
                                  {"step_converged", check.at("step_converged")}}));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::failed_precondition) throw;
      outcome.rejects.push_back({"rock " + result.stem, "no_3d_check", error.what()});
    }
  }
  outcome.summary = io::Json::object({{"dynamics", std::move(rows)}});
  return outcome;
}

}  // namespace cairn::pipeline
