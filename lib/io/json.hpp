// JSON values with a fixed order of members, and text that is the same on every machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::io {

// null, bool, integer, real, text, array or object. Members keep the order they were added in.
class Json {
 public:
  using Array = std::vector<Json>;
  using Object = std::vector<std::pair<std::string, Json>>;

  Json() = default;  // null
  Json(std::nullptr_t) {}
  Json(bool value) : value_(value) {}
  Json(int value) : value_(static_cast<std::int64_t>(value)) {}
  Json(std::int64_t value) : value_(value) {}
  Json(std::size_t value) : value_(static_cast<std::int64_t>(value)) {}
  // Non-finite numbers become null: they never reach a file.
  Json(double value);
  Json(const char* value) : value_(std::string(value)) {}
  Json(std::string_view value) : value_(std::string(value)) {}
  Json(std::string value) : value_(std::move(value)) {}
  Json(Array value) : value_(std::move(value)) {}
  Json(Object value) : value_(std::move(value)) {}
  Json(const std::vector<std::string>& values);
  Json(const std::vector<double>& values);
  Json(const geometry::Vec3& v);  // [x, y, z]

  [[nodiscard]] static Json object(std::initializer_list<std::pair<std::string, Json>> members = {});
  [[nodiscard]] static Json array() { return Json(Array{}); }

  [[nodiscard]] bool is_null() const { return value_.index() == 0; }
  [[nodiscard]] bool is_bool() const { return value_.index() == 1; }
  [[nodiscard]] bool is_integer() const { return value_.index() == 2; }
  [[nodiscard]] bool is_number() const { return value_.index() == 2 || value_.index() == 3; }
  [[nodiscard]] bool is_string() const { return value_.index() == 4; }
  [[nodiscard]] bool is_array() const { return value_.index() == 5; }
  [[nodiscard]] bool is_object() const { return value_.index() == 6; }

  // Each throws invalid_input with what was found where the kind is another.
  [[nodiscard]] bool as_bool() const;
  [[nodiscard]] std::int64_t as_integer() const;
  [[nodiscard]] double as_real() const;
  [[nodiscard]] const std::string& as_string() const;
  [[nodiscard]] const Array& as_array() const;
  [[nodiscard]] const Object& as_object() const;
  [[nodiscard]] geometry::Vec3 as_vec3() const;

  // Member by name: nullptr where absent / throws invalid_input naming the key.
  [[nodiscard]] const Json* find(std::string_view key) const;
  [[nodiscard]] const Json& at(std::string_view key) const;
  // Sets or appends a member; makes an object of null.
  Json& set(std::string key, Json value);
  // Appends; makes an array of null.
  Json& push(Json value);
  [[nodiscard]] std::size_t size() const;

  // indent 0 = one line. Reals in shortest round-trip form; text escaped, UTF-8 kept.
  [[nodiscard]] std::string dump(int indent = 2) const;

  friend bool operator==(const Json&, const Json&) = default;

 private:
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Array, Object> value_;
};

// Strict JSON. Refused with line and column: depth above 64, duplicate keys, numbers that are not
// finite, anything after the value. `name` stands for the source in messages.
[[nodiscard]] Json parse_json(std::string_view text, std::string_view name);
// Reads at most 1 GiB.
[[nodiscard]] Json read_json(const std::filesystem::path& path);

}  // namespace cairn::io
