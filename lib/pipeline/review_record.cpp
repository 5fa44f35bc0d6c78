#include "pipeline/review_record.hpp"

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/edits_csv.hpp"
#include "io/json.hpp"

namespace cairn::pipeline {
namespace {

constexpr std::int64_t kVersion = 1;

survey::Edit edit_from(const io::Json& json) {
  survey::Edit e;
  e.rock_id = json.at("rock_id").as_string();
  const auto action = survey::edit_action_from(json.at("action").as_string());
  const auto time = io::parse_utc_ns(json.at("time").as_string());
  if (!action || !time)
    throw base::Error(base::ErrorCode::invalid_input, "a decision of the record cannot be read").found(json.dump(0));
  e.action = *action;
  e.value = json.at("value").as_string();
  e.reason = json.at("reason").as_string();
  e.reviewer = json.at("operator").as_string();
  e.time = json.at("time").as_string();
  e.time_ns = *time;
  return e;
}

}  // namespace

ReviewRecord read_review(const std::filesystem::path& path) {
  const io::Json json = io::read_json(path);
  try {
    if (const auto version = json.at("schema_version").as_integer(); version != kVersion)
      throw base::Error(base::ErrorCode::invalid_input, "unknown schema version")
          .found(std::to_string(version))
          .allowed(std::to_string(kVersion));
    ReviewRecord record;
    for (const auto& e : json.at("edits").as_array()) record.edits.push_back(edit_from(e));
    for (const auto& r : json.at("rocks").as_array()) {
      ReviewedRock& rock = record.rocks[r.at("id").as_integer()];
      rock.judgement = r.at("judgement").as_string();
      rock.reviewer = r.at("operator").as_string();
      rock.time = r.at("time").as_string();
      rock.reason = r.at("reason").as_string();
      for (const auto& note : r.at("notes").as_array()) rock.notes.push_back(note.as_string());
      for (const auto& [name, value] : r.at("fields").as_object()) rock.fields.emplace_back(name, value.as_string());
    }
    for (const auto& a : json.at("aliases").as_array())
      record.aliases[a.at("id").as_integer()] = a.at("answers").as_integer();
    record.next_id = json.at("next_id").as_integer();
    return record;
  } catch (base::Error& error) {
    error.default_file(path.string());
    throw;
  }
}

void write_review(const std::filesystem::path& path, const ReviewRecord& record) {
  io::Json edits = io::Json::array(), rocks = io::Json::array(), aliases = io::Json::array();
  for (const auto& e : record.edits)
    edits.push(io::Json::object({{"rock_id", e.rock_id},
                                 {"action", survey::name_of(e.action)},
                                 {"value", e.value},
                                 {"reason", e.reason},
                                 {"operator", e.reviewer},
                                 {"time", e.time}}));
  for (const auto& [id, rock] : record.rocks) {
    io::Json fields = io::Json::object();
    for (const auto& [name, value] : rock.fields) fields.set(name, value);
    rocks.push(io::Json::object({{"id", id},
                                 {"judgement", rock.judgement},
                                 {"operator", rock.reviewer},
                                 {"time", rock.time},
                                 {"reason", rock.reason},
                                 {"notes", io::Json(rock.notes)},
                                 {"fields", std::move(fields)}}));
  }
  for (const auto& [id, answers] : record.aliases) aliases.push(io::Json::object({{"id", id}, {"answers", answers}}));
  const auto json = io::Json::object({{"schema_version", kVersion},
                                      {"edits", std::move(edits)},
                                      {"rocks", std::move(rocks)},
                                      {"aliases", std::move(aliases)},
                                      {"next_id", record.next_id}});
  base::write_file(path, json.dump() + "\n");
}

}  // namespace cairn::pipeline
