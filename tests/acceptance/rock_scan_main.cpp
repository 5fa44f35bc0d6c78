// rock_scan SEED OUT [--family F] [--hiding drawn|none|brush|sector|absent] [--height M] [--spacing M] [--noise M]
//           [--outliers SHARE] [--scene]
// Writes one simulated scan: OUT.las (positions and colours), OUT.truth.las (the same points with the true label and
// target_id), OUT.contact.csv (the true rim), OUT.bearing.csv, OUT.body.ply, and truth.json in the folder OUT.truth/.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/ply.hpp"
#include "io/truth.hpp"
#include "support/rock_scan.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::base::Error;
using cairn::base::ErrorCode;
using cairn::testing::Hiding;

Hiding hiding_from(const std::string& name) {
  const std::vector<std::string> names = {"drawn", "none", "brush", "sector", "absent"};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<Hiding>(i);
  throw Error(ErrorCode::invalid_argument, "unknown hiding").found(name).allowed("drawn, none, brush, sector, absent");
}

void write_line(const fs::path& path, const cairn::survey::Contact& contact) {
  cairn::io::ContactFile file;
  file.crs = "local";
  for (const auto& vertex : contact) file.rows.push_back({1, vertex});
  cairn::io::write_contact_csv(path, file);
}

void write_truth_folder(const fs::path& folder, const cairn::survey::Truth& truth) {
  fs::create_directories(folder);
  cairn::survey::Origin origin;
  cairn::io::write_truth(truth, origin, folder);
}

int run(int argc, const char* const* argv) {
  if (argc < 3) {
    std::fprintf(stderr, "rock_scan SEED OUT [options]; see the head of rock_scan_main.cpp\n");
    return 2;
  }
  const auto seed = static_cast<std::uint64_t>(cairn::base::parse_integer(argv[1]).value_or(1));
  const std::string out = argv[2];
  cairn::testing::RockScanOptions options;
  bool scene = false;
  for (int i = 3; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--scene") {
      scene = true;
      continue;
    }
    if (i + 1 == argc) throw Error(ErrorCode::invalid_argument, "option without a value").found(name);
    const std::string value = argv[++i];
    const double number = cairn::base::parse_real(value).value_or(0.0);
    if (name == "--family") options.family = value;
    else if (name == "--hiding") options.hiding = hiding_from(value);
    else if (name == "--height") options.height_m = number;
    else if (name == "--spacing") options.spacing_m = number;
    else if (name == "--noise") options.noise_m = number;
    else if (name == "--outliers") options.outlier_share = number;
    else throw Error(ErrorCode::invalid_argument, "unknown option").found(name);
  }
  if (scene) {
    cairn::testing::RockSceneOptions many;
    many.family = options.family;
    const auto made = cairn::testing::make_rock_scene(seed, many);
    cairn::io::write_cloud(out + ".las", made.cloud);
    cairn::io::write_cloud(out + ".truth.las", made.labelled());
    cairn::survey::Truth truth;
    truth.scene = "rock scene";
    truth.seed = seed;
    truth.objects = made.rocks;
    write_truth_folder(out + ".truth", truth);
    std::printf("%zu points, %zu rocks\n", made.cloud.size(), made.rocks.size());
    return 0;
  }
  const auto scan = cairn::testing::make_rock_scan(seed, options);
  cairn::io::write_cloud(out + ".las", scan.cloud);
  cairn::io::write_cloud(out + ".truth.las", scan.labelled());
  write_line(out + ".contact.csv", scan.contact());
  write_line(out + ".bearing.csv", scan.contact(true));
  cairn::io::write_ply(out + ".body.ply", scan.body);
  write_truth_folder(out + ".truth", scan.truth());
  std::printf(
      "%zu points, family %s, alpha on the rim %.2f deg, on the bearing %.2f deg, volume %.4f m3, hidden %.2f\n",
      scan.cloud.size(), scan.family.c_str(), scan.alpha_rim_deg(), scan.alpha_bearing_deg(), scan.mass.volume,
      scan.hidden_share);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
