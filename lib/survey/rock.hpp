// A candidate rock cut from the cloud: geometry, tipping, and how far the numbers can be trusted.
#pragma once

#include <array>
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
  double azimuth_deg = 0.0;      // topple towards, clockwise from north: the edge's outward normal
  double alpha_rad = 0.0;        // rotation that brings the centre of mass above the edge
  double r_m = 0.0;              // centre of mass to edge
  double p_rad_s = 0.0;          // sqrt(m g R cos(delta) / I_edge)
  double a_qs_g = 0.0;           // quasi-static acceleration along the normal / g
  double v_min_m_s = 0.0;        // least velocity step
  double inclination_rad = 0.0;  // delta: of the edge to the horizontal
  double inertia_m2 = 0.0;       // about the edge, per unit mass
  double barrier_j_kg = 0.0;     // energy barrier, per unit mass
  std::array<geometry::Vec3, 2> ends{geometry::Vec3::Zero(), geometry::Vec3::Zero()};  // m
  double critical_share = 0.0;  // of the draws in which it is the critical edge, 0..1; 0 without draws
};

// Over the Monte Carlo draws: 5, 16, 50, 84 and 95 %.
struct Quantiles {
  double p05 = 0.0, p16 = 0.0, p50 = 0.0, p84 = 0.0, p95 = 0.0;
};

struct NamedQuantiles {
  std::string name;  // as in files, unit included: alpha_min_deg, mass_kg, com_x_m, ..
  Quantiles value;
};

struct NamedValue {
  std::string name;
  double value = 0.0;
};

// One end of the interval that the contact's unknown part leaves. Nothing but `reason` where it cannot hold the rock.
struct TippingBound {
  std::string contact;  // which contact: "rim", "seen", "inner"
  std::string reason;   // "" where the rock stands on it, else the reason code
  std::optional<TippingEdge> critical;
  std::vector<double> a_qs_g_by_azimuth;  // 360 values, or none
};

// alpha with one thing changed: a pad taken away, or the contact drawn in by a gap.
struct TippingVariant {
  std::string name;    // "pad 2", "gap 0.02 m"
  double value = 0.0;  // the pad's number, or the gap [m]
  std::string reason;  // "" where the rock stands, else the reason code
  std::optional<double> alpha_rad, azimuth_deg;
};

// What a photograph from one side would give (fragility.md section 1.1). Holds for that view only.
struct PhotoView {
  double view_azimuth_deg = 0.0;                       // the camera looks this way, clockwise from north
  double alpha_left_rad = 0.0, alpha_right_rad = 0.0;  // about the left and right rocking point as seen
  double r_left_m = 0.0, r_right_m = 0.0;
};

// Rest on one point: stable while the rock's centre lies low enough over the two curvatures.
struct RollingContact {
  double height_m = 0.0;                // centre of mass above the point
  double rock_curvature_1_m = 0.0;      // 1/m, greatest principal curvature of the rock at the point, convex > 0
  double pedestal_curvature_1_m = 0.0;  // 1/m, convex > 0, 0 = flat
  bool stable = false;                  // 1/H > curvature of the rock + curvature of the pedestal
};

struct TippingUncertainty {
  std::int64_t draws = 0;           // asked for
  std::int64_t standing = 0;        // of them, those in equilibrium; the quantiles of alpha are over these
  double slides_first_share = 0.0;  // of the standing ones, 0..1
  std::vector<NamedQuantiles> scalars;
  std::array<std::vector<double>, 5> a_qs_g_by_azimuth;  // 5, 16, 50, 84, 95 %: 360 values each, or none
  std::vector<double> rose;  // 36 values: share of draws whose critical azimuth lies in 0-10 deg, ..
  // One source at a time over the sum, of alpha on the rim: contact_seen, contact_inferred, cap, surface, density,
  // vertical, scale; and of alpha on the bearing contact, with hidden_bearing.
  std::vector<NamedValue> variance_shares, variance_shares_bearing;
  std::vector<NamedValue> inputs;  // standard deviations and ranges drawn from, unit in the name
  std::string draws_file;          // joint draws, beside the record

  [[nodiscard]] const Quantiles* find(std::string_view name) const {
    for (const auto& s : scalars)
      if (s.name == name) return &s.value;
    return nullptr;
  }
};

struct Tipping {
  Grade grade = Grade::not_measurable;
  std::vector<std::string> reasons;       // codes that explain the grade
  std::vector<geometry::Vec3> contact;    // support polygon used, local ENU, m, counter-clockwise from above
  bool contact_assumed = true;            // taken as a band at the base, not observed
  std::optional<TippingEdge> critical;    // least alpha, on the rim; empty when not_measurable
  std::vector<double> a_qs_g_by_azimuth;  // 360 values, 1 deg, toppling towards; empty when not_measurable
  // All below is empty or zero when not_measurable, the contact's description excepted.
  double contact_observed_share = 0.0;  // of the contact's length, 0..1
  std::int64_t contact_pads = 0;        // separate contact patches
  double contact_slope_rad = 0.0;       // of the plane through the contact, 0..pi/2
  double contact_aspect_deg = 0.0;      // that plane falls this way, clockwise from north
  std::vector<TippingEdge> edges;       // all edges about which it can tip, by azimuth round the support
  double alpha_point_rad = 0.0;         // definition (a): least angle of a contact point seen from the centre of mass
  double a_qs_min_g = 0.0;              // definition (b): least over all directions
  double a_qs_min_azimuth_deg = 0.0;
  std::optional<TippingBound> inner;  // least contact that the evidence allows: lower bound of alpha
  std::optional<TippingBound> outer;  // the visible crease, its gaps closed: upper bound of alpha
  double friction = 0.0;              // coefficient tested; slides first where tan(alpha) is above
  bool slides_first = false;
  std::vector<TippingVariant> without_pad;  // where there are several pads
  std::vector<TippingVariant> gaps;         // contact counted as far as the gap is below 1, 2, 5 cm
  std::vector<PhotoView> photo_views;
  std::optional<RollingContact> rolling;  // reason point_contact
  std::optional<TippingUncertainty> uncertainty;
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
  double noise_m = 0.0;             // standard deviation of the points about the mesh; 0 = not known
  double cap_height_sigma_m = 0.0;  // of the cap's height inside the contact line; 0 = not known
  // Height/width ratios by definition, over the volume: hwr_axis, hwr_upright, hwr_box, hwr_hull, ..
  std::vector<NamedValue> shape_ratios;
  Tipping tipping;
  std::string name;                  // the field's name for it; "" = none
  std::vector<TargetId> aliases;     // ids it also answers to, after a merge or a re-run
  std::vector<TargetId> supersedes;  // records that it replaces
  std::string review;                // last decision in review: accept, reject, ..; "" = not reviewed
  std::vector<std::string> reasons;  // why it was rejected, where it was
  bool rejected = false;
};

}  // namespace cairn::survey
