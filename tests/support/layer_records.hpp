// A small survey with one of everything, for tests of layers.
#pragma once

#include <cmath>

#include "report/layers.hpp"

namespace cairn::testing {

inline report::LayerRecords example_records() {
  using geometry::Vec3;
  report::LayerRecords records;
  records.origin = {{46.842979, -91.993612, 198.0}, survey::HeightType::ellipsoidal, ""};
  records.time_base = base::TimeBase::utc;

  survey::Frame nadir;  // 30 m up, looking down, image top to the north
  nadir.id = survey::FrameId(0);
  nadir.camera = survey::CameraId(0);
  nadir.time_ns = 1466699519000000000;
  nadir.image = "images/DJI_0018.JPG";
  nadir.T_world_camera.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  nadir.T_world_camera.translation = {0, 0, 30};
  nadir.sigma_xy_m = 1.5;
  nadir.sigma_z_m = 2.5;
  nadir.sigma_rot_deg = 0.5;
  survey::Frame oblique = nadir;  // looking east, 45 degrees down
  oblique.id = survey::FrameId(1);
  oblique.image = "images/DJI_0019.JPG";
  const double h = std::sqrt(0.5);
  oblique.T_world_camera.rotation << 0, -h, h, -1, 0, 0, 0, -h, -h;
  oblique.T_world_camera.translation = {-50, 20, 31};
  records.frames = {nadir, oblique};
  records.footprints = {{{-20, -15}, {20, -15}, {20, 15}, {-20, 15}}, {}};
  records.ground_up_m = -1.0;

  survey::Target boulder;
  boulder.id = survey::TargetId(4);
  boulder.object_class = "boulder";
  boulder.state = survey::TargetState::mapped;
  boulder.centre = {10.0, -5.0, 0.5};
  boulder.covariance << 0.04, 0.03, 0, 0.03, 0.04, 0, 0, 0, 0.09;
  boulder.detections = {survey::DetectionId(1), survey::DetectionId(7), survey::DetectionId(9)};
  boulder.keyframes = {survey::FrameId(0), survey::FrameId(1)};
  boulder.bcylinder = geometry::VerticalCylinder{{10.0, -5.0}, -0.2, 1.1, 0.8};
  boulder.entropy_nats = {3.0, 1.5};
  boulder.mean_score = 0.9;
  boulder.reasons = {"converged"};
  survey::Target tree = boulder;
  tree.id = survey::TargetId(5);
  tree.object_class = "tree";
  tree.centre = {-30.0, 12.0, 4.0};
  tree.bcylinder.reset();
  records.targets = {boulder, tree};

  survey::Rock rock;
  rock.target = boulder.id;
  rock.object_class = "boulder";
  rock.point_count = 281;
  rock.point_spacing_m = 0.06;
  rock.size_m = {2.0, 1.0, 1.5};
  rock.base_height_m = -0.2;
  rock.length_azimuth_deg = 30.0;
  rock.cap = survey::CapModel::plane;
  rock.unseen_area_fraction = 0.4;
  geometry::MassProperties mass;
  mass.volume = 1.25;
  mass.centre_of_mass = {10.1, -5.1, 0.45};
  rock.mass = mass;
  rock.hull_volume_m3 = 1.6;
  rock.density_kg_m3 = 2650.0;
  rock.tipping.grade = survey::Grade::screening;
  rock.tipping.reasons = {"contact_assumed", "base_unseen"};
  rock.tipping.critical = survey::TippingEdge{135.0, 0.5235987755982988, 0.9, 3.1, 0.57, 0.8};
  rock.reasons = {"few_views"};
  survey::Rock unmeasured = rock;
  unmeasured.target = tree.id;
  unmeasured.tipping.grade = survey::Grade::not_measurable;
  survey::Rock rejected = rock;
  rejected.target = survey::TargetId(99);
  rejected.rejected = true;
  rejected.mass.reset();
  rejected.reasons = {"too_few_points"};
  records.rocks = {rock, unmeasured, rejected};

  survey::Obstacle obstacle;
  obstacle.target = boulder.id;
  obstacle.object_class = "boulder";
  obstacle.position = {10.0, -5.0, -0.2};
  obstacle.covariance << 0.04, 0, 0, 0.01;
  obstacle.width_m = 1.6;
  obstacle.height_m = 1.3;
  obstacle.score = 0.9;
  obstacle.observations = 3;
  obstacle.misses = 1;
  obstacle.first_seen_ns = 1'466'699'519'000'000'000;
  obstacle.last_seen_ns = 1'466'699'531'000'000'000;
  obstacle.sigma_width_m = 0.05;
  obstacle.sigma_height_m = 0.1;
  obstacle.velocity = geometry::Vec2(0.4, -0.1);
  obstacle.velocity_covariance << 0.01, 0, 0, 0.02;
  records.obstacles = {obstacle};

  survey::CoverageGap gap;
  gap.id = survey::GapId(0);
  gap.rings = {{{20, 0}, {30, 0}, {30, 10}, {20, 10}}, {{24, 4}, {24, 6}, {26, 6}, {26, 4}}};
  gap.centre = {22.0, 2.0, 0.3};
  gap.area_m2 = 99.0;
  gap.facets = 640;
  gap.reason = "too_few_views";
  gap.nearest_frames = {survey::FrameId(1), survey::FrameId(0)};
  gap.view = survey::SuggestedView{{22.0, -28.0, 30.3}, {22.0, 2.0, 0.3}};
  records.gaps = {gap};
  return records;
}

}  // namespace cairn::testing
