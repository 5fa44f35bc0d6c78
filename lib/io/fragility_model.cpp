#include "io/fragility_model.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "io/json.hpp"

namespace cairn::io {

survey::FragilityModel read_fragility_model(const std::filesystem::path& path) {
  const auto json = read_json(path);
  const auto refuse = [&path](const std::string& record, std::string message) {
    return base::Error(base::ErrorCode::invalid_input, std::move(message)).file(path.string()).record(record);
  };
  try {
    const std::vector<std::string> known = {"name",         "reference", "doi",        "form",           "im",
                                            "coefficients", "valid",     "entered_by", "checked_against"};
    for (const auto& [key, value] : json.as_object())
      if (std::find(known.begin(), known.end(), key) == known.end())
        throw refuse("member " + key, "a fragility model has no such member");
    survey::FragilityModel model;
    model.name = json.at("name").as_string();
    model.reference = json.at("reference").as_string();
    model.doi = json.at("doi").as_string();
    model.form = json.at("form").as_string();
    for (const auto& im : json.at("im").as_array()) model.im.push_back(im.as_string());
    for (const auto& [key, value] : json.at("coefficients").as_object()) model.coefficients[key] = value.as_real();
    for (const auto& [key, value] : json.at("valid").as_object()) {
      const auto& range = value.as_array();
      if (range.size() != 2 || !(range[0].as_real() <= range[1].as_real()))
        throw refuse("valid " + key, "a range of validity needs its least and greatest value");
      model.valid[key] = {range[0].as_real(), range[1].as_real()};
    }
    model.entered_by = json.at("entered_by").as_string();
    model.checked_against = json.at("checked_against").as_string();
    if (!model.coefficients.empty() && (model.entered_by.empty() || model.checked_against.empty()))
      throw refuse("coefficients", "coefficients need entered_by and checked_against")
          .hint("Name who typed them and which published values they reproduce");
    return model;
  } catch (base::Error& error) {
    error.default_file(path.string());
    throw;
  }
}

}  // namespace cairn::io
