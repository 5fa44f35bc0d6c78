#include <algorithm>
#include <cmath>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "report/inventory_rows.hpp"
#include "report/layer_looks.hpp"

namespace cairn::report {
namespace {

using geometry::Vec3;
using io::Column;
using io::ColumnType;
using io::Value;
using Rows = std::vector<std::unique_ptr<InventoryRow>>;

Value number(double value) {
  if (!std::isfinite(value)) return {};
  return value + 0.0;
}

io::Layer table(const char* name, const char* title, std::vector<Column> columns) {
  io::Layer layer;
  layer.name = name;
  layer.title = title;
  layer.kind = io::GeometryKind::none;
  layer.with_heights = false;
  layer.columns = std::move(columns);
  return layer;
}

void add_row(io::Layer& layer, std::vector<Value> values) {
  if (values.size() != layer.columns.size())
    throw base::Error(base::ErrorCode::internal, "a row of table '" + layer.name + "' has another number of cells");
  io::Feature feature;
  feature.values = std::move(values);
  layer.features.push_back(std::move(feature));
}

const Column kId{"id", ColumnType::text, "", "the rock, as in table inventory"};

Column real(const char* name, const char* unit, const char* definition) {
  return {name, ColumnType::real, unit, definition};
}

io::Layer contacts(const Inventory& inventory, const Rows& rows,
                   const std::vector<std::optional<geodesy::LocalFrame>>& frames) {
  io::Layer layer = table("contacts", "Support polygons of the rocks", {kId});
  layer.kind = io::GeometryKind::polygon;
  layer.columns.push_back({"grade", ColumnType::text, "", "as in table inventory"});
  layer.columns.push_back({"contact_assumed", ColumnType::boolean, "", "as in table inventory"});
  for (const auto& row : rows) {
    const auto& contact = row->rock.tipping.contact;
    const auto& frame = frames.at(row->entry.survey);
    if (row->rock.rejected || contact.size() < 3 || !frame) continue;
    io::Feature feature;
    feature.parts = {{io::to_geodetic(*frame, std::span<const Vec3>(contact))}};
    feature.values = {row->entry.id, std::string(survey::name_of(row->rock.tipping.grade)),
                      row->rock.tipping.contact_assumed};
    layer.features.push_back(std::move(feature));
  }
  io::LayerStyle style;
  style.name = "contacts";
  style.other = {0, 114, 178, 90};
  layer.style = style;
  layer.title += ". " + protection_text(inventory.protection);
  return layer;
}

io::Layer tipping_edges(const Rows& rows) {
  io::Layer layer = table(
      "tipping_edges", "Every edge about which a rock can tip",
      {kId,
       {"edge", ColumnType::integer, "", "number of the edge, round the support polygon"},
       {"critical", ColumnType::boolean, "", "true: the edge of alpha_min_deg"},
       real("topple_toward_deg", "deg", "the edge's outward normal, clockwise from true north"),
       real("alpha_deg", "deg", "rotation that brings the centre of mass above the edge"),
       real("inclination_deg", "deg", "of the edge to the horizontal"),
       real("r_m", "m", "centre of mass to edge"),
       real("p_rad_s", "rad/s", "sqrt(m g R cos(inclination) / I_edge)"),
       real("inertia_kg_m2", "kg m2", "about the edge"),
       real("a_qs_g", "g", "quasi-static acceleration along the normal; empty where no push topples over the edge"),
       real("v_min_m_s", "m/s", "least velocity step"),
       real("barrier_j", "J", "energy barrier"),
       real("critical_share", "", "share of the draws in which it is the critical edge, 0 to 1"),
       real("from_east_m", "m", "one end, from the centre of mass"),
       real("from_north_m", "m", "one end, from the centre of mass"),
       real("from_up_m", "m", "one end, from the centre of mass"),
       real("to_east_m", "m", "other end, from the centre of mass"),
       real("to_north_m", "m", "other end, from the centre of mass"),
       real("to_up_m", "m", "other end, from the centre of mass")});
  for (const auto& row : rows) {
    if (!row->measured || !row->rock.mass) continue;
    const double mass = row->rock.mass->volume * row->density_kg_m3;
    const auto& critical = *row->rock.tipping.critical;
    std::int64_t n = 0;
    for (const auto& e : row->rock.tipping.edges) {
      const Vec3 a = e.ends[0] - row->rock.mass->centre_of_mass, b = e.ends[1] - row->rock.mass->centre_of_mass;
      add_row(layer, {row->entry.id, n++, e.azimuth_deg == critical.azimuth_deg && e.alpha_rad == critical.alpha_rad,
                      number(e.azimuth_deg), number(base::rad_to_deg(e.alpha_rad)),
                      number(base::rad_to_deg(e.inclination_rad)), number(e.r_m), number(e.p_rad_s),
                      number(e.inertia_m2 * mass), number(e.a_qs_g), number(e.v_min_m_s), number(e.barrier_j_kg * mass),
                      row->rock.tipping.uncertainty ? number(e.critical_share) : Value(), number(a.x()), number(a.y()),
                      number(a.z()), number(b.x()), number(b.y()), number(b.z())});
    }
  }
  return layer;
}

io::Layer tipping_by_azimuth(const Rows& rows) {
  io::Layer layer =
      table("tipping_by_azimuth", "Tipping in every direction",
            {kId, real("topple_toward_deg", "deg", "direction of toppling, clockwise from true north"),
             real("a_qs_g", "g", "least quasi-static acceleration that topples that way"),
             real("alpha_deg", "deg", "atan of a_qs_g"), real("a_qs_inner_g", "g", "on the least contact: lower bound"),
             real("a_qs_outer_g", "g", "on the visible crease: upper bound"), real("a_qs_g_p05", "g", "5 % quantile"),
             real("a_qs_g_p16", "g", "16 % quantile"), real("a_qs_g_p50", "g", "median"),
             real("a_qs_g_p84", "g", "84 % quantile"), real("a_qs_g_p95", "g", "95 % quantile")});
  for (const auto& row : rows) {
    const auto& t = row->rock.tipping;
    if (!row->measured || t.a_qs_g_by_azimuth.empty()) continue;
    for (std::size_t i = 0; i < t.a_qs_g_by_azimuth.size(); ++i) {
      const auto at = [i](const std::vector<double>& list) { return i < list.size() ? number(list[i]) : Value(); };
      std::vector<Value> values{row->entry.id,
                                static_cast<double>(i),
                                at(t.a_qs_g_by_azimuth),
                                number(base::rad_to_deg(std::atan(t.a_qs_g_by_azimuth[i]))),
                                t.inner ? at(t.inner->a_qs_g_by_azimuth) : Value(),
                                t.outer ? at(t.outer->a_qs_g_by_azimuth) : Value()};
      for (std::size_t q = 0; q < 5; ++q)
        values.push_back(t.uncertainty ? at(t.uncertainty->a_qs_g_by_azimuth[q]) : Value());
      add_row(layer, std::move(values));
    }
  }
  return layer;
}

// Quantities that say where the rock is.
bool tells_place(std::string_view quantity) {
  return quantity.rfind("com_", 0) == 0 || quantity.find("height_m") != std::string_view::npos;
}

bool scales_with_density(std::string_view quantity) {
  const auto ends = [&](std::string_view unit) {
    return quantity.size() >= unit.size() && quantity.substr(quantity.size() - unit.size()) == unit;
  };
  return quantity == "mass_kg" || quantity == "density_kg_m3" || ends("_kg_m2") || ends("_j");
}

io::Layer uncertainty(const Inventory& inventory, const Rows& rows) {
  io::Layer layer =
      table("uncertainty", "Quantiles over the Monte Carlo draws, and what makes the variance of alpha",
            {kId,
             {"kind", ColumnType::text, "",
              "quantiles, variance_share (of alpha on the rim), variance_share_bearing, or input (what was drawn)"},
             {"quantity", ColumnType::text, "", "name with its unit"},
             real("value", "", "of a variance_share (0 to 1) or an input"),
             real("p05", "", "5 % quantile"),
             real("p16", "", "16 % quantile"),
             real("p50", "", "median"),
             real("p84", "", "84 % quantile"),
             real("p95", "", "95 % quantile")});
  for (const auto& row : rows) {
    if (!row->measured || !row->rock.tipping.uncertainty) continue;
    const auto& u = *row->rock.tipping.uncertainty;
    for (const auto& s : u.scalars)
      if (!inventory.protection.on || !tells_place(s.name)) {
        const double k = scales_with_density(s.name) ? row->density_ratio() : 1.0;
        add_row(layer,
                {row->entry.id, std::string("quantiles"), s.name, Value(), number(k * s.value.p05),
                 number(k * s.value.p16), number(k * s.value.p50), number(k * s.value.p84), number(k * s.value.p95)});
      }
    const auto add = [&](const char* kind, const std::vector<survey::NamedValue>& list) {
      for (const auto& v : list)
        add_row(layer, {row->entry.id, std::string(kind), v.name, number(v.value), Value(), Value(), Value(), Value(),
                        Value()});
    };
    add("variance_share", u.variance_shares);
    add("variance_share_bearing", u.variance_shares_bearing);
    add("input", u.inputs);
  }
  return layer;
}

io::Layer photos(const Rows& rows, const std::vector<std::optional<geodesy::LocalFrame>>& frames) {
  io::Layer layer = table("photos", "Photographs that show a rock best, at the camera",
                          {kId,
                           {"file", ColumnType::text, "", "name of the photograph"},
                           {"sha256", ColumnType::text, "", "of the file; empty where it was not there"},
                           {"time", ColumnType::text, "", "of the photograph, ISO 8601 on time_base"},
                           {"time_base", ColumnType::text, "", "utc, gps, boot or unknown"},
                           {"camera", ColumnType::integer, "", "id of the camera"},
                           real("latitude_deg", "deg", "WGS84 latitude of the camera"),
                           real("longitude_deg", "deg", "WGS84 longitude of the camera"),
                           real("height_m", "m", "height of the camera, in the survey's datum"),
                           real("heading_deg", "deg", "optical axis, clockwise from true north; empty when vertical"),
                           real("pitch_deg", "deg", "optical axis above the horizon: -90 looks straight down"),
                           real("score", "", "of the rock's box in it, 0 to 1")});
  layer.kind = io::GeometryKind::point;
  for (const auto& row : rows) {
    const auto& frame = frames.at(row->entry.survey);
    for (const auto& photo : row->entry.photos) {
      const Vec3 axis = photo.T_world_camera.rotation.col(2);
      constexpr double kLeastHorizontal = 0.02;
      const double flat = axis.head<2>().norm();
      const bool timed = photo.time_ns != 0;
      Value latitude, longitude, height;
      io::Feature feature;
      if (frame) {
        const auto g = frame->to_geodetic(photo.T_world_camera.translation);
        latitude = g.latitude_deg;
        longitude = g.longitude_deg;
        height = g.height_m;
        feature.parts = {{{g}}};
      }
      const auto text = [](std::string t) { return t.empty() ? Value() : Value(std::move(t)); };
      feature.values = {row->entry.id,
                        photo.file,
                        text(photo.sha256),
                        timed ? Value(base::iso8601(photo.time_ns)) : Value(),
                        std::string(base::name_of(photo.time_base)),
                        photo.camera,
                        latitude,
                        longitude,
                        height,
                        flat > kLeastHorizontal ? number(base::azimuth_deg(axis.x(), axis.y())) : Value(),
                        number(base::rad_to_deg(std::atan2(axis.z(), flat))),
                        number(photo.score)};
      layer.features.push_back(std::move(feature));
    }
  }
  io::LayerStyle style;
  style.name = "photos";
  style.other = {0, 114, 178, 255};
  style.marker = "triangle";
  style.marker_mm = 2.5;
  layer.style = style;
  return layer;
}

io::Layer rejects(const Rows& rows) {
  io::Layer layer = table("rejects", "Rocks left out or graded down, by reason",
                          {{"kind", ColumnType::text, "", "rejected (not in the numbers), or grade (graded down)"},
                           {"reason", ColumnType::text, "", "reason code"},
                           {"rocks", ColumnType::integer, "", "rocks with this reason; one may have several"}});
  std::map<std::pair<std::string, std::string>, std::int64_t> counts;
  for (const auto& row : rows) {
    if (row->rock.rejected)
      for (const auto& reason : row->rock.reasons) ++counts[{"rejected", reason}];
    else
      for (const auto& reason : row->rock.tipping.reasons) ++counts[{"grade", reason}];
  }
  for (const auto& [key, count] : counts) add_row(layer, {key.first, key.second, count});
  return layer;
}

io::Layer surveys(const Inventory& inventory) {
  io::Layer layer = table("surveys", "What the inventory was made from",
                          {{"survey", ColumnType::text, "", "name of the survey"},
                           {"id_prefix", ColumnType::text, "", "first part of its rocks' ids"},
                           {"result", ColumnType::text, "", "folder of the result; withheld in a protected inventory"},
                           {"made_by", ColumnType::text, "", "program and version"},
                           {"seed", ColumnType::integer, "", "of the random draws"},
                           real("origin_latitude_deg", "deg", "origin of the local frame"),
                           real("origin_longitude_deg", "deg", "origin of the local frame"),
                           real("origin_height_m", "m", "origin of the local frame"),
                           {"height_type", ColumnType::text, "", "what heights are measured from"},
                           {"rocks", ColumnType::integer, "", "rocks, rejected ones included"},
                           {"protection", ColumnType::text, "", "what was done to the coordinates"}});
  for (std::size_t s = 0; s < inventory.surveys.size(); ++s) {
    const auto& one = inventory.surveys[s];
    const bool hide = inventory.protection.on;
    const auto count =
        std::count_if(inventory.rocks.begin(), inventory.rocks.end(), [s](const auto& r) { return r.survey == s; });
    const auto text = [](std::string t) { return t.empty() ? Value() : Value(std::move(t)); };
    const auto origin = [&](double geometry::Geodetic::*member) {
      return one.origin && !hide ? number(one.origin->position.*member) : Value();
    };
    add_row(layer, {protected_text(one.name, inventory.protection), one.slug, hide ? Value() : text(one.result),
                    text(one.version.empty() ? "" : "cairn " + one.version), one.seed ? Value(*one.seed) : Value(),
                    origin(&geometry::Geodetic::latitude_deg), origin(&geometry::Geodetic::longitude_deg),
                    origin(&geometry::Geodetic::height_m),
                    one.origin ? text(io::height_type_text(one.origin->height_type, one.origin->geoid)) : Value(),
                    static_cast<std::int64_t>(count), protection_text(inventory.protection)});
  }
  return layer;
}

io::Json json_of(const Value& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b;
  if (const auto* i = std::get_if<std::int64_t>(&value)) return *i;
  if (const auto* d = std::get_if<double>(&value)) return *d;
  if (const auto* s = std::get_if<std::string>(&value)) return *s;
  return {};
}

}  // namespace

std::vector<io::Layer> inventory_tables(const Inventory& inventory, const Rows& rows,
                                        const std::vector<std::optional<geodesy::LocalFrame>>& frames) {
  std::vector<io::Layer> layers;
  // A rounded polygon would be a point, an exact one the place.
  if (!inventory.protection.on) layers.push_back(contacts(inventory, rows, frames));
  layers.push_back(tipping_edges(rows));
  layers.push_back(tipping_by_azimuth(rows));
  layers.push_back(uncertainty(inventory, rows));
  if (!inventory.protection.on) layers.push_back(photos(rows, frames));
  layers.push_back(rejects(rows));
  layers.push_back(surveys(inventory));
  return layers;
}

io::Json rock_json(const std::vector<io::Layer>& layers, std::size_t row) {
  const io::Layer& main = layers.at(0);
  const auto& values = main.features.at(row).values;
  io::Json json = io::Json::object({{"schema_version", 1}});
  for (std::size_t c = 0; c < main.columns.size(); ++c) json.set(main.columns[c].name, json_of(values[c]));
  const Value& id = values.at(0);
  for (const auto& layer : layers) {
    if (layer.name != "tipping_edges" && layer.name != "tipping_by_azimuth" && layer.name != "uncertainty") continue;
    io::Json list = io::Json::array();
    for (const auto& feature : layer.features) {
      if (feature.values.at(0) != id) continue;
      io::Json item = io::Json::object();
      for (std::size_t c = 1; c < layer.columns.size(); ++c)
        if (feature.values[c].index() != 0) item.set(layer.columns[c].name, json_of(feature.values[c]));
      list.push(std::move(item));
    }
    json.set(layer.name, std::move(list));
  }
  return json;
}

}  // namespace cairn::report
