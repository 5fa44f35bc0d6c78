#include "pipeline/rock_results.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geometry/mass_properties.hpp"
#include "io/json.hpp"
#include "io/mesh.hpp"
#include "io/rocks_json.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;

std::vector<RockResult> read_rock_results(const fs::path& input, const fs::path& results) {
  constexpr double kSameVolume = 1e-6;  // relative: files hold doubles or, at worst, single precision about the rock
  const bool folder = fs::is_directory(input);
  const io::Json records = io::read_json(results / "rocks.json");
  std::vector<RockResult> list;
  for (const auto& json : records.at("rocks").as_array()) {
    RockResult result;
    result.rock = io::rock_from_json(json);
    result.stem = folder ? std::to_string(result.rock.target.value) : input.stem().string();
    const fs::path file = folder ? input / (result.stem + ".ply") : input;
    if (!result.rock.rejected && result.rock.mass && fs::exists(file)) {
      result.mesh = geometry::weld(io::read_mesh(file).mesh);
      const double volume = geometry::mass_properties(result.mesh).volume;
      if (volume < 0.0) result.mesh = geometry::flipped(result.mesh);
      if (!(std::abs(std::abs(volume) - result.rock.mass->volume) <= kSameVolume * result.rock.mass->volume))
        throw base::Error(base::ErrorCode::failed_precondition, "the mesh is not the one its record describes")
            .file(file.string())
            .found("volume " + base::to_text(std::abs(volume)) + " m3")
            .allowed(base::to_text(result.rock.mass->volume) + " m3")
            .hint("Run cairn fragility again");
    }
    list.push_back(std::move(result));
  }
  return list;
}

}  // namespace cairn::pipeline
