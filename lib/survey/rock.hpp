// A candidate rock cut from the cloud: geometry, tipping, and how far the numbers can be trusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/mass_properties.hpp"
#include "geometry/vec.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

// measured: contact and sides seen; bounded: contact known within an interval;
// screening: contact assumed; not_measurable: no alpha may be printed.
enum class Grade { measured, bounded, screening, not_measurable };

[[nodiscard]] std::string_view name_of(Grade grade);
[[nodiscard]] std::optional<Grade> grade_from(std::string_view name);

// How the unseen base was closed. Declared with every volume.
// plane: the plane of the ground; patch: a smooth patch through the contact line; wrap: a wrapping surface.
enum class CapModel { none, plane, patch, wrap };
[[nodiscard]] std::string_view name_of(CapModel cap);

// One edge of the support polygon (fragility.md section 7.3).
struct TippingEdge {
  double azimuth_deg = 0.0;  // topple towards, clockwise from north: the edge's outward normal
  double alpha_rad = 0.0;    // rotation that brings the centre of mass above the edge
  double r_m = 0.0;          // centre of mass to edge
  double p_rad_s = 0.0;      // sqrt(m g R cos(delta) / I_edge)
  double a_qs_g = 0.0;       // quasi-static acceleration along the normal / g
  double v_min_m_s = 0.0;    // least velocity step
};

struct Tipping {
  Grade grade = Grade::not_measurable;
  std::vector<std::string> reasons;       // codes that explain the grade
  std::vector<geometry::Vec3> contact;    // support polygon used, local ENU, m, counter-clockwise from above
  bool contact_assumed = true;            // taken as a band at the base, not observed
  std::optional<TippingEdge> critical;    // least alpha; empty when not_measurable
  std::vector<double> a_qs_g_by_azimuth;  // 360 values, 1 deg, toppling towards; empty when not_measurable
};

struct Rock {
  TargetId target;  // the located object it belongs to; its id in every product
  std::string object_class;
  std::size_t point_count = 0;
  double point_spacing_m = 0.0;                    // median distance to the nearest neighbour
  geometry::Vec3 size_m = geometry::Vec3::Zero();  // length >= width (least-area rectangle seen from above), height
  double base_height_m = 0.0;                      // local up of the ground at the rock, m
  double length_azimuth_deg = 0.0;                 // of the longer side, clockwise from north, 0..180
  CapModel cap = CapModel::none;
  double unseen_area_fraction = 1.0;             // of the closed surface, 0..1
  std::optional<geometry::MassProperties> mass;  // closed mesh; unit density
  double hull_volume_m3 = 0.0;                   // upper bound of the volume
  double density_kg_m3 = 0.0;
  bool density_assumed = true;
  Tipping tipping;
  std::vector<std::string> reasons;  // why it was rejected, where it was
  bool rejected = false;
};

}  // namespace cairn::survey
