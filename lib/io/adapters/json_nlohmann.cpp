// Parsing by nlohmann's SAX interface: no intermediate tree, our own limits.
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"

namespace cairn::io {
namespace {

constexpr std::size_t kMaxDepth = 64;

class Builder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  Json root;
  std::string problem;
  std::size_t problem_at = 0;

  bool null() override { return add(Json()); }
  bool boolean(bool value) override { return add(Json(value)); }
  bool number_integer(number_integer_t value) override { return add(Json(std::int64_t{value})); }
  bool number_unsigned(number_unsigned_t value) override {
    if (value > static_cast<number_unsigned_t>(INT64_MAX)) return add(Json(static_cast<double>(value)));
    return add(Json(static_cast<std::int64_t>(value)));
  }
  bool number_float(number_float_t value, const string_t& text) override {
    if (!std::isfinite(value)) return fail("number out of range: " + text);
    return add(Json(value));
  }
  bool string(string_t& value) override { return add(Json(std::move(value))); }
  bool binary(binary_t&) override { return fail("binary value"); }

  bool start_object(std::size_t) override { return open(Json(Json::Object{})); }
  bool key(string_t& name) override {
    if (!stack_.back().keys.insert(name).second) return fail("key '" + name + "' appears twice");
    stack_.back().key = std::move(name);
    return true;
  }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(Json(Json::Array{})); }
  bool end_array() override { return close(); }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& e) override {
    constexpr int kNumberOverflow = 406;  // nlohmann's out_of_range.406
    problem = e.id == kNumberOverflow ? "number out of range" : "not valid JSON";
    problem_at = position;
    return false;
  }

 private:
  struct Level {
    Json value;
    std::string key;
    std::set<std::string> keys;
  };
  std::vector<Level> stack_;

  bool fail(std::string why) {
    problem = std::move(why);
    return false;
  }
  bool add(Json value) {
    if (stack_.empty()) root = std::move(value);
    else if (stack_.back().value.is_array()) stack_.back().value.push(std::move(value));
    else stack_.back().value.set(std::move(stack_.back().key), std::move(value));
    return true;
  }
  bool open(Json value) {
    if (stack_.size() >= kMaxDepth) return fail("nested deeper than " + std::to_string(kMaxDepth));
    stack_.push_back({std::move(value), {}, {}});
    return true;
  }
  bool close() {
    Json value = std::move(stack_.back().value);
    stack_.pop_back();
    return add(std::move(value));
  }
};

std::string position_text(std::string_view text, std::size_t offset) {
  std::size_t line = 1, column = 1;
  for (std::size_t i = 0; i + 1 < offset && i < text.size(); ++i) {
    if (text[i] == '\n') {
      ++line;
      column = 1;
    } else {
      ++column;
    }
  }
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

}  // namespace

Json parse_json(std::string_view text, std::string_view name) {
  Builder builder;
  bool ok = false;
  try {
    ok = nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
  } catch (const std::exception& e) {
    builder.problem = e.what();
  }
  if (ok && builder.problem.empty()) return std::move(builder.root);
  base::Error error(base::ErrorCode::invalid_input, builder.problem.empty() ? "not valid JSON" : builder.problem);
  if (builder.problem_at > 0)
    throw std::move(error).file(name).record(position_text(text, builder.problem_at)).hint("Correct the file");
  throw std::move(error).file(name).hint("Correct the file");
}

Json read_json(const std::filesystem::path& path) {
  return parse_json(base::read_file(path, std::uintmax_t{1} << 30), path.string());
}

}  // namespace cairn::io
