// Options of `check`.
#pragma once

#include <cstdint>

#include "adjustment/evidence_cloud.hpp"
#include "adjustment/evidence_pairs.hpp"
#include "adjustment/evidence_ties.hpp"
#include "base/options.hpp"

namespace cairn::pipeline {

struct CheckOptions {
  double min_height_m = 1.0;  // allowed heights of the cameras above the ground
  double max_height_m = 500.0;
  double min_axis_hits = 0.9;           // share of the frames whose optical axis must meet the ground
  double max_range_m = 1000.0;          // how far along the axis the ground may be
  double box_tolerance_px = 0.5;        // by how much a box may pass the image's border
  double max_cloud_offset_m = 0.2;      // larger measured offsets of the cloud are reported
  double max_cloud_distance_m = 500.0;  // between the outlines of cloud and cameras
  std::int64_t max_images = 200;        // read for evidence; of larger surveys, runs of neighbours are taken
  bool pixels = true;                   // off: nothing is decoded, only headers are read
  adjustment::TieEvidenceOptions ties;
  adjustment::MatchOptions matches;
  adjustment::PairEvidenceOptions pairs;
  adjustment::CloudEvidenceOptions cloud;

  void visit(base::OptionVisitor& v) {
    v.real("min-height-m", min_height_m, 0.0, 1e4, "least height of a camera above the ground [m]");
    v.real("max-height-m", max_height_m, 1.0, 1e5, "largest height of a camera above the ground [m]");
    v.real("min-axis-hits", min_axis_hits, 0.0, 1.0, "least share of frames whose optical axis meets the ground");
    v.real("max-range-m", max_range_m, 1.0, 1e6, "largest distance to the ground along the optical axis [m]");
    v.real("box-tolerance-px", box_tolerance_px, 0.0, 1000.0, "by how much boxes may pass the image's border [px]");
    v.real("max-cloud-offset-m", max_cloud_offset_m, 0.0, 1000.0, "largest offset of the cloud not reported [m]");
    v.real("max-cloud-distance-m", max_cloud_distance_m, 0.0, 1e5,
           "largest distance between the outlines of cloud and cameras [m]");
    v.integer("max-images", max_images, 2, 100000, "images decoded for evidence");
    v.flag("pixels", pixels, "decode images for evidence (off: headers only)");
    ties.visit(v);
    matches.visit(v);
    pairs.visit(v);
    cloud.visit(v);
  }
};

}  // namespace cairn::pipeline
