#include "pipeline/review_stage.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/edits_csv.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"
#include "io/targets_json.hpp"
#include "pipeline/fragility_stage.hpp"
#include "pipeline/inventory_stage.hpp"
#include "pipeline/review_decisions.hpp"
#include "pipeline/review_points.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/surface_stage.hpp"
#include "report/inventory.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using Ids = std::set<std::int64_t>;

// Made from all rocks together: copied they would tell the state before the review.
constexpr std::array<std::string_view, 3> kSummaries{"layers", "inventory", "report"};
constexpr std::array<std::string_view, 8> kStaleFiles{"run.json",      "edits.csv",         "review.json",
                                                      "layers.gpkg",   "inventory.geojson", "inventory.csv",
                                                      "inventory.kml", "rocks.json"};

// The rock a file of rocks/ belongs to: 7.ply, 7_tipping.svg.
std::optional<std::int64_t> rock_of_file(const fs::path& file) {
  const std::string name = file.filename().string();
  return base::parse_integer(name.substr(0, name.find_first_not_of("0123456789")));
}

bool is_stale(const fs::path& relative, const Ids& changed) {
  const std::string first = relative.begin()->string(), name = relative.filename().string();
  if (first == "inventory" || first == "report") return true;
  if (first == ".cairn") {
    if (name == "job.json" || name == "lock") return true;
    return std::any_of(kSummaries.begin(), kSummaries.end(),
                       [&](auto stage) { return name == std::string(stage) + ".json"; });
  }
  if (first == "rocks") {
    const auto id = rock_of_file(relative);
    return id && changed.contains(*id);
  }
  return relative.parent_path().empty() && std::find(kStaleFiles.begin(), kStaleFiles.end(), name) != kStaleFiles.end();
}

void copy_product(const fs::path& from, const fs::path& to) {
  std::error_code code;
  fs::create_directories(to.parent_path(), code);
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, code);
  if (code) throw Error(ErrorCode::resource_exhausted, "cannot copy: " + code.message()).file(to.string());
}

void copy_rest(const fs::path& from, const fs::path& to, const Ids& changed) {
  for (const auto& entry : fs::recursive_directory_iterator(from)) {
    if (!entry.is_regular_file()) continue;
    const fs::path relative = entry.path().lexically_relative(from);
    if (!is_stale(relative, changed)) copy_product(entry.path(), to / relative);
  }
}

// A folder inside the staged one for what is computed again; goes away with the object.
class WorkFolder {
 public:
  explicit WorkFolder(fs::path path) : path_(std::move(path)) { fs::create_directories(path_); }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  [[nodiscard]] fs::path operator/(std::string_view name) const { return path_ / name; }

 private:
  fs::path path_;
};

class Review {
 public:
  Review(const ReviewFiles& files, const fs::path& out, base::RunContext& ctx)
      : files_(files), out_(out), ctx_(ctx), work_(out / ".review") {
    if (const fs::path run = files.result / "run.json"; fs::exists(run)) run_ = io::read_json(run);
    const io::Json rocks = io::read_json(files.result / "rocks.json");
    if (const io::Json* frame = rocks.find("frame")) frame_ = *frame;
  }

  Outcome run(ReviewPlan plan, std::size_t already) {
    Ids changed = plan.reshaped;
    for (const auto& [id, density] : plan.densities) changed.insert(id);
    Ids removed = changed;
    removed.insert(plan.gone.begin(), plan.gone.end());
    copy_rest(files_.result, out_, removed);
    if (!plan.changes.empty()) reshape(plan);
    // Meshes of rocks that keep their shape stay what they are.
    for (const auto& [id, density] : plan.densities)
      if (!plan.reshaped.contains(id))
        for (const auto& entry : fs::directory_iterator(files_.result / "rocks"))
          if (rock_of_file(entry.path()) == id && entry.path().filename().string().find('_') == std::string::npos)
            copy_product(entry.path(), out_ / "rocks" / entry.path().filename());
    tip(plan, changed);
    write_rocks(plan);
    if (fs::exists(files_.result / "targets.json") && !frame_.is_null()) write_targets(plan);
    write_review(out_ / "review.json", plan.record);
    copy_product(files_.edits, out_ / "edits.csv");
    std::vector<std::string> again = summaries();
    return outcome(plan, changed, already, again);
  }

 private:
  // A stage with the options the result was made with.
  [[nodiscard]] std::unique_ptr<Stage> stage(std::string_view name) const {
    auto made = make_stage(name);
    if (!made) throw Error(ErrorCode::internal, "no such stage").found(name);
    const io::Json* stages = run_.is_object() ? run_.find("stages") : nullptr;
    if (stages != nullptr && stages->is_array())
      for (const auto& s : stages->as_array())
        if (s.at("stage").as_string() == name)
          for (const auto& [option, value] : s.at("options").as_object())
            base::set_option(made->options(), option, value.is_string() ? value.as_string() : value.dump(0));
    return made;
  }

  [[nodiscard]] fs::path survey() const {
    if (!files_.survey.empty()) return files_.survey;
    // The stages that compute rocks take the frame alone from the survey.
    const fs::path made = work_ / "survey";
    if (!fs::exists(made)) {
      fs::create_directories(made);
      survey::Survey survey;
      survey.manifest.name = "reviewed result";
      if (!frame_.is_null()) survey.manifest.origin = io::origin_from_json(frame_);
      io::write_survey(survey, made);
    }
    return made;
  }

  void run_stage(std::string_view name, const fs::path& products, const fs::path& to,
                 const std::vector<std::string>& available, const std::map<std::string, std::string>& options = {}) {
    auto made = stage(name);
    for (const auto& [option, value] : options) base::set_option(made->options(), option, value);
    try {
      Outcome outcome = made->run({survey(), products, available}, to, ctx_);
      for (auto& reject : outcome.rejects) rejects_.push_back(std::move(reject));
    } catch (Error& error) {
      error.in("stage " + std::string(name));
      throw;
    }
  }

  // labelled.las, segments.json and contact.csv with the points' new owners, then the surfaces of the rocks they make.
  void reshape(ReviewPlan& plan) {
    auto file = io::read_cloud(files_.result / "labelled.las");
    const auto points = change_points(file.cloud, plan, files_.edits);
    io::CloudWriteOptions write;
    write.crs = file.facts.crs;
    if (write.crs.rfind("EPSG:", 0) != 0) write.crs_wkt = write.crs;
    if (file.las) write.las = &*file.las;
    io::write_cloud(out_ / "labelled.las", file.cloud, write);
    write_segments(plan, points);

    const fs::path products = work_ / "products";
    fs::create_directories(products);
    io::write_cloud(products / "labelled.las", only_rocks(std::move(file.cloud), plan.reshaped), write);
    copy_product(out_ / "segments.json", products / "segments.json");
    if (const fs::path contact = files_.result / "contact.csv"; fs::exists(contact)) {
      // The lines of merged and split rocks are no longer theirs: the surface derives new ones from the points.
      io::ContactFile lines = io::read_contact_csv(contact);
      std::erase_if(lines.rows, [&](const io::ContactRow& row) {
        return plan.reshaped.contains(row.rock_id) || plan.gone.contains(row.rock_id);
      });
      io::write_contact_csv(out_ / "contact.csv", lines);
    }
    const fs::path made = work_ / "surface";
    fs::create_directories(made);
    run_stage("surface", products, made, {"locate", "segment"});
    if (fs::exists(made / "rocks"))
      for (const auto& entry : fs::directory_iterator(made / "rocks"))
        copy_product(entry.path(), out_ / "rocks" / entry.path().filename());
  }

  void write_segments(const ReviewPlan& plan, const std::map<std::int64_t, std::size_t>& points) const {
    const io::Json json = io::read_json(files_.result / "segments.json");
    std::map<std::int64_t, io::Json> rows;
    for (const auto& row : json.at("segments").as_array()) rows.emplace(row.at("id").as_integer(), row);
    for (const auto& [id, parent] : plan.born)
      if (const auto it = rows.find(parent); it != rows.end()) {
        io::Json row = it->second;
        row.set("id", id);
        rows.insert_or_assign(id, std::move(row));
      }
    for (const auto id : plan.gone) rows.erase(id);
    for (const auto& [id, count] : points)
      if (const auto it = rows.find(id); it != rows.end()) {
        it->second.set("point_count", count);
        if (it->second.find("contact") != nullptr) it->second.set("contact", io::Json::array());
      }
    io::Json list = io::Json::array();
    for (auto& [id, row] : rows) list.push(std::move(row));
    io::Json written = json;
    written.set("segments", std::move(list));
    base::write_file(out_ / "segments.json", written.dump() + "\n");
  }

  // Tipping of the changed rocks, one run of the stage a density; their records take the place of the old ones.
  void tip(ReviewPlan& plan, const Ids& changed) {
    if (changed.empty()) return;
    std::map<std::optional<double>, Ids> by_density;
    for (const auto id : changed) {
      const auto density = plan.densities.find(id);
      std::optional<double> own;
      if (density != plan.densities.end()) own = density->second;
      else if (const auto it = rock(plan, id); it->density_kg_m3 > 0.0 && !it->density_assumed) own = it->density_kg_m3;
      by_density[own].insert(id);
    }
    int n = 0;
    for (const auto& [density, ids] : by_density) {
      const fs::path products = work_ / ("bodies" + std::to_string(n)), made = work_ / ("tipping" + std::to_string(n));
      ++n;
      fs::create_directories(products / "rocks");
      fs::create_directories(made);
      for (const auto& entry : fs::directory_iterator(out_ / "rocks"))
        if (const auto id = rock_of_file(entry.path()); id && ids.contains(*id))
          copy_product(entry.path(), products / "rocks" / entry.path().filename());
      base::write_file(products / "segments.json", "{\"schema_version\": 1, \"segments\": []}\n");
      std::map<std::string, std::string> options;
      if (density) options["density"] = base::to_text(*density);
      run_stage("fragility", products, made, {"locate", "segment", "surface"}, options);
      for (auto& fresh : io::read_rocks(made / "rocks.json").rocks) {
        auto it = rock(plan, fresh.target.value);
        if (it == plan.rocks.end()) continue;
        // What people decided stays; an automatic rejection of the new shape counts.
        fresh.object_class = it->object_class;
        fresh.name = it->name;
        fresh.aliases = it->aliases;
        fresh.supersedes = it->supersedes;
        fresh.review = it->review;
        if (it->rejected) {
          fresh.rejected = true;
          fresh.reasons = it->reasons;
        }
        if (density) fresh.density_assumed = false;
        *it = std::move(fresh);
      }
      for (const auto& entry : fs::recursive_directory_iterator(made)) {
        const fs::path relative = entry.path().lexically_relative(made);
        if (entry.is_regular_file() && relative != "rocks.json") copy_product(entry.path(), out_ / relative);
      }
    }
  }

  static std::vector<survey::Rock>::iterator rock(ReviewPlan& plan, std::int64_t id) {
    return std::find_if(plan.rocks.begin(), plan.rocks.end(), [id](const auto& r) { return r.target.value == id; });
  }

  void write_rocks(const ReviewPlan& plan) const {
    io::Json list = io::Json::array();
    for (const auto& r : plan.rocks) list.push(io::to_json(r));
    base::write_file(
        out_ / "rocks.json",
        io::Json::object({{"schema_version", 1}, {"frame", frame_}, {"rocks", std::move(list)}}).dump() + "\n");
  }

  // Merged targets are given up with a reason; parts of a split get a target of their own.
  void write_targets(const ReviewPlan& plan) const {
    if (plan.changes.empty()) return;
    auto file = io::read_targets(files_.result / "targets.json");
    std::map<std::int64_t, survey::Target> targets;
    for (auto& t : file.targets) targets.emplace(t.id.value, std::move(t));
    for (const auto& [id, parent] : plan.born) {
      const auto it = targets.find(parent);
      if (it == targets.end()) continue;
      survey::Target part = it->second;
      part.id = survey::TargetId(id);
      part.bcylinder.reset();
      part.refined.reset();
      part.detections.clear();
      part.keyframes.clear();
      part.history.clear();
      part.entropy_nats.clear();
      part.divergence.clear();
      part.reasons = {"split_in_review"};
      for (const auto& r : plan.rocks)
        if (r.target.value == id && r.mass) part.centre = r.mass->centre_of_mass;
      targets.emplace(id, std::move(part));
    }
    for (const auto id : plan.gone)
      if (const auto it = targets.find(id); it != targets.end()) {
        it->second.state = survey::TargetState::deregistered;
        it->second.reasons.emplace_back("merged_in_review");
      }
    file.targets.clear();
    for (auto& [id, target] : targets) file.targets.push_back(std::move(target));
    io::write_targets(out_ / "targets.json", file);
  }

  // Layers, inventory and report of the reviewed rocks, where the result had them.
  std::vector<std::string> summaries() {
    std::vector<std::string> had, available, made;
    if (fs::is_directory(files_.result / ".cairn"))
      for (const auto& entry : fs::directory_iterator(files_.result / ".cairn"))
        if (entry.path().extension() == ".json" && entry.path().stem() != "job")
          available.push_back(entry.path().stem().string());
    std::sort(available.begin(), available.end());
    // A result of review has no stage records of these; its run.json names what was made.
    const io::Json* stages = run_.is_object() ? run_.find("stages") : nullptr;
    for (const auto name : kSummaries) {
      bool there = std::find(available.begin(), available.end(), name) != available.end();
      if (stages != nullptr && stages->is_array())
        for (const auto& s : stages->as_array()) there = there || s.at("stage").as_string() == name;
      if (there) had.emplace_back(name);
    }
    std::erase_if(available, [](const std::string& name) {
      return std::find(kSummaries.begin(), kSummaries.end(), name) != kSummaries.end();
    });
    if (had.empty()) return made;
    if (files_.survey.empty()) {
      ctx_.warn("The survey is not known: layers, inventory and report are not made again; give --survey");
      return made;
    }
    for (const auto& name : had) {
      ctx_.info(name);
      run_stage(name, out_, out_, available);
      available.push_back(name);
      made.push_back(name);
    }
    return made;
  }

  [[nodiscard]] Outcome outcome(const ReviewPlan& plan, const Ids& changed, std::size_t already,
                                const std::vector<std::string>& again) {
    io::Json actions = io::Json::object(), ids = io::Json::array(), aliases = io::Json::object(),
             fresh = io::Json::array();
    for (const auto& [name, count] : plan.applied) actions.set(name, count);
    for (const auto id : changed) ids.push(id);
    for (const auto& [id, answers] : plan.record.aliases) aliases.set(std::to_string(id), answers);
    for (const auto& [id, parent] : plan.born) fresh.push(id);
    std::int64_t rejected = 0;
    for (const auto& r : plan.rocks) rejected += r.rejected ? 1 : 0;
    Outcome outcome;
    outcome.rejects = std::move(rejects_);
    outcome.summary = io::Json::object({{"decisions", plan.record.edits.size()},
                                        {"applied_before", already},
                                        {"applied", std::move(actions)},
                                        {"rocks", plan.rocks.size()},
                                        {"rejected", rejected},
                                        {"computed_again", std::move(ids)},
                                        {"aliases", std::move(aliases)},
                                        {"new_ids", std::move(fresh)},
                                        {"made_again", io::Json(again)}});
    return outcome;
  }

  const ReviewFiles& files_;
  fs::path out_;
  base::RunContext& ctx_;
  WorkFolder work_;
  io::Json run_, frame_;
  std::vector<base::Reject> rejects_;
};

std::vector<survey::Rock> rocks_in(const fs::path& file) {
  const io::Json json = io::read_json(file);
  std::vector<survey::Rock> rocks;
  try {
    for (const auto& record : json.at("rocks").as_array()) rocks.push_back(io::rock_from_json(record));
  } catch (Error& error) {
    error.default_file(file.string());
    throw;
  }
  return rocks;
}

}  // namespace

Outcome review_files(const ReviewFiles& files, const fs::path& out, base::RunContext& ctx) {
  const auto source = inventory_source(files.result);
  const auto edits = io::read_edits(files.edits);
  ReviewRecord before;
  if (const fs::path file = files.result / "review.json"; fs::exists(file)) before = read_review(file);
  ReviewContext context;
  context.edits_file = files.edits;
  context.slug = report::slug_of(source.name);
  context.has_points = fs::exists(files.result / "labelled.las") && fs::exists(files.result / "segments.json");
  context.has_meshes = fs::is_directory(files.result / "rocks");
  const std::size_t already = before.edits.size();
  auto plan = plan_review(rocks_in(files.result / "rocks.json"), before, edits, context);
  return Review(files, out, ctx).run(std::move(plan), already);
}

io::Json carried_record(const fs::path& result) {
  io::Json extra = io::Json::object();
  const fs::path file = result / "run.json";
  if (!fs::exists(file)) return extra;
  const io::Json run = io::read_json(file);
  for (const char* name : {"recipe", "stages"})
    if (const io::Json* member = run.find(name)) extra.set(name, *member);
  return extra;
}

std::uint64_t seed_of_result(const fs::path& result) {
  const fs::path file = result / "run.json";
  if (!fs::exists(file)) return 0;
  const io::Json run = io::read_json(file);
  const io::Json* seed = run.find("seed");
  return seed != nullptr && seed->is_integer() ? static_cast<std::uint64_t>(seed->as_integer()) : 0;
}

}  // namespace cairn::pipeline
