#include "pipeline/fragility_stage.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "fragility/polar_plot.hpp"
#include "fragility/shape_ratios.hpp"
#include "io/contact_csv.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/fragility_products.hpp"
#include "pipeline/fragility_subjects.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

struct Assessed {
  std::vector<survey::Rock> rocks;
  io::Json rows = io::Json::array();
  std::map<std::string, std::int64_t> grades;
  std::vector<base::Reject> rejects;
};

// What all rocks are assessed with.
struct Means {
  std::optional<io::ContactFile> contact;
  std::optional<std::vector<survey::CoverageGap>> gaps;
  bool density_assumed = true;
  const fragility::FragilityOptions& options;
};

void refuse(Assessed& all, FragilitySubject& s, base::Reject why) {
  s.rock.rejected = true;
  s.rock.reasons = {why.reason};
  s.rock.tipping = {};
  s.rock.tipping.reasons = {why.reason};
  all.rejects.push_back(std::move(why));
  ++all.grades[std::string(survey::name_of(s.rock.tipping.grade))];
  all.rocks.push_back(std::move(s.rock));
}

void write_products(const FragilitySubject& s, fragility::Assessment& assessment, const fs::path& folder) {
  auto& tip = assessment.tipping;
  if (!tip.critical) return;
  if (!assessment.draws.empty()) {
    tip.uncertainty->draws_file = s.stem + "_draws.csv";
    write_draws(folder / tip.uncertainty->draws_file, assessment.draws);
  }
  base::write_file(folder / (s.stem + "_tipping.svg"),
                   fragility::polar_plot_svg(tip, s.rock.object_class + " " + s.stem, s.north));
}

void assess_one(Assessed& all, FragilitySubject& s, const fs::path& folder, const Means& means,
                const base::RunContext& ctx) {
  if (means.gaps) take_coverage(s, *means.gaps);
  // Drawn by the rock's id: another rock in the folder, or a thread, changes nothing.
  const std::string stage = "fragility " + std::to_string(s.rock.target.value);
  auto assessment =
      fragility::assess(s.for_assessment(), means.options, [&](std::uint64_t draw) { return ctx.random(stage, draw); });
  write_products(s, assessment, folder);
  s.rock.tipping = assessment.tipping;
  s.rock.shape_ratios = fragility::shape_ratios(*s.mesh, *s.rock.mass);
  if (s.rock.tipping.critical)
    base::write_file(folder / (s.stem + "_tipping.json"), tipping_detail(s.rock, assessment).dump() + "\n");
  ++all.grades[std::string(survey::name_of(s.rock.tipping.grade))];
  all.rows.push(rock_summary(s.rock, s.stem, s.north));
  all.rocks.push_back(std::move(s.rock));
}

Assessed assess_all(std::vector<FragilitySubject> subjects, const fs::path& folder, const Means& means,
                    base::RunContext& ctx) {
  Assessed all;
  std::uint64_t done = 0;
  const bool single = subjects.size() == 1;
  for (auto& s : subjects) {
    ctx.check_stop();
    ctx.progress("rocks", ++done, subjects.size());
    s.rock.density_kg_m3 = means.options.density_kg_m3;
    s.rock.density_assumed = means.density_assumed;
    if (!s.mesh) {
      const std::string reason = s.rock.reasons.empty() ? "no_surface" : s.rock.reasons.front();
      refuse(all, s, {"rock " + s.stem, reason, s.refusal});
      continue;
    }
    if (means.contact)
      if (auto why = take_contact(s, *means.contact, single)) {
        refuse(all, s, std::move(*why));
        continue;
      }
    assess_one(all, s, folder, means, ctx);
  }
  return all;
}

Outcome outcome_of(Assessed& all) {
  io::Json grades = io::Json::object();
  for (const auto& [name, count] : all.grades) grades.set(name, count);
  Outcome outcome;
  outcome.rejects = std::move(all.rejects);
  outcome.summary = io::Json::object({{"assessed", all.rows.size()},
                                      {"rejected", outcome.rejects.size()},
                                      {"rejected_by_reason", count_by_reason(outcome.rejects)},
                                      {"by_grade", std::move(grades)},
                                      {"rocks", std::move(all.rows)}});
  return outcome;
}

class FragilityStage final : public Stage {
 public:
  [[nodiscard]] std::string_view name() const override { return "fragility"; }
  [[nodiscard]] std::vector<std::string> needs() const override { return {"segment", "surface"}; }
  [[nodiscard]] base::VisitOptions options() override { return base::bind_options(options_); }
  [[nodiscard]] Estimate estimate(const StageInputs&) const override { return {std::uint64_t{128} << 20, 16U << 20}; }

  Outcome run(const StageInputs& in, const fs::path& out, base::RunContext& ctx) override {
    base::validate(options(), "fragility");
    const auto survey = io::read_survey(in.survey);
    fs::create_directories(out / "rocks");
    const fs::path folder = in.products / "rocks";
    auto subjects = fs::is_directory(folder) ? subjects_of_folder(folder) : std::vector<FragilitySubject>{};
    const bool assumed = options_.density_kg_m3 == fragility::FragilityOptions{}.density_kg_m3;
    auto all = assess_all(std::move(subjects), out / "rocks", {std::nullopt, std::nullopt, assumed, options_}, ctx);
    io::RocksFile file{survey.manifest.origin, all.rocks};
    add_uncut(file, in.products / "segments.json");
    io::write_rocks(out / "rocks.json", file);
    return outcome_of(all);
  }

 private:
  // Targets that were never cut stand in rocks.json too, with their reason.
  void add_uncut(io::RocksFile& file, const fs::path& segments) const {
    const auto json = io::read_json(segments);
    for (const auto& row : json.at("segments").as_array()) {
      if (!row.at("rejected").as_bool()) continue;
      survey::Rock rock;
      rock.target = survey::TargetId(row.at("id").as_integer());
      rock.object_class = row.at("class").as_string();
      rock.rejected = true;
      for (const auto& reason : row.at("reasons").as_array()) rock.reasons.push_back(reason.as_string());
      rock.tipping.reasons = rock.reasons;
      rock.density_kg_m3 = options_.density_kg_m3;
      file.rocks.push_back(std::move(rock));
    }
    std::sort(file.rocks.begin(), file.rocks.end(),
              [](const survey::Rock& a, const survey::Rock& b) { return a.target < b.target; });
  }

  fragility::FragilityOptions options_;
};

}  // namespace

Outcome fragility_files(const FragilityFiles& in, const fs::path& out, bool density_assumed,
                        const fragility::FragilityOptions& options, base::RunContext& ctx) {
  std::optional<io::ContactFile> contact;
  if (!in.contact.empty()) {
    contact = io::read_contact_csv(in.contact);
    if (!contact->crs.empty() && contact->crs != "local")
      throw Error(ErrorCode::crs_mismatch, "the contact is not in the mesh's frame")
          .file(in.contact.string())
          .found(contact->crs)
          .allowed("# crs: local (the frame of the mesh)")
          .hint("Convert the contact line to the mesh's frame");
  }
  if (!fs::exists(in.input)) throw Error(ErrorCode::not_found, "no such mesh or folder").file(in.input.string());
  std::optional<std::vector<survey::CoverageGap>> gaps;
  if (!in.coverage.empty()) gaps = read_coverage_gaps(in.coverage);
  std::vector<FragilitySubject> subjects;
  if (fs::is_directory(in.input)) subjects = subjects_of_folder(in.input);
  else subjects.push_back(subject_of_mesh(in.input, options));
  if (subjects.empty())
    throw Error(ErrorCode::invalid_input, "the folder holds no rock")
        .file(in.input.string())
        .allowed("<id>.json with <id>.ply, as cairn surface writes them");
  const bool single_mesh = !fs::is_directory(in.input);
  auto all = assess_all(std::move(subjects), out, {std::move(contact), std::move(gaps), density_assumed, options}, ctx);
  if (single_mesh && !all.rejects.empty()) {
    const auto& why = all.rejects.front();
    throw Error(ErrorCode::invalid_input, why.reason == "contact_outside_rock" ? "the contact does not lie at the rock"
                                                                               : "the mesh is not a closed body")
        .file(why.reason == "contact_outside_rock" ? in.contact.string() : in.input.string())
        .found(why.reason + ": " + why.message)
        .allowed("one closed surface, and a contact at its base");
  }
  io::Json list = io::Json::array();
  for (const auto& rock : all.rocks) list.push(io::to_json(rock));
  // Without a survey no frame is known; a made-up origin would place the rocks somewhere.
  const auto records = io::Json::object({{"schema_version", 1}, {"frame", io::Json()}, {"rocks", std::move(list)}});
  base::write_file(out / "rocks.json", records.dump() + "\n");
  return outcome_of(all);
}

std::unique_ptr<Stage> make_fragility_stage() {
  return std::make_unique<FragilityStage>();
}

}  // namespace cairn::pipeline
