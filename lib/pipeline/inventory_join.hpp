// What joins records to the rocks of an inventory: notes, earlier inventories, other surveys. Internal to the stage.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "geodesy/local_frame.hpp"
#include "pipeline/inventory_stage.hpp"
#include "report/inventory.hpp"

namespace cairn::pipeline {

// Positions of the rocks that have one, to compare in plan over all surveys.
class RockPlaces {
 public:
  explicit RockPlaces(const report::Inventory& inventory);

  struct Near {
    std::size_t rock = 0;  // in Inventory::rocks
    double distance_m = 0.0;
  };
  // Those within `limit`, nearest first; equal distances by index.
  [[nodiscard]] std::vector<Near> within(double latitude_deg, double longitude_deg, double limit) const;
  [[nodiscard]] bool has(std::size_t rock) const { return known_[rock]; }
  [[nodiscard]] double latitude(std::size_t rock) const { return degrees_[rock].x(); }
  [[nodiscard]] double longitude(std::size_t rock) const { return degrees_[rock].y(); }

 private:
  std::vector<bool> known_;
  std::vector<geometry::Vec2> degrees_;
  std::vector<geometry::Vec3> earth_;  // on the ellipsoid, one frame for all
  std::optional<geodesy::LocalFrame> frame_;
};

// Notes go to the rocks' fields. The rejects: notes that no rock is near to, or two as near.
[[nodiscard]] std::vector<base::Reject> join_notes(report::Inventory& inventory, const InventoryOptions& options);

// Rocks at the places of an earlier inventory take its ids; the ids they would have had become aliases. Number kept.
std::size_t keep_previous_ids(report::Inventory& inventory, const InventoryOptions& options);

// Rocks of later surveys that are rocks of earlier ones name them in revisit_of. Number found.
std::size_t find_revisits(report::Inventory& inventory, double same_within_m);

}  // namespace cairn::pipeline
