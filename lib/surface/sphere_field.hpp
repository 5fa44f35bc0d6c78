// Signed distance to noisy points near a surface, from local fits at the nodes of a lattice.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "surface/lattice.hpp"

namespace cairn::surface {

// Algebraic sphere u0 + linear . y + u4 y.y about a node, y = position - node [m]; scaled so that its value is the
// distance to first order, > 0 outside.
struct LocalSphere {
  float u0 = 0.0F;
  float linear[3] = {0.0F, 0.0F, 0.0F};
  float u4 = 0.0F;
  float trust = 0.0F;  // 0 = no fit .. 1 = enough points, on all sides of the node

  [[nodiscard]] double at(const geometry::Vec3& y) const {
    return static_cast<double>(u0) + static_cast<double>(linear[0]) * y.x() + static_cast<double>(linear[1]) * y.y() +
           static_cast<double>(linear[2]) * y.z() + static_cast<double>(u4) * y.squaredNorm();
  }
};

// The nodes within reach of a point. Weights (1 - d^2 / reach^2)^3.
struct NodeBand {
  double reach = 0.0;                // m
  std::vector<std::int32_t> slot;    // a node of the lattice: index into the lists below, -1 = out of reach
  std::vector<std::uint32_t> nodes;  // ascending
  // Plane through the neighbours of a node: unit normal (sign open until `orient`), its distance from the node along
  // the normal [m], area of surface a point stands for there [m^2]; `planar` 0 = too few points, or the node lies off.
  std::vector<geometry::Vec3> normal;
  std::vector<float> distance, point_area;
  std::vector<std::uint8_t> planar;
};

// points: in order of position for cache's sake; reach [m]. Cost: points x nodes in reach.
[[nodiscard]] NodeBand fit_planes(const Lattice& lattice, std::span<const geometry::Vec3> points, double reach);

// The band alone, without planes.
[[nodiscard]] NodeBand nodes_in_reach(const Lattice& lattice, std::span<const geometry::Vec3> points, double reach);

// Turns the normals outwards: of the two sides of the surface the one from which more of 26 straight ways leave the
// lattice past all points (`more`: further points that block, without a plane). Then neighbours vote.
// Needs gaps in the points smaller than the rest of the surface; cost 26 x nodes.
void orient(const Lattice& lattice, NodeBand& band, std::span<const geometry::Vec3> points,
            std::span<const geometry::Vec3> more);

// Outward normal and area of each point, from the nodes around it; zero normal where no plane is near.
struct PointFrames {
  std::vector<geometry::Vec3> normals;
  std::vector<double> areas;  // m^2
};
[[nodiscard]] PointFrames point_frames(const Lattice& lattice, const NodeBand& band,
                                       std::span<const geometry::Vec3> points);

// Algebraic point set surfaces (Guennebaud & Gross 2007, ACM TOG 26:3, eqs 4 and 5), fitted at the band's nodes: for a
// sphere exact at any reach, so that smoothing does not shrink round bodies. One a node of `band`.
[[nodiscard]] std::vector<LocalSphere> fit_spheres(const Lattice& lattice, const NodeBand& band,
                                                   std::span<const geometry::Vec3> points,
                                                   std::span<const geometry::Vec3> normals);

// Spheres over ever wider reaches, for places where the points leave gaps: levels 1, 2, .. of twice the step and reach
// each, on the nodes that `lattice` shares with them, from points thinned to their cells.
class WideField {
 public:
  // Levels up to a reach of `widest` [m], and as far as the lattice can be halved.
  WideField(const Lattice& lattice, double reach, double widest, std::span<const geometry::Vec3> points,
            std::span<const geometry::Vec3> normals);
  // Signed distance from the narrowest levels that are trusted at p; what they leave open is `otherwise`.
  [[nodiscard]] double at(const geometry::Vec3& p, double otherwise) const;

 private:
  struct Level {
    Lattice lattice;
    NodeBand band;
    std::vector<LocalSphere> spheres;
  };
  std::vector<Level> levels_;
};

}  // namespace cairn::surface
