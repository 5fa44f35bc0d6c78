#include <cmath>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "fragility/logistic.hpp"
#include "io/csv.hpp"
#include "io/mesh.hpp"
#include "pipeline/shake_stage.hpp"
#include "surface/rock_body.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;

struct PulseTests {
  std::vector<std::string> id;
  std::vector<std::array<double, 2>> motion;
  std::vector<fragility::ShakeOutcome> outcomes;  // empty where none are known
};

PulseTests read_tests(const std::filesystem::path& path) {
  io::CsvReader csv(path);
  PulseTests tests;
  const auto pga = csv.column("pga_g"), ratio = csv.column("pgv_over_pga_s");
  const auto id = csv.find("test_no");
  std::optional<std::size_t> observed;
  constexpr std::string_view kEnd = "overturned";
  for (std::size_t k = 0; k < csv.header().size(); ++k)
    if (const auto& name = csv.header()[k];
        name.size() >= kEnd.size() && name.compare(name.size() - kEnd.size(), kEnd.size(), kEnd) == 0)
      observed = k;
  while (csv.next()) {
    tests.motion.push_back({csv.real(pga), csv.real(ratio)});
    for (const auto column : {pga, ratio})
      if (!(csv.real(column) > 0.0)) throw csv.error(column, "a pulse needs a value above 0");
    tests.id.push_back(id ? std::string(csv.text(*id)) : std::to_string(tests.id.size()));
    if (observed)
      tests.outcomes.push_back(
          {tests.motion.back()[0], tests.motion.back()[1], csv.integer(*observed, 0, 1) == 1, tests.outcomes.size()});
  }
  if (tests.motion.empty()) throw Error(ErrorCode::invalid_input, "the table holds no test").file(path.string());
  return tests;
}

// Out-of-sample probabilities of a logistic in ln PGV, every tenth test held back; empty where a fold has no fit.
std::vector<double> validated_logistic(const std::vector<fragility::ShakeOutcome>& outcomes) {
  constexpr std::size_t kFolds = 10;
  std::vector<fragility::ShakeOutcome> by_pgv = outcomes;
  for (auto& o : by_pgv) {
    o.pga_g *= o.pgv_over_pga_s;
    o.pgv_over_pga_s = 1.0;
  }
  std::vector<double> p(outcomes.size());
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<fragility::ShakeOutcome> train;
    for (std::size_t i = 0; i < by_pgv.size(); ++i)
      if (i % kFolds != fold) train.push_back(by_pgv[i]);
    const auto fit = fragility::fit_logistic(train, {true, false});
    if (!fit.fitted) return {};
    for (std::size_t i = fold; i < by_pgv.size(); i += kFolds) p[i] = fit.probability(by_pgv[i].pga_g, 1.0);
  }
  return p;
}

double accuracy_of(const std::vector<double>& p, const std::vector<fragility::ShakeOutcome>& outcomes) {
  std::size_t right = 0;
  for (std::size_t i = 0; i < p.size(); ++i) right += (p[i] >= 0.5) == outcomes[i].toppled ? 1U : 0U;
  return static_cast<double>(right) / static_cast<double>(p.size());
}

}  // namespace

Outcome pulse_test_files(const std::filesystem::path& mesh_path, const std::filesystem::path& tests_path,
                         const std::filesystem::path& out, const fragility::PulseTestOptions& options,
                         base::RunContext& ctx) {
  const auto tests = read_tests(tests_path);
  auto built = surface::body_of(io::read_mesh(mesh_path).mesh);
  if (const auto* why = std::get_if<base::Reject>(&built))
    throw Error(ErrorCode::invalid_input, "the mesh is not a closed body")
        .file(mesh_path.string())
        .found(why->reason + ": " + why->message)
        .allowed("one closed surface");
  const auto& body = std::get<surface::RockBody>(built);
  const auto prediction = fragility::predict_pulse_tests(body.mesh, body.mass, tests.motion, options, ctx);

  std::vector<std::string_view> header = {"test_no", "pga_g", "pgv_over_pga_s", "probability", "predicted"};
  if (!tests.outcomes.empty()) header.push_back("overturned");
  io::CsvWriter csv(out / "predictions.csv", std::span<const std::string_view>(header));
  for (std::size_t i = 0; i < tests.motion.size(); ++i) {
    const double p = prediction.probability[i];
    csv.cell(tests.id[i]).cell(tests.motion[i][0]).cell(tests.motion[i][1]).cell(p).cell(p >= 0.5 ? 1 : 0);
    if (!tests.outcomes.empty()) csv.cell(tests.outcomes[i].toppled ? 1 : 0);
    csv.end_row();
  }
  csv.finish();

  io::Json angles = io::Json::object();
  const char* names[] = {"p05", "p16", "p50", "p84", "p95"};
  for (std::size_t k = 0; k < 5; ++k) angles.set(names[k], base::rad_to_deg(prediction.alpha_quantiles[k]));
  Outcome outcome;
  outcome.summary = io::Json::object({{"tests", tests.motion.size()},
                                      {"grade", "screening"},
                                      {"contact", "convex hull on a rigid level plane (assumed)"},
                                      {"alpha_facet_deg", base::rad_to_deg(prediction.contact.alpha)},
                                      {"settling_tilt_deg", base::rad_to_deg(prediction.contact.pose.tilt)},
                                      {"azimuth_deg", prediction.azimuth_deg},
                                      {"vertex_noise_m", prediction.vertex_noise_m},
                                      {"contact_draws", prediction.draws},
                                      {"draws_that_do_not_stand", prediction.unstable_draws},
                                      {"toppling_angle_deg", std::move(angles)}});
  if (!tests.outcomes.empty()) {
    std::size_t toppled = 0;
    for (const auto& o : tests.outcomes) toppled += o.toppled ? 1U : 0U;
    outcome.summary.set("overturned", toppled);
    outcome.summary.set("accuracy", accuracy_of(prediction.probability, tests.outcomes));
    outcome.summary.set("brier", fragility::brier_score(prediction.probability, tests.outcomes));
    const auto rival = validated_logistic(tests.outcomes);
    if (!rival.empty()) {
      outcome.summary.set("logistic_ln_pgv_accuracy", accuracy_of(rival, tests.outcomes));
      outcome.summary.set("logistic_ln_pgv_brier", fragility::brier_score(rival, tests.outcomes));
    }
  }
  return outcome;
}

}  // namespace cairn::pipeline
