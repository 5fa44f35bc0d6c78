// Rocks of a large cloud, tile by tile: ground, objects that stand out of it, and what each object is.
#pragma once

#include <any>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geometry/vec.hpp"
#include "segmentation/candidates.hpp"
#include "segmentation/ground_filter.hpp"
#include "segmentation/labels.hpp"

namespace cairn::pipeline {

struct SegmentTilesOptions {
  double tile_m = 0.0;          // edge of a tile; 0: as large as the memory allows
  double patch_margin_m = 1.0;  // what an object is shown of its surroundings, beyond its circle
  segmentation::GroundFilterOptions ground;
  segmentation::CandidateOptions candidates;

  void visit(base::OptionVisitor& visitor);
};

// A cloud that is read in pieces, again and again. Positions: local ENU, m.
struct PointSource {
  std::uint64_t count = 0;
  // Points [first, first + n). Called from one thread at a time.
  std::function<std::vector<geometry::Vec3>(std::uint64_t first, std::uint64_t n)> read;
};
// Of points in memory; they must outlive it.
[[nodiscard]] PointSource source_of(std::span<const geometry::Vec3> points);

// One object and its surroundings, as whoever tells rock from pedestal gets it.
struct ObjectPatch {
  std::span<const geometry::Vec3> points;
  const segmentation::Candidate* object = nullptr;  // its point indices count in `points`
  const segmentation::GroundSurface* ground = nullptr;
};

struct ObjectLabels {
  std::string reason, message;              // "" = accepted; else why not
  std::vector<segmentation::Label> labels;  // one a point of the patch; unlabelled: no word on it
  std::vector<float> probability;           // likewise; may be empty: 1
  std::any record;                          // what the caller wants to keep of it
};
// Must not depend on anything but the patch; called from several threads.
using LabelObject = std::function<ObjectLabels(const ObjectPatch&)>;
// Everything that stands out is rock.
[[nodiscard]] ObjectLabels label_as_rock(const ObjectPatch& patch);

struct TiledObject {
  segmentation::Candidate candidate;                  // without points; they stand below
  std::string reason, message;                        // "" = accepted
  std::uint32_t target_id = segmentation::kNoTarget;  // 1, 2, ... in order
  std::vector<std::uint64_t> points;                  // of the cloud, ascending: those that got a label
  std::vector<segmentation::Label> labels;            // of them
  std::vector<float> probability;
  std::any record;
};

struct TiledSegments {
  std::vector<TiledObject> objects;         // by their anchors from north to south, then west to east
  std::vector<segmentation::Label> labels;  // one a point: terrain, of an accepted object, or unlabelled
  std::uint64_t not_finite = 0, ground = 0;
  std::size_t tiles = 0;
  double tile_m = 0.0, buffer_m = 0.0, cell_m = 0.0;
};

// The ground grid of the whole cloud is cut into tiles of whole blocks of 64 cells. Each is filtered with a buffer of
// at least four times max_object_m, on the grid of the whole, so that heights inside are those of the whole; an object
// belongs to the tile its circle's centre lies in. Objects wider than the buffer may differ from tile to tile.
// Where an object is labelled by two patches, rock wins over what is not, then the earlier object.
// Memory: 1 byte a point, 30 bytes a labelled point, 64 bytes a point of the largest buffered tile. Where tile_m is 0
// the tile is as large as ctx.memory_limit_bytes allows (no limit: 4 GiB). Throws resource_exhausted where even a tile
// of one block does not fit, invalid_input where no point is finite. Cost: reading, once for the extent, and for each
// tile those pieces of 65 536 points whose box meets it (linear where the file is in some spatial order, as surveys
// are; tiles times points where it is shuffled).
[[nodiscard]] TiledSegments segment_tiles(const PointSource& source, const SegmentTilesOptions& options,
                                          const LabelObject& label, base::RunContext& ctx);

}  // namespace cairn::pipeline
