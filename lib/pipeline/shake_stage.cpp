#include "pipeline/shake_stage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "fragility/ground_motion.hpp"
#include "fragility/published_model.hpp"
#include "fragility/shake_plots.hpp"
#include "io/csv.hpp"
#include "io/fragility_model.hpp"
#include "pipeline/fragility_subjects.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using fragility::kGravity;

struct Suite {
  std::vector<fragility::SuiteMotion> motions;
  io::Json rows = io::Json::array();
  std::vector<base::Reject> rejects;
};

io::Json record_row(const survey::Accelerogram& r, const std::string& file, const fragility::GroundMotionMeasures& m,
                    bool with_vertical) {
  const auto sa = [&r](double period) {
    return fragility::spectral_ordinate(r.acceleration, r.dt_s, period).pseudo_acceleration / kGravity;
  };
  return io::Json::object({{"name", r.name},
                           {"file", fs::path(file).filename().string()},
                           {"format", r.format},
                           {"event", r.event},
                           {"station", r.station},
                           {"component", r.component},
                           {"dt_s", r.dt_s},
                           {"samples", r.acceleration.size()},
                           {"pga_g", m.pga_m_s2 / kGravity},
                           {"pgv_m_s", m.pgv_m_s},
                           {"pgd_m", m.pgd_m},
                           {"pgv_over_pga_s", m.pgv_m_s / m.pga_m_s2},
                           {"psa_1s_g", sa(1.0)},
                           {"psa_2s_g", sa(2.0)},
                           {"final_velocity_m_s", m.final_velocity_m_s},
                           {"with_vertical", with_vertical},
                           {"notes", r.notes}});
}

Suite read_suite(const std::vector<fs::path>& files, const io::RecordOptions& options) {
  struct Read {
    survey::Accelerogram record;
    std::size_t file;
    bool used = false;
  };
  std::vector<Read> all;
  for (std::size_t f = 0; f < files.size(); ++f)
    for (auto& record : io::read_accelerograms(files[f], options)) all.push_back({std::move(record), f});
  Suite suite;
  for (auto& horizontal : all) {
    const auto& r = horizontal.record;
    if (r.vertical) continue;
    const auto m = fragility::measures(r.acceleration, r.dt_s);
    if (!(m.pga_m_s2 > 0.0) || !(m.pgv_m_s > 0.0)) {
      suite.rejects.push_back({"record " + r.name, "record_without_motion", "all accelerations are 0"});
      continue;
    }
    // The vertical component of the same file, or of the same event and station.
    Read* vertical = nullptr;
    for (auto& other : all) {
      const bool same =
          other.file == horizontal.file || (!r.event.empty() && !r.station.empty() && other.record.event == r.event &&
                                            other.record.station == r.station);
      if (other.record.vertical && same && std::abs(other.record.dt_s - r.dt_s) < 1e-9) vertical = &other;
    }
    fragility::SuiteMotion motion;
    motion.name = r.name;
    motion.dt = r.dt_s;
    motion.horizontal = r.acceleration;
    motion.pga = m.pga_m_s2;
    motion.pgv = m.pgv_m_s;
    if (vertical != nullptr) {
      vertical->used = true;
      motion.vertical = vertical->record.acceleration;
      const std::size_t n = std::min(motion.vertical.size(), motion.horizontal.size());
      motion.vertical.resize(n);
      motion.horizontal.resize(n);
    }
    suite.rows.push(record_row(r, files[horizontal.file].string(), m, vertical != nullptr));
    suite.motions.push_back(std::move(motion));
  }
  for (const auto& other : all)
    if (other.record.vertical && !other.used)
      suite.rejects.push_back({"record " + other.record.name, "vertical_without_horizontal",
                               "no horizontal component of the same event, station and step was given"});
  return suite;
}

// What is run and printed for one rock.
struct Rock {
  std::string stem, contact, grade;
  std::vector<std::string> reasons;
  fragility::ProfileOfAzimuth profile;
  double alpha = 0.0, r = 0.0, p = 0.0, toward_deg = 0.0;  // of the least edge, or of the facet at rest
};

std::optional<base::Reject> prepare(Rock& rock, FragilitySubject& s, const ShakeOptions& options,
                                    const fragility::FragilityOptions& assessment) {
  const auto reject = [&s](std::string reason, std::string message) {
    return base::Reject{"rock " + s.stem, std::move(reason), std::move(message)};
  };
  if (!s.mesh || !s.rock.mass) return reject(s.rock.reasons.empty() ? "no_surface" : s.rock.reasons.front(), s.refusal);
  rock.stem = s.stem;
  const auto& mass = *s.rock.mass;
  if (options.contact_model == "plane") {
    s.evidence.contact_assumed = true;
    const auto contact = fragility::plane_contact(s.mesh->vertices, mass);
    if (!contact) return reject("no_contact", "the body has no facet to rest on");
    rock.contact = "convex hull on a rigid level plane (assumed)";
    rock.alpha = contact->alpha;
    rock.toward_deg = contact->azimuth_deg;
    rock.r = contact->height / std::cos(contact->alpha);
    if (const auto along = fragility::plane_profile(s.mesh->vertices, mass, contact->azimuth_deg))
      rock.p = std::sqrt(along->toes[along->rest + 1].p_squared);
    rock.profile = [&s, mass](double azimuth) { return fragility::plane_profile(s.mesh->vertices, mass, azimuth); };
  } else {
    std::vector<geometry::Vec3> points;
    for (const auto& v : s.contact) points.push_back(v.position);
    auto result = fragility::tipping(mass, points, assessment.plumb_tolerance_m);
    if (result.equilibrium != fragility::Equilibrium::stable || !result.critical)
      return reject(fragility::reason_of(result.equilibrium), "the contact cannot hold the rock up");
    const auto& edge = result.edges[*result.critical];
    rock.contact =
        s.evidence.contact_assumed ? "support polygon of an assumed contact" : "support polygon of the contact";
    rock.alpha = edge.alpha;
    rock.r = edge.r;
    rock.p = edge.p;
    rock.toward_deg = edge.azimuth_deg;
    rock.profile = [result = std::move(result), mass](double azimuth) {
      return fragility::edge_profile(result, mass, azimuth);
    };
  }
  const auto grading = fragility::grade(s.evidence, assessment.grade);
  rock.grade = survey::name_of(grading.grade);
  rock.reasons = grading.reasons;
  if (grading.grade == survey::Grade::not_measurable)
    return reject(rock.reasons.empty() ? "not_measurable" : rock.reasons.front(),
                  "the evidence does not allow a tipping angle, so no record is run");
  return std::nullopt;
}

io::Json logistic_json(const fragility::LogisticFit& f) {
  io::Json json = io::Json::object({{"fitted", f.fitted}, {"count", f.count}, {"toppled", f.toppled}});
  if (!f.fitted) {
    json.set("reason", f.reason);
    return json;
  }
  json.set("form", "P = 1/(1 + exp(-(b0 + b1 ln PGA[g] + b2 ln(PGV/PGA)[s])))");
  json.set("b", io::Json(std::vector<double>{f.b[0], f.b[1], f.b[2]}));
  json.set("with_ratio", f.with_ratio);
  json.set("separable", f.separable);
  return json;
}

void write_outcomes(const fs::path& path, const std::vector<fragility::SuiteOutcome>& outcomes, const Suite& suite,
                    const std::vector<double>& shares) {
  io::CsvWriter csv(path, {"record", "scale", "azimuth_deg", "eta_share", "pga_g", "pgv_over_pga_s", "rocked",
                           "toppled", "topple_toward_deg", "lifted_off"});
  for (const auto& o : outcomes) {
    csv.cell(suite.motions[o.record].name).cell(o.scale).cell(o.azimuth_deg).cell(shares[o.eta_draw]);
    csv.cell(o.pga_g).cell(o.pgv_over_pga_s).cell(o.rocked ? 1 : 0).cell(o.toppled ? 1 : 0);
    csv.cell(o.toppled ? std::optional<double>(o.topple_toward_deg) : std::nullopt).cell(o.lifted_off ? 1 : 0);
    csv.end_row();
  }
  csv.finish();
}

std::vector<double> log_steps(double lo, double hi, int count) {
  std::vector<double> list;
  for (int i = 0; i < count; ++i) list.push_back(lo * std::pow(hi / lo, static_cast<double>(i) / (count - 1)));
  return list;
}

// PGA over the suite's range at each of its PGV/PGA: the ratio in the middle first.
std::vector<std::array<double, 2>> curve_grid(const Suite& suite, const std::vector<double>& scales, bool with_ratio) {
  double lo = std::numeric_limits<double>::infinity(), hi = 0.0;
  std::vector<double> ratios;
  for (const auto& m : suite.motions) {
    lo = std::min(lo, m.pga * scales.front() / kGravity);
    hi = std::max(hi, m.pga * scales.back() / kGravity);
    ratios.push_back(m.pgv / m.pga);
  }
  if (!(hi > lo * 1.01)) hi = lo * 2.0;
  std::sort(ratios.begin(), ratios.end());
  std::vector<double> at = {ratios[ratios.size() / 2]};
  if (with_ratio && ratios.back() > ratios.front() * 1.05)
    for (const double r : log_steps(ratios.front(), ratios.back(), 5)) at.push_back(r);
  std::vector<std::array<double, 2>> grid;
  for (const double ratio : at)
    for (const double pga : log_steps(lo, hi, 41)) grid.push_back({pga, ratio});
  return grid;
}

void write_curve(const fs::path& path, const std::vector<fragility::CurvePoint>& curve, bool banded) {
  io::CsvWriter csv(path, {"pga_g", "pgv_over_pga_s", "p", "p05", "p16", "p50", "p84", "p95"});
  for (const auto& c : curve) {
    csv.cell(c.pga_g).cell(c.pgv_over_pga_s).cell(c.p);
    for (const double v : {c.p05, c.p16, c.p50, c.p84, c.p95})
      csv.cell(banded ? std::optional<double>(v) : std::nullopt);
    csv.end_row();
  }
  csv.finish();
}

void write_map(const fs::path& stem, const fragility::OverturningMap& map, const fragility::LogisticFit& fit,
               const Rock& rock) {
  io::CsvWriter csv(stem.string() + "_overturning.csv", {"pga_g", "pgv_over_pga_s", "share_overturned"});
  for (std::size_t r = 0; r < map.ratio_s.size(); ++r)
    for (std::size_t k = 0; k < map.pga_g.size(); ++k) {
      csv.cell(map.pga_g[k]).cell(map.ratio_s[r]).cell(map.share[r * map.pga_g.size() + k]);
      csv.end_row();
    }
  csv.finish();
  base::write_file(
      stem.string() + "_overturning.svg",
      fragility::overturning_map_svg(map, fit.fitted ? &fit : nullptr, "Overturning by one cosine: " + rock.stem,
                                     "grade " + rock.grade + "; share of directions and restitutions"));
}

io::Json models_json(const std::vector<survey::FragilityModel>& models, const Rock& rock,
                     const std::vector<std::array<double, 2>>& grid) {
  io::Json list = io::Json::array();
  for (const auto& model : models) {
    io::Json p = io::Json::array();
    for (const auto& [pga, ratio] : grid)
      p.push(io::Json(fragility::published_probability(model, rock.alpha, rock.r, rock.p, pga, ratio)));
    list.push(
        io::Json::object({{"name", model.name}, {"reference", model.reference}, {"p_on_curve_grid", std::move(p)}}));
  }
  return list;
}

io::Json shake_one(const Rock& rock, const Suite& suite, const std::vector<double>& scales,
                   const std::vector<survey::FragilityModel>& models, const ShakeOptions& options, const fs::path& out,
                   base::RunContext& ctx) {
  const auto shares = options.suite.eta_shares();
  const auto outcomes = fragility::run_suite(rock.profile, suite.motions, scales, options.suite, ctx);
  const auto shaken = fragility::to_shake_outcomes(outcomes);
  const fragility::LogisticOptions how;
  const auto fit = fragility::fit_logistic(shaken, how);
  write_outcomes(out / (rock.stem + "_outcomes.csv"), outcomes, suite, shares);

  std::size_t lifted = 0, rocked = 0;
  for (const auto& o : outcomes) {
    lifted += o.lifted_off ? 1U : 0U;
    rocked += o.rocked ? 1U : 0U;
  }
  io::Json by_eta = io::Json::array();
  for (std::size_t e = 0; e < shares.size(); ++e) {
    std::vector<fragility::ShakeOutcome> part;
    for (std::size_t i = 0; i < outcomes.size(); ++i)
      if (outcomes[i].eta_draw == e) part.push_back(shaken[i]);
    io::Json row = logistic_json(fragility::fit_logistic(part, how));
    row.set("eta_share", shares[e]);
    by_eta.push(std::move(row));
  }
  io::Json row = io::Json::object({{"name", rock.stem},
                                   {"grade", rock.grade},
                                   {"reasons", rock.reasons},
                                   {"contact", rock.contact},
                                   {"alpha_min_deg", base::rad_to_deg(rock.alpha)},
                                   {"topple_toward_deg", rock.toward_deg},
                                   {"r_m", rock.r},
                                   {"p_rad_s", rock.p},
                                   {"runs", outcomes.size()},
                                   {"rocked", rocked},
                                   {"toppled", fit.toppled},
                                   {"lifted_off", lifted},
                                   {"logistic", logistic_json(fit)},
                                   {"by_eta", std::move(by_eta)}});
  const auto grid = curve_grid(suite, scales, fit.with_ratio);
  if (!models.empty()) row.set("models", models_json(models, rock, grid));
  std::vector<fragility::CurvePoint> curve;
  const bool banded = fit.fitted && suite.motions.size() >= 2;
  if (banded) {
    curve =
        fragility::bootstrap_curve(shaken, fit, how, grid, static_cast<std::size_t>(options.bootstrap_draws), ctx.seed);
  } else if (fit.fitted) {
    for (const auto& [pga, ratio] : grid) {
      fragility::CurvePoint point;
      point.pga_g = pga;
      point.pgv_over_pga_s = ratio;
      point.p = fit.probability(pga, ratio);
      curve.push_back(point);
    }
  }
  if (fit.fitted) {
    row.set("median_pga_g", fit.b[1] > 0.0 ? io::Json(fit.median_pga_g(grid.front()[1])) : io::Json());
    row.set("median_at_pgv_over_pga_s", grid.front()[1]);
    row.set("band", banded ? "bootstrap over records, 5/16/50/84/95 %" : "none: one record says nothing about another");
    write_curve(out / (rock.stem + "_curve.csv"), curve, banded);
    const std::span<const fragility::CurvePoint> middle(curve.data(), std::min<std::size_t>(41, curve.size()));
    base::write_file(out / (rock.stem + "_fragility.svg"),
                     fragility::fragility_curve_svg(
                         middle, banded, shaken, "Fragility: " + rock.stem,
                         "grade " + rock.grade + "; " + std::to_string(fit.toppled) + " of " +
                             std::to_string(fit.count) + " runs toppled, " + std::to_string(suite.motions.size()) +
                             " record(s)" + (fit.separable ? "; outcomes separate, slope from the prior" : "")));
  }
  if (options.map.pga_steps > 1 && options.map.ratio_steps > 1)
    write_map(out / rock.stem, fragility::overturning_map(rock.profile, options.map, options.suite, ctx), fit, rock);
  base::write_file(out / (rock.stem + "_shake.json"),
                   io::Json::object({{"schema_version", 1}, {"records", suite.rows}, {"rock", row}}).dump() + "\n");
  return row;
}

}  // namespace

void ShakeOptions::visit(base::OptionVisitor& visitor) {
  visitor.choice("shake-contact", contact_model, {"edges", "plane"},
                 "What the rock rocks on: the support's edges, or its hull on a rigid plane");
  visitor.integer("bootstrap-draws", bootstrap_draws, 20, 100000, "Draws of records for the band of the curve");
  suite.visit(visitor);
  map.visit(visitor);
  record.visit(visitor);
}

std::vector<double> parse_scales(std::string_view text) {
  const auto refuse = [text](const char* what) {
    return Error(ErrorCode::invalid_argument, what)
        .found("--scale " + std::string(text))
        .allowed("first:last:step, as 0.1:2:0.1, or a list, as 0.5,1,2");
  };
  const char separator = text.find(':') != std::string_view::npos ? ':' : ',';
  std::vector<double> values;
  for (std::size_t at = 0; at <= text.size();) {
    std::size_t end = text.find(separator, at);
    if (end == std::string_view::npos) end = text.size();
    const auto value = base::parse_real(text.substr(at, end - at));
    if (!value || !(*value > 0.0) || !std::isfinite(*value)) throw refuse("a scale must be a number above 0");
    values.push_back(*value);
    at = end + 1;
  }
  constexpr double kMost = 10000.0;
  if (separator == ':') {
    if (values.size() != 3 || values[1] < values[0]) throw refuse("a range of scales needs first, last and step");
    const double first = values[0], step = values[2], steps = std::floor((values[1] - first) / step + 1e-9);
    if (steps + 1.0 > kMost) throw refuse("too many scales");
    values.clear();
    for (int k = 0; k <= static_cast<int>(steps); ++k) values.push_back(first + k * step);
  }
  for (std::size_t i = 0; i + 1 < values.size(); ++i)
    if (!(values[i] < values[i + 1])) throw refuse("scales must ascend");
  return values;
}

Outcome shake_files(const ShakeFiles& in, const fs::path& out, const std::vector<double>& scales,
                    const ShakeOptions& options, const fragility::FragilityOptions& assessment, base::RunContext& ctx) {
  if (!fs::exists(in.input)) throw Error(ErrorCode::not_found, "no such mesh or folder").file(in.input.string());
  std::vector<survey::FragilityModel> models;
  for (const auto& path : in.models) models.push_back(io::read_fragility_model(path));
  auto suite = read_suite(in.records, options.record);
  if (suite.motions.empty())
    throw Error(ErrorCode::invalid_input, "no record has a horizontal motion")
        .allowed("one horizontal component at least");
  std::optional<io::ContactFile> contact;
  if (!in.contact.empty()) contact = io::read_contact_csv(in.contact);
  const bool folder = fs::is_directory(in.input);
  std::vector<FragilitySubject> subjects;
  if (folder) subjects = subjects_of_folder(in.input);
  else subjects.push_back(subject_of_mesh(in.input, assessment));
  if (subjects.empty())
    throw Error(ErrorCode::invalid_input, "the folder holds no rock")
        .file(in.input.string())
        .allowed("<id>.json with <id>.ply, as cairn surface writes them");

  Outcome outcome;
  outcome.rejects = suite.rejects;
  io::Json rows = io::Json::array();
  std::uint64_t done = 0;
  for (auto& s : subjects) {
    ctx.check_stop();
    ctx.progress("rocks", ++done, subjects.size());
    std::optional<base::Reject> why;
    if (contact && s.mesh) why = take_contact(s, *contact, subjects.size() == 1);
    Rock rock;
    if (!why) why = prepare(rock, s, options, assessment);
    if (why && !folder)
      throw Error(ErrorCode::invalid_input, "the rock cannot be shaken")
          .file(in.input.string())
          .found(why->reason + ": " + why->message)
          .allowed("a closed body with a contact that holds it up");
    if (why) outcome.rejects.push_back(std::move(*why));
    else rows.push(shake_one(rock, suite, scales, models, options, out, ctx));
  }
  outcome.summary = io::Json::object({{"records", suite.rows},
                                      {"scales", io::Json(scales)},
                                      {"azimuths_deg", io::Json(options.suite.azimuths())},
                                      {"shaken", rows.size()},
                                      {"rejected", outcome.rejects.size()},
                                      {"rejected_by_reason", count_by_reason(outcome.rejects)},
                                      {"rocks", std::move(rows)}});
  return outcome;
}

}  // namespace cairn::pipeline
