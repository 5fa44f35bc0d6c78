#include "io/json.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::io {
namespace {

std::string_view kind_name(std::size_t index) {
  constexpr std::string_view kNames[] = {"null", "true or false", "a whole number", "a number",
                                         "text", "a list",        "an object"};
  return kNames[index];
}

[[noreturn]] void wrong_kind(std::size_t found, std::string_view wanted) {
  throw base::Error(base::ErrorCode::invalid_input, "JSON value of the wrong kind")
      .found(kind_name(found))
      .allowed(wanted);
}

void escape(std::string& out, std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    switch (c) {
      case '"': out += "\\\""; break;
      case '\\': out += "\\\\"; break;
      case '\n': out += "\\n"; break;
      case '\r': out += "\\r"; break;
      case '\t': out += "\\t"; break;
      default:
        if (byte < 0x20) {
          out += "\\u00";
          out += kHex[byte >> 4];
          out += kHex[byte & 15];
        } else {
          out += c;
        }
    }
  }
  out += '"';
}

bool is_scalar(const Json& value) {
  return !value.is_array() && !value.is_object();
}

// Short lists of plain values (a coordinate, a matrix row) stay on one line.
bool fits_on_line(const Json::Array& items) {
  if (items.size() > 16) return false;
  for (const auto& item : items)
    if (!is_scalar(item)) return false;
  return true;
}

void write(std::string& out, const Json& value, int indent, int depth) {
  const auto line = [&](int level) {
    if (indent > 0) {
      out += '\n';
      out.append(static_cast<std::size_t>(indent * level), ' ');
    }
  };
  if (value.is_null()) {
    out += "null";
  } else if (value.is_bool()) {
    out += value.as_bool() ? "true" : "false";
  } else if (value.is_integer()) {
    out += std::to_string(value.as_integer());
  } else if (value.is_number()) {
    std::string text = base::to_text(value.as_real());
    if (text.find_first_of(".e") == std::string::npos) text += ".0";
    out += text;
  } else if (value.is_string()) {
    escape(out, value.as_string());
  } else if (value.is_array()) {
    const auto& items = value.as_array();
    const bool one_line = indent == 0 || fits_on_line(items);
    out += '[';
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (i > 0) out += indent > 0 && one_line ? ", " : ",";
      if (!one_line) line(depth + 1);
      write(out, items[i], indent, depth + 1);
    }
    if (!one_line && !items.empty()) line(depth);
    out += ']';
  } else {
    const auto& members = value.as_object();
    out += '{';
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (i > 0) out += ',';
      line(depth + 1);
      escape(out, members[i].first);
      out += indent > 0 ? ": " : ":";
      write(out, members[i].second, indent, depth + 1);
    }
    if (!members.empty()) line(depth);
    out += '}';
  }
}

}  // namespace

Json::Json(double value) {
  if (std::isfinite(value)) value_ = value == 0.0 ? 0.0 : value;
}

Json::Json(const std::vector<std::string>& values) : value_(Array(values.begin(), values.end())) {}
Json::Json(const std::vector<double>& values) : value_(Array(values.begin(), values.end())) {}
Json::Json(const geometry::Vec3& v) : value_(Array{Json(v.x()), Json(v.y()), Json(v.z())}) {}

Json Json::object(std::initializer_list<std::pair<std::string, Json>> members) {
  return Json(Object(members.begin(), members.end()));
}

bool Json::as_bool() const {
  if (const auto* v = std::get_if<bool>(&value_)) return *v;
  wrong_kind(value_.index(), kind_name(1));
}

std::int64_t Json::as_integer() const {
  if (const auto* v = std::get_if<std::int64_t>(&value_)) return *v;
  wrong_kind(value_.index(), kind_name(2));
}

double Json::as_real() const {
  if (const auto* v = std::get_if<double>(&value_)) return *v;
  if (const auto* v = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*v);
  wrong_kind(value_.index(), kind_name(3));
}

const std::string& Json::as_string() const {
  if (const auto* v = std::get_if<std::string>(&value_)) return *v;
  wrong_kind(value_.index(), kind_name(4));
}

const Json::Array& Json::as_array() const {
  if (const auto* v = std::get_if<Array>(&value_)) return *v;
  wrong_kind(value_.index(), kind_name(5));
}

const Json::Object& Json::as_object() const {
  if (const auto* v = std::get_if<Object>(&value_)) return *v;
  wrong_kind(value_.index(), kind_name(6));
}

geometry::Vec3 Json::as_vec3() const {
  const auto& items = as_array();
  if (items.size() != 3)
    throw base::Error(base::ErrorCode::invalid_input, "JSON list of the wrong length")
        .found(std::to_string(items.size()))
        .allowed("3 numbers");
  return {items[0].as_real(), items[1].as_real(), items[2].as_real()};
}

const Json* Json::find(std::string_view key) const {
  const auto* members = std::get_if<Object>(&value_);
  if (members == nullptr) return nullptr;
  for (const auto& [name, value] : *members)
    if (name == key) return &value;
  return nullptr;
}

const Json& Json::at(std::string_view key) const {
  if (!is_object()) wrong_kind(value_.index(), kind_name(6));
  if (const Json* value = find(key)) return *value;
  throw base::Error(base::ErrorCode::invalid_input, "JSON object lacks the member '" + std::string(key) + "'");
}

Json& Json::set(std::string key, Json value) {
  if (is_null()) value_ = Object{};
  auto* members = std::get_if<Object>(&value_);
  if (members == nullptr) wrong_kind(value_.index(), kind_name(6));
  for (auto& [name, old] : *members)
    if (name == key) {
      old = std::move(value);
      return *this;
    }
  members->emplace_back(std::move(key), std::move(value));
  return *this;
}

Json& Json::push(Json value) {
  if (is_null()) value_ = Array{};
  auto* items = std::get_if<Array>(&value_);
  if (items == nullptr) wrong_kind(value_.index(), kind_name(5));
  items->push_back(std::move(value));
  return *this;
}

std::size_t Json::size() const {
  if (const auto* items = std::get_if<Array>(&value_)) return items->size();
  if (const auto* members = std::get_if<Object>(&value_)) return members->size();
  return 0;
}

std::string Json::dump(int indent) const {
  std::string out;
  write(out, *this, indent, 0);
  return out;
}

}  // namespace cairn::io
