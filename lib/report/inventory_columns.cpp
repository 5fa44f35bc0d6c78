#include <algorithm>
#include <cmath>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "report/inventory_rows.hpp"

namespace cairn::report {
namespace {

using io::ColumnType;
using io::Value;
using Row = InventoryRow;
using geometry::Vec3;

Value real(std::optional<double> value) {
  if (!value || !std::isfinite(*value)) return {};
  return *value + 0.0;  // no negative zero
}
Value positive(double value) {
  return value > 0.0 && std::isfinite(value) ? Value(value) : Value();
}
Value words(std::string text) {
  if (text.empty()) return {};
  return text;
}

double worst_sigma(const geometry::Mat3& c) {
  const double mean = 0.5 * (c(0, 0) + c(1, 1));
  return std::sqrt(std::max(0.0, mean + std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1))));
}

class Columns {
 public:
  void add(ColumnType type, std::string name, std::string unit, std::string definition,
           std::function<Value(const Row&)> value) {
    list_.push_back({{std::move(name), type, std::move(unit), std::move(definition)}, std::move(value)});
  }
  void text(const char* name, const char* definition, std::function<std::string(const Row&)> get) {
    add(ColumnType::text, name, "", definition, [get](const Row& r) { return words(get(r)); });
  }
  void number(const char* name, const char* unit, const char* definition, std::function<Value(const Row&)> get) {
    add(ColumnType::real, name, unit, definition, std::move(get));
  }
  void count(const char* name, const char* definition, std::function<Value(const Row&)> get) {
    add(ColumnType::integer, name, "", definition, std::move(get));
  }
  void flag(const char* name, const char* definition, std::function<Value(const Row&)> get) {
    add(ColumnType::boolean, name, "", definition, std::move(get));
  }
  // A field that people write.
  void field(const char* name) {
    for (const auto& f : inventory_fields()) {
      if (f.name != name) continue;
      add(f.type, f.name, f.unit, f.definition, [f](const Row& r) -> Value {
        if (f.type == ColumnType::text) return words(r.text_of(f.name));
        const auto it = r.field.find(f.name);
        return it == r.field.end() ? Value() : real(base::parse_real(it->second));
      });
    }
  }
  std::vector<InventoryColumn> take() { return std::move(list_); }

 private:
  std::vector<InventoryColumn> list_;
};

// Figures that a grade of not_measurable forbids.
std::function<Value(const Row&)> of_edge(std::function<double(const Row&, const survey::TippingEdge&)> get) {
  return [get](const Row& r) -> Value {
    if (!r.measured) return {};
    return real(get(r, *r.rock.tipping.critical));
  };
}
std::function<Value(const Row&)> if_measured(std::function<Value(const Row&)> get) {
  return [get](const Row& r) -> Value { return r.measured ? get(r) : Value(); };
}
std::function<Value(const Row&)> if_cut(std::function<Value(const Row&)> get) {
  return [get](const Row& r) -> Value { return r.rock.rejected ? Value() : get(r); };
}

std::string status_of(const Row& r) {
  if (r.rock.rejected) return "rejected";
  return r.rock.review == "accept" ? "accepted" : "candidate";
}

void identity(Columns& c) {
  c.text("id", "unique in the inventory and persistent: survey and the rock's number there",
         [](const Row& r) { return r.entry.id; });
  c.text("name", "the rock's name in the field, else class and number", [](const Row& r) {
    const std::string own = r.text_of("name");
    if (!own.empty()) return own;
    if (!r.rock.name.empty()) return protected_text(r.rock.name, r.inventory.protection);
    return (r.rock.object_class.empty() ? std::string("rock") : r.rock.object_class) + " " +
           std::to_string(r.rock.target.value);
  });
  c.text("status", "candidate, accepted (in review) or rejected (reasons tell why)", status_of);
  c.text("judgement", "given in review: precarious, semi_precarious, not_precarious",
         [](const Row& r) { return r.entry.judgement; });
  c.field("field_status");
  c.text("class", "what the detector or the reviewer called it", [](const Row& r) { return r.rock.object_class; });
  for (const char* name : {"site", "region", "access_note", "discoverer", "observers"}) c.field(name);
  c.text("observed_utc", "time of the latest field note", [](const Row& r) { return r.text_of("observed_utc"); });
  c.count("field_notes", "field notes joined to this rock",
          [](const Row& r) { return Value(static_cast<std::int64_t>(r.entry.notes)); });
  c.text("note_match", "how the field note was joined: id or position",
         [](const Row& r) { return r.entry.note_match; });
  c.number("note_distance_m", "m", "from the note's position to the rock, in plan",
           [](const Row& r) { return real(r.entry.note_distance_m); });
  c.text("survey", "survey the rock was found in",
         [](const Row& r) { return protected_text(r.survey.name, r.inventory.protection); });
  c.count("rock_number", "the rock's id within that survey", [](const Row& r) { return Value(r.rock.target.value); });
  c.text("aliases", "ids it also answers to, after a merge, a re-run or another survey",
         [](const Row& r) { return joined_text(r.entry.aliases); });
  c.text("supersedes", "records it replaces", [](const Row& r) { return joined_text(r.entry.supersedes); });
  c.text("revisit_of", "the same rock in a survey given before this one",
         [](const Row& r) { return r.entry.revisit_of; });
  c.text("review", "last decision in review", [](const Row& r) { return r.rock.review; });
  c.text("reviewer", "who decided", [](const Row& r) { return r.entry.reviewer; });
  c.text("reviewed_utc", "when", [](const Row& r) { return r.entry.reviewed_utc; });
  c.text("review_reason", "why",
         [](const Row& r) { return protected_text(r.entry.review_reason, r.inventory.protection); });
  c.text("review_notes", "remarks of the review",
         [](const Row& r) { return protected_text(r.entry.review_notes, r.inventory.protection); });
  c.text("reasons", "reason codes of a rejection, separated by semicolons",
         [](const Row& r) { return joined_text(r.rock.reasons); });
}

void position(Columns& c) {
  c.number("latitude_deg", "deg", "WGS84 latitude of the centre of mass",
           [](const Row& r) -> Value { return r.position ? real(r.position->latitude_deg) : Value(); });
  c.number("longitude_deg", "deg", "WGS84 longitude of the centre of mass",
           [](const Row& r) -> Value { return r.position ? real(r.position->longitude_deg) : Value(); });
  c.number("height_m", "m", "height of the centre of mass, of the type that height_type names",
           [](const Row& r) -> Value { return r.position ? real(r.position->height_m) : Value(); });
  c.text("height_type", "what height_m is measured from", [](const Row& r) -> std::string {
    return r.survey.origin ? io::height_type_text(r.survey.origin->height_type, r.survey.origin->geoid) : "";
  });
  const auto height = [](const Row& r, bool ellipsoidal) -> Value {
    if (!r.position || !r.survey.origin) return {};
    using survey::HeightType;
    const auto type = r.survey.origin->height_type;
    const double step = r.inventory.protection.on ? r.inventory.protection.height_step_m : 0.0;
    if (type == (ellipsoidal ? HeightType::ellipsoidal : HeightType::orthometric)) return real(r.position->height_m);
    const bool known =
        type == HeightType::ellipsoidal || (type == HeightType::orthometric && r.survey.origin->geoid == "egm96");
    if (!known || !r.entry.undulation_m) return {};
    return real(rounded_to(r.position->height_m + (ellipsoidal ? 1.0 : -1.0) * *r.entry.undulation_m, step));
  };
  c.number("ellipsoidal_height_m", "m", "height above the WGS84 ellipsoid",
           [height](const Row& r) { return height(r, true); });
  c.number("orthometric_height_m", "m", "height above the geoid that `geoid` names",
           [height](const Row& r) { return height(r, false); });
  c.text("geoid", "geoid of orthometric_height_m", [height](const Row& r) -> std::string {
    if (height(r, false).index() == 0) return "";
    return r.survey.origin->geoid.empty() ? "egm96" : r.survey.origin->geoid;
  });
  c.text("horizontal_crs", "of latitude and longitude",
         [](const Row& r) -> std::string { return r.position ? "EPSG:4326" : ""; });
  c.number("sigma_horizontal_m", "m", "1 sigma of the located target along the worst horizontal direction",
           [](const Row& r) { return r.entry.target ? positive(worst_sigma(r.entry.target->covariance)) : Value(); });
  c.number("sigma_vertical_m", "m", "1 sigma of the located target's height", [](const Row& r) {
    return r.entry.target ? positive(std::sqrt(std::max(0.0, r.entry.target->covariance(2, 2)))) : Value();
  });
  c.flag("coordinates_protected", "true: positions are rounded, so that the place cannot be found with them",
         [](const Row& r) { return Value(r.inventory.protection.on); });
  c.number("coordinates_step_deg", "deg", "latitude and longitude are multiples of this; empty = not rounded",
           [](const Row& r) -> Value {
             return r.inventory.protection.on ? Value(r.inventory.protection.step_deg) : Value();
           });
  const auto local = [](Eigen::Index axis) {
    return [axis](const Row& r) -> Value { return r.place ? real((*r.place)[axis]) : Value(); };
  };
  c.number("east_m", "m", "centre of mass in the survey's local frame: east of its origin", local(0));
  c.number("north_m", "m", "north of the survey's origin", local(1));
  c.number("up_m", "m", "up from the survey's origin", local(2));
  c.number("base_height_m", "m", "height of the ground at the rock, of the type that height_type names",
           [](const Row& r) { return real(r.base_height_m); });
}

void geology(Columns& c) {
  for (const char* name : {"lithology", "rock_unit", "weathering", "joints"}) c.field(name);
  c.number("density_kg_m3", "kg/m3", "density used", if_cut([](const Row& r) { return positive(r.density_kg_m3); }));
  c.number("density_sigma_kg_m3", "kg/m3", "1 sigma of the density", [](const Row& r) -> Value {
    const auto it = r.field.find("density_sigma_kg_m3");
    if (it != r.field.end()) return real(base::parse_real(it->second));
    if (r.rock.tipping.uncertainty)
      for (const auto& input : r.rock.tipping.uncertainty->inputs)
        if (input.name == "density_sigma") return real(input.value * r.density_kg_m3);  // a share
    return {};
  });
  c.text("density_source", "assumed (a usual value), given (to the analysis), or field (noted at the rock)",
         [](const Row& r) { return r.density_source; });
  for (const char* name : {"age_best_ka", "age_min_ka", "age_max_ka", "age_method", "age_samples", "exhumation_model"})
    c.field(name);
}

Value mass_axis(const Row& r, int row, int column) {
  if (!r.rock.mass) return {};
  return real(r.density_kg_m3 * r.rock.mass->inertia_per_density(row, column));
}

std::string support_wkt(const Row& r) {
  const auto& contact = r.rock.tipping.contact;
  if (!r.rock.mass || contact.size() < 3 || r.rock.rejected) return "";
  std::string text = "POLYGON Z ((";
  for (std::size_t i = 0; i <= contact.size(); ++i) {
    const Vec3 p = contact[i % contact.size()] - r.rock.mass->centre_of_mass;
    text += (i == 0 ? "" : ", ") + base::to_fixed(p.x(), 4) + " " + base::to_fixed(p.y(), 4) + " " +
            base::to_fixed(p.z(), 4);
  }
  return text + "))";
}

void geometry_columns(Columns& c) {
  c.number("length_m", "m", "longer side of the least-area rectangle seen from above",
           if_cut([](const Row& r) { return positive(r.rock.size_m.x()); }));
  c.number("width_m", "m", "shorter side of that rectangle",
           if_cut([](const Row& r) { return positive(r.rock.size_m.y()); }));
  c.number("rock_height_m", "m", "highest point above the base",
           if_cut([](const Row& r) { return positive(r.rock.size_m.z()); }));
  c.number("length_azimuth_deg", "deg", "direction of the longer side, clockwise from true north, 0 to 180",
           if_cut([](const Row& r) { return r.rock.size_m.y() > 0.0 ? real(r.rock.length_azimuth_deg) : Value(); }));
  c.number("hwr", "", "height to width ratio: rock_height_m / width_m", if_cut([](const Row& r) {
             return r.rock.size_m.y() > 0.0 ? real(r.rock.size_m.z() / r.rock.size_m.y()) : Value();
           }));
  c.text("hwr_by_definition", "height to width ratios over the volume, name=value by definition", [](const Row& r) {
    std::vector<std::string> items;
    if (!r.rock.rejected)
      for (const auto& ratio : r.rock.shape_ratios) items.push_back(ratio.name + "=" + base::to_text(ratio.value));
    return joined_text(items);
  });
  c.number("volume_m3", "m3", "volume of the closed mesh",
           if_cut([](const Row& r) { return r.rock.mass ? positive(r.rock.mass->volume) : Value(); }));
  c.number("hull_volume_m3", "m3", "volume of the convex hull: an upper bound",
           if_cut([](const Row& r) { return positive(r.rock.hull_volume_m3); }));
  c.number("mass_kg", "kg", "volume times density", if_cut([](const Row& r) {
             return r.rock.mass ? positive(r.rock.mass->volume * r.density_kg_m3) : Value();
           }));
  c.number("com_above_base_m", "m", "centre of mass above the ground at the rock", if_cut([](const Row& r) {
             return r.rock.mass ? real(r.rock.mass->centre_of_mass.z() - r.rock.base_height_m) : Value();
           }));
  constexpr std::array<std::pair<const char*, std::pair<int, int>>, 6> kInertia{{{"inertia_ee_kg_m2", {0, 0}},
                                                                                 {"inertia_nn_kg_m2", {1, 1}},
                                                                                 {"inertia_uu_kg_m2", {2, 2}},
                                                                                 {"inertia_en_kg_m2", {0, 1}},
                                                                                 {"inertia_eu_kg_m2", {0, 2}},
                                                                                 {"inertia_nu_kg_m2", {1, 2}}}};
  for (const auto& [name, at] : kInertia)
    c.number(name, "kg m2",
             "inertia about the centre of mass in axes east, north, up; off the diagonal the sign of -integral x y dm",
             if_cut([place = at](const Row& r) { return mass_axis(r, place.first, place.second); }));
  c.text("cap", "how the unseen base was closed: none, plane, patch or wrap",
         [](const Row& r) { return r.rock.rejected ? std::string() : std::string(survey::name_of(r.rock.cap)); });
  c.number("cap_height_sigma_m", "m", "1 sigma of that closure's height",
           if_cut([](const Row& r) { return positive(r.rock.cap_height_sigma_m); }));
  c.number("unseen_area_fraction", "", "share of the closed surface that no point supports, 0 to 1",
           if_cut([](const Row& r) { return real(r.rock.unseen_area_fraction); }));
  c.count("points", "points of the cloud on the rock",
          [](const Row& r) { return Value(static_cast<std::int64_t>(r.rock.point_count)); });
  c.number("point_spacing_m", "m", "median distance of a point to its nearest neighbour",
           [](const Row& r) { return positive(r.rock.point_spacing_m); });
  c.number("noise_m", "m", "1 sigma of the points about the mesh",
           [](const Row& r) { return positive(r.rock.noise_m); });
  c.text("support_polygon_from_com_wkt_z", "support polygon as WKT, metres east, north, up from the centre of mass",
         support_wkt);
  c.count("contact_pads", "separate patches of the contact", if_cut([](const Row& r) -> Value {
            return r.rock.tipping.contact_pads > 0 ? Value(r.rock.tipping.contact_pads) : Value();
          }));
  c.number("contact_observed_share", "", "share of the contact's perimeter that was seen, 0 to 1",
           if_cut([](const Row& r) -> Value {
             return r.rock.tipping.contact.empty() ? Value() : real(r.rock.tipping.contact_observed_share);
           }));
  c.flag("contact_assumed", "true: the support was taken as a band at the base; false: observed or digitised",
         if_cut([](const Row& r) { return Value(r.rock.tipping.contact_assumed); }));
  c.number("pedestal_slope_deg", "deg", "slope of the plane through the contact",
           if_measured([](const Row& r) { return real(base::rad_to_deg(r.rock.tipping.contact_slope_rad)); }));
  c.number("pedestal_aspect_deg", "deg", "that plane falls this way, clockwise from true north",
           if_measured([](const Row& r) { return real(r.rock.tipping.contact_aspect_deg); }));
  c.field("lateral_support");
}

// name_p05 .. of the draws' quantiles.
void quantiles(Columns& c, const std::string& name, const std::string& unit, const std::string& what, bool all,
               bool of_mass = false) {
  const std::array<std::pair<const char*, double survey::Quantiles::*>, 5> parts{{{"p05", &survey::Quantiles::p05},
                                                                                  {"p16", &survey::Quantiles::p16},
                                                                                  {"p50", &survey::Quantiles::p50},
                                                                                  {"p84", &survey::Quantiles::p84},
                                                                                  {"p95", &survey::Quantiles::p95}}};
  for (const auto& [part, member] : parts) {
    if (!all && (std::string_view(part) == "p16" || std::string_view(part) == "p84")) continue;
    c.add(ColumnType::real, name + "_" + part, unit,
          what + ": " + std::string(part).substr(1) + " % quantile over the Monte Carlo draws",
          [name, m = member, of_mass](const Row& r) -> Value {
            if (!r.measured || !r.rock.tipping.uncertainty) return {};
            const auto* q = r.rock.tipping.uncertainty->find(name);
            return q == nullptr ? Value() : real((q->*m) * (of_mass ? r.density_ratio() : 1.0));
          });
  }
}

Value bound_deg(const std::optional<survey::TippingBound>& bound) {
  if (!bound || !bound->critical) return {};
  return real(base::rad_to_deg(bound->critical->alpha_rad));
}

void tipping(Columns& c) {
  c.text("grade", "measured, bounded, screening or not_measurable: how far alpha and what follows can be trusted",
         [](const Row& r) {
           return r.rock.rejected ? std::string() : std::string(survey::name_of(r.rock.tipping.grade));
         });
  c.text("grade_reasons", "reason codes for the grade, separated by semicolons",
         [](const Row& r) { return r.rock.rejected ? std::string() : joined_text(r.rock.tipping.reasons); });
  c.text("alpha_definition", "edge: rotation about an edge of the hull of the contact, from the true vertical",
         [](const Row& r) { return std::string(r.measured ? "edge" : ""); });
  c.number("alpha_min_deg", "deg", "least tipping angle on the contact's rim; empty when not_measurable",
           of_edge([](const Row&, const auto& e) { return base::rad_to_deg(e.alpha_rad); }));
  quantiles(c, "alpha_min_deg", "deg", "least tipping angle", true);
  c.number("alpha_inner_deg", "deg", "least tipping angle on the least contact the evidence allows: lower bound",
           if_measured([](const Row& r) { return bound_deg(r.rock.tipping.inner); }));
  c.number("alpha_outer_deg", "deg", "least tipping angle on the visible crease, its gaps closed: upper bound",
           if_measured([](const Row& r) { return bound_deg(r.rock.tipping.outer); }));
  quantiles(c, "alpha_bearing_deg", "deg", "least tipping angle on the contact that bears, inside the visible crease",
            false);
  c.number("topple_toward_deg", "deg", "direction of the least tipping angle, clockwise from true north",
           of_edge([](const Row&, const auto& e) { return e.azimuth_deg; }));
  c.number("r_m", "m", "distance from the centre of mass to that edge",
           of_edge([](const Row&, const auto& e) { return e.r_m; }));
  quantiles(c, "r_m", "m", "distance to that edge", false);
  c.number("p_rad_s", "rad/s", "frequency parameter about that edge",
           of_edge([](const Row&, const auto& e) { return e.p_rad_s; }));
  quantiles(c, "p_rad_s", "rad/s", "frequency parameter", false);
  c.number("inertia_edge_kg_m2", "kg m2", "inertia about that edge", if_measured([](const Row& r) -> Value {
             if (!r.rock.mass) return {};
             return positive(r.rock.tipping.critical->inertia_m2 * r.rock.mass->volume * r.density_kg_m3);
           }));
  c.number("a_qs_g", "g", "quasi-static tipping acceleration along that direction (screening only)",
           of_edge([](const Row&, const auto& e) { return e.a_qs_g; }));
  quantiles(c, "a_qs_g", "g", "quasi-static tipping acceleration", false);
  c.number("v_min_m_s", "m/s", "least velocity step that topples over that edge",
           of_edge([](const Row&, const auto& e) { return e.v_min_m_s; }));
  quantiles(c, "v_min_m_s", "m/s", "least velocity step", false);
  c.number("barrier_j", "J", "energy barrier over that edge", if_measured([](const Row& r) -> Value {
             if (!r.rock.mass) return {};
             return positive(r.rock.tipping.critical->barrier_j_kg * r.rock.mass->volume * r.density_kg_m3);
           }));
  quantiles(c, "volume_m3", "m3", "volume", false);
  quantiles(c, "mass_kg", "kg", "mass", false, true);
  c.number("alpha_point_deg", "deg", "definition (a): least angle of a contact point seen from the centre of mass",
           if_measured([](const Row& r) { return positive(base::rad_to_deg(r.rock.tipping.alpha_point_rad)); }));
  c.number("a_qs_min_g", "g", "definition (b): least quasi-static acceleration over all directions",
           if_measured([](const Row& r) { return positive(r.rock.tipping.a_qs_min_g); }));
  c.number("a_qs_min_toward_deg", "deg", "that direction, clockwise from true north",
           if_measured([](const Row& r) -> Value {
             return r.rock.tipping.a_qs_min_g > 0.0 ? real(r.rock.tipping.a_qs_min_azimuth_deg) : Value();
           }));
  c.flag("slides_first", "true: with the friction tested it slides before it tips",
         if_measured([](const Row& r) -> Value {
           return r.rock.tipping.friction > 0.0 ? Value(r.rock.tipping.slides_first) : Value();
         }));
  c.number("friction", "", "coefficient of friction tested",
           if_measured([](const Row& r) { return positive(r.rock.tipping.friction); }));
  c.number("alpha_without_pad_deg", "deg", "least tipping angle with the worst contact patch taken away",
           if_measured([](const Row& r) -> Value {
             std::optional<double> least;
             for (const auto& v : r.rock.tipping.without_pad)
               if (v.alpha_rad) least = std::min(least.value_or(*v.alpha_rad), *v.alpha_rad);
             return least ? real(base::rad_to_deg(*least)) : Value();
           }));
  c.text("photo_alpha_by_view", "what photographs would give: view azimuth [deg]: alpha left/right [deg]",
         [](const Row& r) {
           std::vector<std::string> items;
           if (r.measured)
             for (const auto& v : r.rock.tipping.photo_views)
               items.push_back(base::to_fixed(v.view_azimuth_deg, 0) + ":" +
                               base::to_fixed(base::rad_to_deg(v.alpha_left_rad), 1) + "/" +
                               base::to_fixed(base::rad_to_deg(v.alpha_right_rad), 1));
           return joined_text(items);
         });
  c.text("dominant_uncertainty", "input that makes most of the variance of alpha", [](const Row& r) -> std::string {
    if (!r.measured || !r.rock.tipping.uncertainty) return "";
    const survey::NamedValue* top = nullptr;
    for (const auto& s : r.rock.tipping.uncertainty->variance_shares)
      if (top == nullptr || s.value > top->value) top = &s;
    return top == nullptr ? "" : top->name;
  });
  c.count("draws", "Monte Carlo draws", if_measured([](const Row& r) -> Value {
            return r.rock.tipping.uncertainty ? Value(r.rock.tipping.uncertainty->draws) : Value();
          }));
}

void site_and_evidence(Columns& c, const Inventory& inventory) {
  for (const char* name : {"site_slope_deg", "distance_to_cliff_m", "topographic_note", "vs30_m_s",
                           "rocking_frequency_hz", "push_test", "site_class", "scale_bar", "field_note"})
    c.field(name);
  for (const auto& column : inventory.note_columns)
    c.add(ColumnType::text, "note_" + column, "", "column '" + column + "' of the field notes",
          [key = "note_" + column](const Row& r) { return words(r.text_of(key)); });
  c.count("photo_count", "photographs that show the rock",
          [](const Row& r) -> Value { return Value(static_cast<std::int64_t>(r.entry.photo_count)); });
  c.text("photos", "the best of them, best first; withheld in a protected inventory", [](const Row& r) {
    std::vector<std::string> files;
    if (!r.inventory.protection.on)
      for (const auto& photo : r.entry.photos) files.push_back(photo.file);
    return joined_text(files);
  });
  c.count("detections", "boxes the target was located from", [](const Row& r) -> Value {
    return r.entry.target ? Value(static_cast<std::int64_t>(r.entry.target->detections.size())) : Value();
  });
  c.text("mesh_file", "closed mesh within the result's folder; withheld in a protected inventory",
         [](const Row& r) { return r.inventory.protection.on ? std::string() : r.entry.mesh_file; });
  c.text("mesh_sha256", "SHA-256 of that file", [](const Row& r) { return r.entry.mesh_sha256; });
  c.text("made_by", "program and version that made the result",
         [](const Row& r) { return r.survey.version.empty() ? std::string() : "cairn " + r.survey.version; });
  c.count("seed", "seed of the result's random draws",
          [](const Row& r) -> Value { return r.survey.seed ? Value(*r.survey.seed) : Value(); });
}

}  // namespace

std::vector<InventoryColumn> inventory_columns(const Inventory& inventory) {
  Columns c;
  identity(c);
  position(c);
  tipping(c);
  geometry_columns(c);
  geology(c);
  site_and_evidence(c, inventory);
  return c.take();
}

}  // namespace cairn::report
