// What a simulated survey knows about itself: the answers that its records are scored against.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"
#include "survey/frame.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

struct TruthObject {
  ObjectId id;
  std::string object_class;  // what a perfect detector calls it
  bool sought = false;       // one of those the survey is flown for (a PBR); else a distractor
  // Smallest upright cylinder: smallest enclosing circle of the exposed surface seen from above, times its height
  // range. The object's centre is the middle of this cylinder's axis. Local ENU, m.
  geometry::VerticalCylinder cylinder;
  std::string mesh;  // closed triangle mesh, local ENU, path relative to the survey folder; "" = none kept
  // Basal contact, rings of local ENU points, m; empty where there is none. The rim is the visible crease between
  // rock and pedestal; the bearing contact lies inside it.
  std::vector<std::vector<geometry::Vec3>> contact_rim, contact_bearing;
  double volume_m3 = 0.0;                                  // 0 = not known
  geometry::Vec3 centre_of_mass = geometry::Vec3::Zero();  // of a uniform body, local ENU, m
};

// A sought or distracting object in one image, before any detector.
struct TruthBox {
  FrameId frame;
  ObjectId object;
  geometry::PixelBox box;      // of the visible outline, clipped to the raw image, px
  bool whole = false;          // the whole outline lies inside the image
  double visible_share = 1.0;  // of the outline's pixels inside the image: not hidden by something nearer, 0..1
};

// Where a detection came from. An invalid object = a false box; `clutter` then numbers the persistent
// source that made it (>= 0), or is -1 for a sporadic one.
struct DetectionOrigin {
  DetectionId detection;
  ObjectId object;
  std::int64_t clutter = -1;
};

struct Truth {
  std::string scene;                        // name of the scene
  std::uint64_t seed = 0;                   // that made this survey
  std::vector<TruthObject> objects;         // ascending id
  std::vector<Frame> frames;                // ascending id, the survey's frames with their true poses
  std::vector<TruthBox> boxes;              // by frame, then object
  std::vector<DetectionOrigin> detections;  // ascending detection id
};

}  // namespace cairn::survey
