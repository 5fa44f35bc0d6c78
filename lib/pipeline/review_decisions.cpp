#include "pipeline/review_decisions.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "report/inventory.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using survey::Edit;
using survey::EditAction;

constexpr std::array<std::string_view, 3> kJudgements{"precarious", "semi_precarious", "not_precarious"};

std::vector<std::string_view> pieces(std::string_view text, char separator) {
  std::vector<std::string_view> out;
  while (true) {
    const auto end = text.find(separator);
    out.push_back(base::trim(text.substr(0, end)));
    if (end == std::string_view::npos) return out;
    text = text.substr(end + 1);
  }
}

class Planner {
 public:
  Planner(std::vector<survey::Rock> rocks, ReviewRecord before, const ReviewContext& context) : context_(context) {
    plan_.record = std::move(before);
    std::int64_t greatest = -1;
    for (auto& rock : rocks) {
      greatest = std::max(greatest, rock.target.value);
      if (rock.rejected) rejected_by_.emplace(rock.target.value, reasons_text(rock));
      rocks_.emplace(rock.target.value, std::move(rock));
    }
    for (const auto& [id, answers] : plan_.record.aliases) greatest = std::max(greatest, id);
    plan_.record.next_id = std::max(plan_.record.next_id, greatest + 1);
  }

  void apply(const Edit& edit) {
    edit_ = &edit;
    const std::int64_t id = resolve(edit.rock_id);
    survey::Rock& rock = rocks_.at(id);
    switch (edit.action) {
      case EditAction::accept:
        rock.rejected = false;
        rock.reasons.clear();
        rejected_by_.erase(id);
        break;
      case EditAction::reject:
        rock.rejected = true;
        rock.reasons = {"rejected_in_review"};
        rejected_by_[id] = "line " + std::to_string(edit.line) + " of " + context_.edits_file.filename().string();
        break;
      case EditAction::merge: merge(id); break;
      case EditAction::split: split(id); break;
      case EditAction::reclassify: reclassify(rock); break;
      case EditAction::set: set(rock); break;
      case EditAction::note: plan_.record.rocks[id].notes.push_back(edit.value); break;
    }
    if (edit.action != EditAction::note) rocks_.at(id).review = survey::name_of(edit.action);
    ReviewedRock& facts = plan_.record.rocks[id];
    facts.reviewer = edit.reviewer;
    facts.time = edit.time;
    if (!edit.reason.empty()) facts.reason = edit.reason;
    plan_.record.edits.push_back(edit);
    ++plan_.applied[std::string(survey::name_of(edit.action))];
  }

  ReviewPlan take() {
    // A rock that was merged later is not computed for its own sake.
    for (const auto id : plan_.gone) {
      plan_.reshaped.erase(id);
      plan_.densities.erase(id);
    }
    for (auto& [id, rock] : rocks_) plan_.rocks.push_back(std::move(rock));
    return std::move(plan_);
  }

 private:
  static std::string reasons_text(const survey::Rock& rock) {
    std::string text = "the automatic result: ";
    for (const auto& reason : rock.reasons) text += (&reason == &rock.reasons.front() ? "" : ", ") + reason;
    return rock.review == "reject" ? "an earlier review" : text;
  }

  [[nodiscard]] Error refuse(std::string message, ErrorCode code = ErrorCode::invalid_input) const {
    return Error(code, std::move(message))
        .file(context_.edits_file.string())
        .record("line " + std::to_string(edit_->line) + ", rock " + edit_->rock_id);
  }

  [[nodiscard]] std::string known_ids() const {
    if (rocks_.empty()) return "none: the result has no rocks";
    std::string text;
    std::size_t n = 0;
    for (const auto& [id, rock] : rocks_) {
      if (++n > 12) return text + ", ... " + std::to_string(rocks_.rbegin()->first);
      text += (n == 1 ? "" : ", ") + std::to_string(id);
    }
    return text;
  }

  // The rock that answers to this id now.
  [[nodiscard]] std::int64_t resolve(std::string_view text) const {
    auto number = base::parse_integer(text);
    if (!number) {
      const auto dash = text.rfind('-');
      if (dash != std::string_view::npos) number = base::parse_integer(text.substr(dash + 1));
      if (number && text.substr(0, dash) != context_.slug)
        throw refuse("the id is one of another survey")
            .found("'" + std::string(text) + "'")
            .allowed("numbers of this result, or ids that begin with '" + context_.slug + "-'");
    }
    std::int64_t id = number.value_or(-1);
    for (auto it = plan_.record.aliases.find(id); it != plan_.record.aliases.end(); it = plan_.record.aliases.find(id))
      id = it->second;
    if (!number || !rocks_.contains(id))
      throw refuse("no rock of the result has this id").found("'" + std::string(text) + "'").allowed(known_ids());
    return id;
  }

  void require_points() const {
    if (!context_.has_points)
      throw refuse("the result holds no labelled points to " + std::string(survey::name_of(edit_->action)),
                   ErrorCode::failed_precondition)
          .hint("Review the folder of cairn run, which holds labelled.las");
  }

  void require_not_rejected(std::int64_t id) const {
    const auto it = rejected_by_.find(id);
    if (it == rejected_by_.end()) return;
    throw refuse("rock " + std::to_string(id) + " was rejected by " + it->second + ": it cannot be " +
                 (edit_->action == EditAction::merge ? "merged" : "split"))
        .allowed("rocks that are not rejected")
        .hint("Append an accept for it first, or leave it out");
  }

  void merge(std::int64_t id) {
    require_points();
    require_not_rejected(id);
    for (const auto piece : pieces(edit_->value, ';')) {
      const std::int64_t other = resolve(piece);
      if (other == id)
        throw refuse("a rock cannot be merged with itself")
            .found("'" + std::string(piece) + "', which is rock " + std::to_string(id))
            .allowed("ids of other rocks");
      require_not_rejected(other);
      PointChange change;
      change.line = edit_->line;
      change.rock = id;
      change.merged = other;
      plan_.changes.push_back(change);
      plan_.reshaped.insert(id);
      plan_.gone.insert(other);
      plan_.record.aliases[other] = id;
      survey::Rock& rock = rocks_.at(id);
      const survey::Rock& part = rocks_.at(other);
      rock.aliases.emplace_back(other);
      rock.aliases.insert(rock.aliases.end(), part.aliases.begin(), part.aliases.end());
      rock.supersedes.emplace_back(other);
      rock.supersedes.insert(rock.supersedes.end(), part.supersedes.begin(), part.supersedes.end());
      std::sort(rock.aliases.begin(), rock.aliases.end());
      std::sort(rock.supersedes.begin(), rock.supersedes.end());
      if (const auto facts = plan_.record.rocks.find(other); facts != plan_.record.rocks.end()) {
        auto& notes = plan_.record.rocks[id].notes;
        notes.insert(notes.end(), facts->second.notes.begin(), facts->second.notes.end());
        plan_.record.rocks.erase(other);
      }
      plan_.born.erase(other);
      rocks_.erase(other);
    }
  }

  void split(std::int64_t id) {
    require_points();
    require_not_rejected(id);
    PointChange change;
    change.line = edit_->line;
    change.rock = id;
    std::size_t axes = 0;
    for (const auto piece : pieces(edit_->value, ';')) {
      const auto numbers = pieces(piece, ',');
      geometry::Vec3 seed = geometry::Vec3::Zero();
      bool good = (numbers.size() == 2 || numbers.size() == 3) && (axes == 0 || axes == numbers.size());
      for (std::size_t i = 0; good && i < numbers.size(); ++i) {
        const auto value = base::parse_real(numbers[i]);
        good = value && std::isfinite(*value);
        if (good) seed[static_cast<Eigen::Index>(i)] = *value;
      }
      if (!good)
        throw refuse("a seed of the split cannot be read")
            .found("'" + std::string(piece) + "'")
            .allowed("east,north or east,north,up in the local frame [m], one way for all seeds");
      axes = numbers.size();
      change.seeds.push_back(seed);
    }
    change.seeds_have_height = axes == 3;
    if (change.seeds.size() < 2)
      throw refuse("a split needs a seed for each part").found("one seed").allowed("two or more: 3.1,2.0;4.0,2.2");
    change.parts.push_back(id);
    plan_.reshaped.insert(id);
    for (std::size_t i = 1; i < change.seeds.size(); ++i) {
      survey::Rock part;
      part.target = survey::TargetId(plan_.record.next_id++);
      part.object_class = rocks_.at(id).object_class;
      part.density_kg_m3 = rocks_.at(id).density_kg_m3;
      part.density_assumed = rocks_.at(id).density_assumed;
      part.supersedes = {survey::TargetId(id)};
      part.review = "split";
      const auto density = plan_.densities.find(id);
      if (density != plan_.densities.end()) plan_.densities[part.target.value] = density->second;
      change.parts.push_back(part.target.value);
      plan_.reshaped.insert(part.target.value);
      plan_.born[part.target.value] = id;
      ReviewedRock& facts = plan_.record.rocks[part.target.value];
      facts.reviewer = edit_->reviewer;
      facts.time = edit_->time;
      facts.reason = edit_->reason;
      rocks_.emplace(part.target.value, std::move(part));
    }
    plan_.changes.push_back(std::move(change));
  }

  void reclassify(survey::Rock& rock) {
    const std::string& value = edit_->value;
    const bool word = std::all_of(value.begin(), value.end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
    if (!word)
      throw refuse("not a class")
          .found("'" + value + "'")
          .allowed("a word of small letters, digits and underscores: boulder, tree, precarious, ...");
    if (std::find(kJudgements.begin(), kJudgements.end(), value) != kJudgements.end())
      plan_.record.rocks[rock.target.value].judgement = value;
    else rock.object_class = value;
  }

  void set(survey::Rock& rock) {
    const auto equals = edit_->value.find('=');
    if (equals == std::string::npos || equals == 0)
      throw refuse("a value to set needs its field").found("'" + edit_->value + "'").allowed("field=value");
    const std::string_view name = base::trim(std::string_view(edit_->value).substr(0, equals));
    const std::string value(base::trim(std::string_view(edit_->value).substr(equals + 1)));
    const auto field = report::inventory_field(name);
    if (!field) {
      std::string known;
      for (const auto& f : report::inventory_fields()) known += (known.empty() ? "" : ", ") + f.name;
      throw refuse("no such field").found("'" + std::string(name) + "'").allowed(known);
    }
    if (const auto problem = report::field_problem(*field, value); !problem.empty())
      throw refuse("the value does not fit the field '" + *field + "'").found("'" + value + "'").allowed(problem);
    auto& fields = plan_.record.rocks[rock.target.value].fields;
    std::erase_if(fields, [&](const auto& f) { return f.first == *field; });
    fields.emplace_back(*field, value);
    if (*field == "name") rock.name = value;
    if (*field == "density_kg_m3") {
      if (!context_.has_meshes)
        throw refuse("the result holds no meshes to weigh", ErrorCode::failed_precondition)
            .hint("Review the folder of cairn run, or run cairn fragility with --density");
      plan_.densities[rock.target.value] = *base::parse_real(value);
    }
  }

  const ReviewContext& context_;
  ReviewPlan plan_;
  std::map<std::int64_t, survey::Rock> rocks_;
  std::map<std::int64_t, std::string> rejected_by_;
  const Edit* edit_ = nullptr;
};

}  // namespace

ReviewPlan plan_review(std::vector<survey::Rock> rocks, const ReviewRecord& before, const std::vector<Edit>& edits,
                       const ReviewContext& context) {
  for (std::size_t i = 0; i < before.edits.size(); ++i) {
    if (i < edits.size() && edits[i] == before.edits[i]) continue;
    const std::string was = before.edits[i].rock_id + ", " + std::string(survey::name_of(before.edits[i].action)) +
                            ", " + before.edits[i].time;
    throw Error(ErrorCode::invalid_input, "the decisions that this result was made by are not at the head of the file")
        .file(context.edits_file.string())
        .record(i < edits.size() ? "line " + std::to_string(edits[i].line) : "end of file")
        .allowed("decision " + std::to_string(i + 1) + ": " + was)
        .hint("edits.csv is append-only: restore its earlier rows, or review the unreviewed result");
  }
  Planner planner(std::move(rocks), before, context);
  for (std::size_t i = before.edits.size(); i < edits.size(); ++i) planner.apply(edits[i]);
  return planner.take();
}

}  // namespace cairn::pipeline
