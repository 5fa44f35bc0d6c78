// Members of a JSON object, read once each, with their path in every message.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/primitives.hpp"
#include "io/json.hpp"

namespace cairn::pipeline {

// Each read notes the member's name; finish() refuses members that nothing asked for. A read without the member
// leaves the value as it is. Errors are invalid_input with the path as record: "flights[0].speed_m_s".
class JsonFields {
 public:
  // `json` must outlive this. Throws where it is not an object.
  JsonFields(const io::Json& json, std::string path);

  void real(std::string_view name, double& value);
  void real(std::string_view name, std::optional<double>& value);
  void integer(std::string_view name, std::int64_t& value);
  void seed(std::string_view name, std::uint64_t& value);  // 0..2^63 - 1
  void flag(std::string_view name, bool& value);
  void text(std::string_view name, std::string& value);
  void texts(std::string_view name, std::vector<std::string>& value);
  // One of `allowed`; returns its index, or nothing where the member is absent.
  [[nodiscard]] std::optional<std::size_t> choice(std::string_view name, const std::vector<std::string_view>& allowed);
  // Exactly `count` numbers.
  [[nodiscard]] std::optional<std::vector<double>> reals(std::string_view name, std::size_t count);
  // Polygon: a list of three or more [east, north], or two = opposite corners of a rectangle.
  void area(std::string_view name, geometry::Ring& value);
  void object(std::string_view name, const std::function<void(JsonFields&)>& read);
  void list(std::string_view name, const std::function<void(JsonFields&)>& read);

  [[nodiscard]] bool has(std::string_view name) const { return json_->find(name) != nullptr; }
  // Throws where the member is absent.
  void require(std::string_view name) const;
  [[nodiscard]] const io::Json* raw(std::string_view name);
  [[nodiscard]] std::string path_of(std::string_view name) const;
  [[noreturn]] void fail(std::string_view name, std::string message, std::string found, std::string allowed) const;
  void finish() const;

 private:
  const io::Json* find(std::string_view name);
  [[nodiscard]] double number(const io::Json& json, std::string_view name) const;

  const io::Json* json_;
  std::string path_;
  std::vector<std::string> known_;
};

}  // namespace cairn::pipeline
