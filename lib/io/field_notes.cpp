#include "io/field_notes.hpp"

#include <algorithm>
#include <cctype>

#include "base/number_text.hpp"
#include "io/csv.hpp"
#include "io/edits_csv.hpp"

namespace cairn::io {
namespace {

std::string column_name(std::string_view header) {
  std::string name;
  for (const char c : base::trim(header)) {
    const auto u = static_cast<unsigned char>(c);
    name += std::isalnum(u) != 0 ? static_cast<char>(std::tolower(u)) : '_';
  }
  return name;
}

bool one_of(const std::string& name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

FieldNotes read_field_notes(const std::filesystem::path& path) {
  CsvReader csv(path);
  FieldNotes file;
  std::optional<std::size_t> id, latitude, longitude, observed;
  std::vector<std::pair<std::size_t, std::string>> others;
  std::vector<std::string> seen;
  for (std::size_t c = 0; c < csv.header().size(); ++c) {
    std::string name = column_name(csv.header()[c]);
    const bool is_id = one_of(name, {"id", "rock_id"}), is_lat = one_of(name, {"latitude_deg", "latitude", "lat"}),
               is_lon = one_of(name, {"longitude_deg", "longitude", "lon", "lng"}), is_time = name == "observed_utc";
    const std::string key = is_id ? "id" : is_lat ? "latitude_deg" : is_lon ? "longitude_deg" : name;
    if (std::find(seen.begin(), seen.end(), key) != seen.end())
      throw base::Error(base::ErrorCode::invalid_input, "two columns mean the same")
          .file(path.string())
          .found("'" + csv.header()[c] + "' beside another '" + key + "'");
    seen.push_back(key);
    if (is_id) id = c;
    else if (is_lat) latitude = c;
    else if (is_lon) longitude = c;
    else if (is_time) observed = c;
    else others.emplace_back(c, std::move(name));
  }
  if (!id && !(latitude && longitude))
    throw base::Error(base::ErrorCode::invalid_input, "nothing joins the notes to rocks")
        .file(path.string())
        .allowed("a column id, or latitude_deg and longitude_deg");
  for (const auto& [c, name] : others) file.columns.push_back(name);
  while (csv.next()) {
    FieldNote note;
    note.line = csv.line();
    if (id) note.id = base::trim(csv.text(*id));
    if (latitude) note.latitude_deg = csv.optional_real(*latitude);
    if (longitude) note.longitude_deg = csv.optional_real(*longitude);
    if (note.latitude_deg.has_value() != note.longitude_deg.has_value())
      throw csv.error("the note has half a position").allowed("latitude_deg and longitude_deg, or neither");
    if (note.latitude_deg && !(*note.latitude_deg >= -90.0 && *note.latitude_deg <= 90.0))
      throw csv.error(*latitude, "latitude is off the globe").allowed("-90 to 90");
    if (note.longitude_deg && !(*note.longitude_deg >= -180.0 && *note.longitude_deg <= 180.0))
      throw csv.error(*longitude, "longitude is off the globe").allowed("-180 to 180");
    if (note.id.empty() && !note.latitude_deg)
      throw csv.error("the note names neither a rock nor a position").allowed("id, or latitude_deg and longitude_deg");
    if (observed) {
      const auto text = base::trim(csv.text(*observed));
      if (!text.empty()) {
        note.observed_ns = parse_utc_ns(text);
        if (!note.observed_ns) throw csv.error(*observed, "not a time").allowed("ISO 8601, UTC: 2026-05-01T10:20:30Z");
      }
    }
    for (const auto& [c, name] : others)
      if (const auto text = base::trim(csv.text(c)); !text.empty()) note.values.emplace_back(name, text);
    file.notes.push_back(std::move(note));
  }
  return file;
}

}  // namespace cairn::io
