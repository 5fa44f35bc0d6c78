#include "pipeline/info.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "io/bytes.hpp"
#include "pipeline/info_kinds.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kHeadBytes = 4096;

// What a file is, by its first bytes; the first row that fits.
struct Magic {
  std::string_view start;
  info::Describe describe;
};
constexpr std::array kMagics = {
    Magic{"LASF", info::describe_las},
    Magic{"ply", info::describe_mesh_or_cloud},
    Magic{"# .PCD", info::describe_cloud},
    Magic{"VERSION", info::describe_cloud},
    Magic{"ASTM-E57", info::describe_cloud},  // refused there, with a remedy
    Magic{"glTF", info::describe_mesh},
    Magic{"OFF", info::describe_mesh},
    Magic{std::string_view("II*\0", 4), info::describe_raster},
    Magic{std::string_view("II+\0", 4), info::describe_raster},
    Magic{std::string_view("MM\0*", 4), info::describe_raster},
    Magic{std::string_view("MM\0+", 4), info::describe_raster},
    Magic{"SQLite format 3", info::describe_vector},
    Magic{"\xFF\xD8\xFF", info::describe_image},
    Magic{"\x89PNG", info::describe_image},
};

struct Extension {
  std::string_view extension;
  info::Describe describe;
};
constexpr std::array kExtensions = {
    Extension{".las", info::describe_las},           Extension{".laz", info::describe_las},
    Extension{".ply", info::describe_mesh_or_cloud}, Extension{".obj", info::describe_mesh_or_cloud},
    Extension{".pcd", info::describe_cloud},         Extension{".xyz", info::describe_cloud},
    Extension{".txt", info::describe_cloud},         Extension{".csv", info::describe_cloud},
    Extension{".asc", info::describe_cloud},         Extension{".pts", info::describe_cloud},
    Extension{".stl", info::describe_mesh},          Extension{".glb", info::describe_mesh},
    Extension{".gltf", info::describe_mesh},         Extension{".dae", info::describe_mesh},
    Extension{".off", info::describe_mesh},          Extension{".tif", info::describe_raster},
    Extension{".tiff", info::describe_raster},       Extension{".gpkg", info::describe_vector},
    Extension{".geojson", info::describe_vector},    Extension{".shp", info::describe_vector},
    Extension{".jpg", info::describe_image},         Extension{".jpeg", info::describe_image},
    Extension{".png", info::describe_image},         Extension{".yaml", info::describe_ros_map},
    Extension{".json", info::describe_json},
};

// Folders, by a file that stands in them.
struct Folder {
  std::string_view holds;
  info::Describe describe;
};
constexpr std::array kFolders = {
    Folder{"survey.json", info::describe_survey},
    Folder{"cameras.bin", info::describe_colmap},
    Folder{"cameras.txt", info::describe_colmap},
    Folder{"run.json", info::describe_run},
};

constexpr std::string_view kKinds =
    "clouds (LAS, PLY, PCD, OBJ, XYZ, CSV), meshes (PLY, OBJ, STL, GLB, glTF, DAE, OFF), rasters (GeoTIFF), layers "
    "(GeoPackage, GeoJSON, Shapefile), photographs (JPEG, PNG), ROS maps (YAML), JSON; folders with survey.json, "
    "run.json or a COLMAP model";

info::Describe recognise(const fs::path& path) {
  if (fs::is_directory(path)) {
    for (const auto& folder : kFolders)
      if (fs::exists(path / folder.holds)) return folder.describe;
    throw base::Error(base::ErrorCode::invalid_input, "a folder of no kind that cairn knows")
        .file(path.string())
        .allowed("a folder with survey.json, run.json, or cameras.txt or cameras.bin (COLMAP)");
  }
  const io::InputFile file(path);
  std::vector<std::byte> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kHeadBytes)));
  file.read_at(0, bytes);
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (head.empty()) throw io::bad_bytes(file.name(), 0, "the file is empty").allowed(kKinds);
  for (const auto& magic : kMagics)
    if (head.starts_with(magic.start)) return magic.describe;
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const auto& row : kExtensions)
    if (extension == row.extension) return row.describe;
  throw io::bad_bytes(file.name(), 0, "not a file that cairn knows")
      .found("extension '" + extension + "'")
      .allowed(kKinds);
}

}  // namespace

io::Json file_info(const fs::path& path, const InfoOptions& options) {
  try {
    io::Json json = recognise(path)(path, options);
    if (json.find("warnings") == nullptr) json.set("warnings", io::Json::array());
    return json;
  } catch (base::Error& error) {
    error.default_file(path.string());
    throw;
  }
}

namespace info {

io::Json begin(const fs::path& path, std::string_view kind, std::string_view format) {
  io::Json json = io::Json::object({{"path", path.string()}, {"kind", kind}, {"format", format}});
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored))
    json.set("file_bytes", static_cast<std::int64_t>(fs::file_size(path, ignored)));
  return json;
}

io::Json to_json(const geometry::Box3& box) {
  if (box.empty()) return {};
  return io::Json::object({{"min", io::Json(box.min)}, {"max", io::Json(box.max)}});
}

io::Json crs_json(const std::string& crs, std::vector<std::string>& warnings) {
  if (crs.empty()) return {};
  io::Json json = io::Json::object({{"text", crs}});
  try {
    const geodesy::CrsInfo facts = geodesy::describe_crs(crs);
    json.set("name", facts.name);
    json.set("authority_code", facts.authority_code.empty() ? io::Json() : io::Json(facts.authority_code));
    json.set("geographic", facts.geographic);
    json.set("horizontal_unit_m", facts.geographic ? io::Json() : io::Json(facts.horizontal_unit_m));
    json.set("vertical_unit_m", facts.has_vertical ? io::Json(facts.vertical_unit_m) : io::Json());
  } catch (const base::Error& error) {
    warnings.push_back("the coordinate reference system cannot be used: " + error.message());
  }
  return json;
}

}  // namespace info
}  // namespace cairn::pipeline
