#include "report/layers.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "report/layer_looks.hpp"
#include "report/layer_table.hpp"

namespace cairn::report {
namespace {

using geometry::Vec3;
using io::Feature;
using io::Value;

// Fills a feature by column names, so that values cannot slip against the table.
class Row {
 public:
  explicit Row(const io::Layer& layer) : layer_(layer) { feature_.values.resize(layer.columns.size()); }

  Row& set(std::string_view name, Value value) {
    const std::size_t index = layer_.column(name);
    if (index == layer_.columns.size())
      throw base::Error(base::ErrorCode::internal, "a column that layer '" + layer_.name + "' does not have")
          .found(name);
    if (auto* real = std::get_if<double>(&value)) *real += 0.0;  // no negative zero
    feature_.values[index] = std::move(value);
    return *this;
  }
  Row& set_count(std::string_view name, std::size_t value) { return set(name, static_cast<std::int64_t>(value)); }
  // Zero or less means "not known" in the records.
  Row& set_positive(std::string_view name, double value) { return value > 0.0 ? set(name, value) : *this; }

  Feature& feature() { return feature_; }

 private:
  const io::Layer& layer_;
  Feature feature_;
};

std::string joined(const std::vector<std::string>& codes) {
  std::string text;
  for (const auto& code : codes) text += (text.empty() ? "" : ";") + code;
  return text;
}

std::string record_name(const std::string& object_class, survey::TargetId id) {
  return (object_class.empty() ? std::string("object") : object_class) + " " + std::to_string(id.value);
}

// 1 sigma along the worst direction: root of the larger eigenvalue of a symmetric 2 x 2 matrix.
double worst_sigma(double xx, double xy, double yy) {
  const double mean = 0.5 * (xx + yy);
  return std::sqrt(std::max(0.0, mean + std::hypot(0.5 * (xx - yy), xy)));
}

double azimuth_deg(const Vec3& direction) {
  return base::azimuth_deg(direction.x(), direction.y());
}

double depression_deg(const Vec3& direction) {
  return base::rad_to_deg(std::atan2(-direction.z(), direction.head<2>().norm()));
}

class LayerBuilder {
 public:
  explicit LayerBuilder(const LayerRecords& records)
      : records_(records),
        frame_(records.origin.position),
        height_type_(io::height_type_text(records.origin.height_type, records.origin.geoid)) {}

  [[nodiscard]] io::Layer targets() const {
    io::Layer layer = empty("targets");
    for (const auto& target : records_.targets) {
      Row row(layer);
      place(row, target.centre);
      row.set("id", target.id.value)
          .set("name", record_name(target.object_class, target.id))
          .set("class", target.object_class)
          .set("state", std::string(survey::name_of(target.state)))
          .set("mean_score", target.mean_score)
          .set("reasons", joined(target.reasons))
          .set_count("detections", target.detections.size())
          .set_count("keyframes", target.keyframes.size());
      set_sigma(row, target);
      if (target.bcylinder)
        row.set("cylinder_radius_m", target.bcylinder->radius).set("cylinder_height_m", target.bcylinder->height());
      if (!target.entropy_nats.empty()) row.set("entropy_nats", target.entropy_nats.back());
      layer.features.push_back(std::move(row.feature()));
    }
    return finished(std::move(layer));
  }

  [[nodiscard]] io::Layer rocks(const char* name) const {
    io::Layer layer = empty("rocks");
    layer.name = name;
    std::map<survey::TargetId, const survey::Target*> targets;
    for (const auto& target : records_.targets) targets.emplace(target.id, &target);
    for (const auto& rock : records_.rocks) {
      const auto it = targets.find(rock.target);
      layer.features.push_back(rock_feature(layer, rock, it == targets.end() ? nullptr : it->second));
    }
    return finished(std::move(layer));
  }

  [[nodiscard]] io::Layer obstacles() const {
    io::Layer layer = empty("obstacles");
    for (const auto& obstacle : records_.obstacles) {
      Row row(layer);
      place(row, obstacle.position);
      const auto& c = obstacle.covariance;
      row.set("id", obstacle.target.value)
          .set("class", obstacle.object_class)
          .set("kind", std::string(survey::name_of(obstacle.kind)))
          .set_positive("sigma_horizontal_m", worst_sigma(c(0, 0), c(0, 1), c(1, 1)))
          .set("width_m", obstacle.width_m)
          .set("obstacle_height_m", obstacle.height_m)
          .set("score", obstacle.score)
          .set_count("observations", obstacle.observations)
          .set_positive("sigma_width_m", obstacle.sigma_width_m)
          .set_positive("sigma_obstacle_height_m", obstacle.sigma_height_m)
          .set_count("misses", obstacle.misses);
      if (c.trace() > 0.0)
        row.set("variance_east_m2", c(0, 0)).set("variance_north_m2", c(1, 1)).set("covariance_east_north_m2", c(0, 1));
      if (obstacle.last_seen_ns != 0)
        row.set("first_seen_ns", obstacle.first_seen_ns).set("last_seen_ns", obstacle.last_seen_ns);
      if (obstacle.velocity) {
        const auto& v = obstacle.velocity_covariance;
        row.set("velocity_east_m_s", obstacle.velocity->x())
            .set("velocity_north_m_s", obstacle.velocity->y())
            .set("sigma_velocity_m_s", worst_sigma(v(0, 0), v(0, 1), v(1, 1)));
      }
      layer.features.push_back(std::move(row.feature()));
    }
    return finished(std::move(layer));
  }

  [[nodiscard]] io::Layer frames() const {
    io::Layer layer = empty("frames");
    for (const auto& frame : records_.frames) {
      Row row(layer);
      const Vec3& centre = frame.T_world_camera.translation;
      place(row, centre);
      const Vec3 axis = frame.T_world_camera.rotation.col(2);
      const Vec3 image_up = -frame.T_world_camera.rotation.col(1);
      row.set("id", frame.id.value)
          .set("image", frame.image)
          .set("camera", frame.camera.value)
          .set("time_base", std::string(base::name_of(records_.time_base)))
          .set("axis_depression_deg", depression_deg(axis))
          .set_positive("sigma_horizontal_m", frame.sigma_xy_m)
          .set_positive("sigma_vertical_m", frame.sigma_z_m)
          .set_positive("sigma_rotation_deg", frame.sigma_rot_deg);
      // The azimuth of a direction within about a degree of the vertical says nothing.
      constexpr double kLeastHorizontal = 0.02;
      if (axis.head<2>().norm() > kLeastHorizontal) row.set("axis_azimuth_deg", azimuth_deg(axis));
      if (image_up.head<2>().norm() > kLeastHorizontal) row.set("image_top_azimuth_deg", azimuth_deg(image_up));
      if (frame.time_ns != 0 || records_.time_base != base::TimeBase::unknown) row.set("time_ns", frame.time_ns);
      if (records_.ground_up_m) row.set("above_ground_m", centre.z() - *records_.ground_up_m);
      layer.features.push_back(std::move(row.feature()));
    }
    return finished(std::move(layer));
  }

  [[nodiscard]] io::Layer footprints() const {
    io::Layer layer = empty("footprints");
    const std::size_t count = std::min(records_.frames.size(), records_.footprints.size());
    for (std::size_t i = 0; i < count; ++i) {
      const auto& ring = records_.footprints[i];
      if (ring.size() < 3 || !records_.ground_up_m) continue;
      const double up = *records_.ground_up_m;
      Row row(layer);
      row.feature().parts = {{io::to_geodetic(frame_, ring, up)}};
      const Vec3 foot(records_.frames[i].T_world_camera.translation.x(),
                      records_.frames[i].T_world_camera.translation.y(), up);
      row.set("frame", records_.frames[i].id.value)
          .set("image", records_.frames[i].image)
          .set("area_m2", std::abs(geometry::signed_area(ring)))
          .set("ground_height_m", frame_.to_geodetic(foot).height_m)
          .set("height_type", height_type_);
      layer.features.push_back(std::move(row.feature()));
    }
    return finished(std::move(layer));
  }

  [[nodiscard]] io::Layer gaps() const {
    io::Layer layer = empty("gaps");
    for (const auto& gap : records_.gaps) {
      Row row(layer);
      place(row, gap.centre);
      std::vector<std::vector<geometry::Geodetic>> rings;
      for (const auto& ring : gap.rings) rings.push_back(io::to_geodetic(frame_, ring, gap.centre.z()));
      row.feature().parts.clear();
      if (!rings.empty()) row.feature().parts.push_back(std::move(rings));
      std::vector<std::string> near;
      for (const auto frame : gap.nearest_frames) near.push_back(std::to_string(frame.value));
      row.set("id", gap.id.value)
          .set("reason", gap.reason)
          .set("area_m2", gap.area_m2)
          .set_count("facets", gap.facets)
          .set("nearest_frames", joined(near));
      if (gap.view) {
        const auto position = frame_.to_geodetic(gap.view->position);
        const Vec3 sight = gap.view->look_at - gap.view->position;
        row.set("view_latitude_deg", position.latitude_deg)
            .set("view_longitude_deg", position.longitude_deg)
            .set("view_height_m", position.height_m)
            .set("view_azimuth_deg", azimuth_deg(sight))
            .set("view_depression_deg", depression_deg(sight));
      }
      layer.features.push_back(std::move(row.feature()));
    }
    return finished(std::move(layer));
  }

 private:
  [[nodiscard]] io::Layer empty(std::string_view name) const {
    const LayerSpec& spec = layer_spec(name);
    io::Layer layer;
    layer.name = spec.name;
    layer.title = spec.title;
    layer.kind = spec.kind;
    layer.with_heights = spec.with_heights;
    layer.height_type = records_.origin.height_type;
    layer.geoid = records_.origin.geoid;
    layer.columns = spec.columns;
    return layer;
  }

  static io::Layer finished(io::Layer layer) {
    layer.style = look_of(layer);
    return layer;
  }

  // The point and the position columns.
  void place(Row& row, const Vec3& p_world) const {
    const auto g = frame_.to_geodetic(p_world);
    row.feature().parts = {{{g}}};
    row.set("latitude_deg", g.latitude_deg)
        .set("longitude_deg", g.longitude_deg)
        .set("height_m", g.height_m)
        .set("height_type", height_type_)
        .set("east_m", p_world.x())
        .set("north_m", p_world.y())
        .set("up_m", p_world.z());
  }

  static void set_sigma(Row& row, const survey::Target& target) {
    const auto& c = target.covariance;
    row.set_positive("sigma_horizontal_m", worst_sigma(c(0, 0), c(0, 1), c(1, 1)))
        .set_positive("sigma_vertical_m", std::sqrt(std::max(0.0, c(2, 2))));
  }

  [[nodiscard]] Feature rock_feature(const io::Layer& layer, const survey::Rock& rock,
                                     const survey::Target* target) const {
    Row row(layer);
    std::optional<Vec3> centre;
    if (target != nullptr) centre = target->centre;
    if (rock.mass) centre = rock.mass->centre_of_mass;
    if (centre) {
      place(row, *centre);
      const Vec3 foot(centre->x(), centre->y(), rock.base_height_m);
      if (rock.mass) row.set("base_height_m", frame_.to_geodetic(foot).height_m);
    }
    row.set("id", rock.target.value)
        .set("name", record_name(rock.object_class, rock.target))
        .set("class", rock.object_class)
        .set("status", std::string(rock.rejected ? "rejected" : "candidate"))
        .set("reasons", joined(rock.reasons))
        .set_count("points", rock.point_count)
        .set_positive("point_spacing_m", rock.point_spacing_m);
    if (target != nullptr) {
      set_sigma(row, *target);
      row.set_count("detections", target->detections.size());
    }
    if (rock.rejected) return std::move(row.feature());
    set_shape(row, rock);
    set_tipping(row, rock.tipping);
    return std::move(row.feature());
  }

  static void set_shape(Row& row, const survey::Rock& rock) {
    row.set_positive("length_m", rock.size_m.x())
        .set_positive("width_m", rock.size_m.y())
        .set_positive("rock_height_m", rock.size_m.z())
        .set_positive("hull_volume_m3", rock.hull_volume_m3)
        .set_positive("density_kg_m3", rock.density_kg_m3)
        .set("density_assumed", rock.density_assumed)
        .set("cap", std::string(survey::name_of(rock.cap)))
        .set("unseen_area_fraction", rock.unseen_area_fraction);
    if (rock.size_m.y() > 0.0)
      row.set("hwr", rock.size_m.z() / rock.size_m.y()).set("length_azimuth_deg", rock.length_azimuth_deg);
    if (rock.mass)
      row.set_positive("volume_m3", rock.mass->volume).set_positive("mass_kg", rock.mass->volume * rock.density_kg_m3);
  }

  static void set_tipping(Row& row, const survey::Tipping& tipping) {
    row.set("grade", std::string(survey::name_of(tipping.grade)))
        .set("grade_reasons", joined(tipping.reasons))
        .set("contact_assumed", tipping.contact_assumed);
    if (tipping.grade == survey::Grade::not_measurable || !tipping.critical) return;
    const auto& edge = *tipping.critical;
    row.set("alpha_min_deg", base::rad_to_deg(edge.alpha_rad))
        .set("topple_toward_deg", edge.azimuth_deg)
        .set("r_m", edge.r_m)
        .set("p_rad_s", edge.p_rad_s)
        .set("a_qs_g", edge.a_qs_g)
        .set("v_min_m_s", edge.v_min_m_s);
  }

  const LayerRecords& records_;
  geodesy::LocalFrame frame_;
  std::string height_type_;
};

}  // namespace

std::vector<io::Layer> build_layers(const LayerRecords& records) {
  const LayerBuilder builder(records);
  std::vector<io::Layer> layers;
  layers.push_back(builder.targets());
  layers.push_back(builder.rocks("rocks"));
  layers.push_back(builder.obstacles());
  layers.push_back(builder.frames());
  layers.push_back(builder.footprints());
  layers.push_back(builder.gaps());
  return layers;
}

io::Layer inventory_layer(const LayerRecords& records) {
  return LayerBuilder(records).rocks("inventory");
}

}  // namespace cairn::report
