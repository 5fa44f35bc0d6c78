#include "pipeline/json_fields.hpp"

#include <algorithm>
#include <utility>

#include "base/error.hpp"

namespace cairn::pipeline {
namespace {

std::string kind_of(const io::Json& json) {
  if (json.is_null()) return "null";
  if (json.is_object()) return "an object";
  if (json.is_array()) return "a list";
  return json.dump(0);
}

}  // namespace

JsonFields::JsonFields(const io::Json& json, std::string path) : json_(&json), path_(std::move(path)) {
  if (!json.is_object()) fail("", "the wrong kind of value", kind_of(json), "an object");
}

std::string JsonFields::path_of(std::string_view name) const {
  if (name.empty()) return path_.empty() ? "scene" : path_;
  return path_.empty() ? std::string(name) : path_ + "." + std::string(name);
}

void JsonFields::fail(std::string_view name, std::string message, std::string found, std::string allowed) const {
  throw base::Error(base::ErrorCode::invalid_input, std::move(message))
      .record(path_of(name))
      .found(found)
      .allowed(allowed);
}

const io::Json* JsonFields::find(std::string_view name) {
  known_.emplace_back(name);
  return json_->find(name);
}

const io::Json* JsonFields::raw(std::string_view name) {
  return find(name);
}

void JsonFields::require(std::string_view name) const {
  if (!has(name)) fail(name, "a member is missing", "nothing", "a value");
}

double JsonFields::number(const io::Json& json, std::string_view name) const {
  if (!json.is_number()) fail(name, "the wrong kind of value", kind_of(json), "a number");
  return json.as_real();
}

void JsonFields::real(std::string_view name, double& value) {
  if (const auto* json = find(name)) value = number(*json, name);
}

void JsonFields::real(std::string_view name, std::optional<double>& value) {
  if (const auto* json = find(name)) value = number(*json, name);
}

void JsonFields::integer(std::string_view name, std::int64_t& value) {
  const auto* json = find(name);
  if (json == nullptr) return;
  if (!json->is_integer()) fail(name, "the wrong kind of value", kind_of(*json), "an integer");
  value = json->as_integer();
}

void JsonFields::seed(std::string_view name, std::uint64_t& value) {
  std::int64_t number = static_cast<std::int64_t>(value);
  integer(name, number);
  if (number < 0) fail(name, "a seed is negative", std::to_string(number), ">= 0");
  value = static_cast<std::uint64_t>(number);
}

void JsonFields::flag(std::string_view name, bool& value) {
  const auto* json = find(name);
  if (json == nullptr) return;
  if (!json->is_bool()) fail(name, "the wrong kind of value", kind_of(*json), "true or false");
  value = json->as_bool();
}

void JsonFields::text(std::string_view name, std::string& value) {
  const auto* json = find(name);
  if (json == nullptr) return;
  if (!json->is_string()) fail(name, "the wrong kind of value", kind_of(*json), "text");
  value = json->as_string();
}

void JsonFields::texts(std::string_view name, std::vector<std::string>& value) {
  const auto* json = find(name);
  if (json == nullptr) return;
  const std::string allowed = "a list of texts";
  if (!json->is_array()) fail(name, "the wrong kind of value", kind_of(*json), allowed);
  value.clear();
  for (const auto& item : json->as_array()) {
    if (!item.is_string()) fail(name, "the wrong kind of value", kind_of(item), allowed);
    value.push_back(item.as_string());
  }
}

std::optional<std::size_t> JsonFields::choice(std::string_view name, const std::vector<std::string_view>& allowed) {
  std::string value;
  text(name, value);
  if (!has(name)) return std::nullopt;
  std::string names;
  for (std::size_t i = 0; i < allowed.size(); ++i) {
    if (value == allowed[i]) return i;
    names += (names.empty() ? "" : ", ") + std::string(allowed[i]);
  }
  fail(name, "an unknown name", "'" + value + "'", names);
}

std::optional<std::vector<double>> JsonFields::reals(std::string_view name, std::size_t count) {
  const auto* json = find(name);
  if (json == nullptr) return std::nullopt;
  const std::string allowed = "a list of " + std::to_string(count) + " numbers";
  if (!json->is_array()) fail(name, "the wrong kind of value", kind_of(*json), allowed);
  if (json->size() != count) fail(name, "a list of the wrong length", std::to_string(json->size()), allowed);
  std::vector<double> values;
  for (const auto& item : json->as_array()) values.push_back(number(item, name));
  return values;
}

void JsonFields::area(std::string_view name, geometry::Ring& value) {
  const auto* json = find(name);
  if (json == nullptr) return;
  const std::string allowed = "a list of [east, north]: two opposite corners of a rectangle, or a polygon";
  if (!json->is_array() || json->size() < 2) fail(name, "this is no area", kind_of(*json), allowed);
  value.clear();
  for (const auto& item : json->as_array()) {
    if (!item.is_array() || item.size() != 2) fail(name, "this is no area", kind_of(item), allowed);
    value.emplace_back(number(item.as_array()[0], name), number(item.as_array()[1], name));
  }
  if (value.size() > 2) return;
  const geometry::Vec2 lo = value[0].cwiseMin(value[1]), hi = value[0].cwiseMax(value[1]);
  value = {lo, {hi.x(), lo.y()}, hi, {lo.x(), hi.y()}};
}

void JsonFields::object(std::string_view name, const std::function<void(JsonFields&)>& read) {
  const auto* json = find(name);
  if (json == nullptr) return;
  JsonFields fields(*json, path_of(name));
  read(fields);
  fields.finish();
}

void JsonFields::list(std::string_view name, const std::function<void(JsonFields&)>& read) {
  const auto* json = find(name);
  if (json == nullptr) return;
  if (!json->is_array()) fail(name, "the wrong kind of value", kind_of(*json), "a list");
  std::size_t index = 0;
  for (const auto& item : json->as_array()) {
    JsonFields fields(item, path_of(name) + "[" + std::to_string(index++) + "]");
    read(fields);
    fields.finish();
  }
}

void JsonFields::finish() const {
  for (const auto& [key, value] : json_->as_object()) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string allowed;
    for (const auto& name : known_) allowed += (allowed.empty() ? "" : ", ") + name;
    throw base::Error(base::ErrorCode::invalid_input, "an unknown member").record(path_of(key)).allowed(allowed);
  }
}

}  // namespace cairn::pipeline
