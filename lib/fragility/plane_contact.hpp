// A convex body on a rigid level plane, with its contact uncertain; and what cosine pulses do to it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "fragility/hull_section.hpp"
#include "fragility/rocking_response.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::fragility {

// How a body stands on a plane, from its shape alone.
struct PlaneContact {
  RestingPose pose;
  double alpha = 0.0;        // least angle over the edges of the bearing facet, rad
  double azimuth_deg = 0.0;  // outward normal of that edge, clockwise from +y of the given frame, 0 <= a < 360
  double height = 0.0;       // of the centre of mass above the plane, m
};
// points of the body [m], z up. Empty where the body has no resting facet.
[[nodiscard]] std::optional<PlaneContact> plane_contact(std::span<const geometry::Vec3> points,
                                                        const geometry::MassProperties& mass);

// Settles the body and cuts it along an azimuth of the given frame: see hull_profile.
[[nodiscard]] std::optional<RockingProfile> plane_profile(std::span<const geometry::Vec3> points,
                                                          const geometry::MassProperties& mass, double azimuth_deg);

struct PulseTestOptions {
  std::int64_t contact_draws = 100;
  double vertex_noise_m = -1.0;     // normal error of every vertex, each axis; below 0 = a tenth of the median edge
  double azimuth_deg = -1.0;        // of the motion; below 0 = the weakest of the settled body
  double azimuth_spread_deg = 0.0;  // of the motion about azimuth_deg, uniform within +- this; 180 = any direction
  double eta_share_max = 0.5;       // as in SuiteOptions, uniform
  RockingOptions rocking;

  void visit(base::OptionVisitor& visitor);
};

struct PulsePrediction {
  PlaneContact contact;         // of the mesh as it is
  double azimuth_deg = 0.0;     // that was shaken
  double vertex_noise_m = 0.0;  // that was drawn
  std::size_t draws = 0;
  std::size_t unstable_draws = 0;           // whose hull does not stand along the azimuth: they count as overturned
  std::array<double, 5> alpha_quantiles{};  // of the least toppling angle of both sides, 5/16/50/84/95 %, rad
  std::vector<double> probability;          // a test
};

// Probability that a one-cosine motion of each test's {PGA [g], PGV/PGA [s]} overturns the body on a plane: the share
// of draws (vertices, restitution) and of both polarities. Keyed by ctx.seed. Throws failed_precondition for a body
// that cannot rest. Cost: draws x tests x about 0.1 ms.
[[nodiscard]] PulsePrediction predict_pulse_tests(const geometry::TriangleMesh& mesh,
                                                  const geometry::MassProperties& mass,
                                                  std::span<const std::array<double, 2>> pga_and_ratio,
                                                  const PulseTestOptions& options, base::RunContext& ctx);

}  // namespace cairn::fragility
