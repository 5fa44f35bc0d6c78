#include "io/cloud.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/bytes.hpp"
#include "io/obj.hpp"
#include "io/pcd.hpp"
#include "io/ply.hpp"
#include "io/xyz.hpp"

namespace cairn::io {
namespace {

constexpr std::size_t kHeadBytes = 4096;
constexpr std::string_view kRead = "LAS, PLY, PCD, OBJ, XYZ or CSV";

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

bool has_line(std::string_view head, std::string_view start) {
  for (std::size_t at = head.find(start); at != std::string_view::npos; at = head.find(start, at + 1))
    if (at == 0 || head[at - 1] == '\n') return true;
  return false;
}

}  // namespace

CloudFormat recognise_cloud(const std::filesystem::path& path) {
  const InputFile file(path);
  std::vector<std::byte> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kHeadBytes)));
  file.read_at(0, bytes);
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto refuse = [&](std::string message) { return bad_bytes(file.name(), 0, std::move(message)); };
  if (head.empty()) throw refuse("the file is empty").allowed(kRead);
  if (head.starts_with("LASF")) return CloudFormat::las;
  if (head.starts_with("ply") && head.size() > 3 && static_cast<unsigned char>(head[3]) <= ' ') return CloudFormat::ply;
  if (head.starts_with("# .PCD") || (has_line(head, "FIELDS") && has_line(head, "SIZE"))) return CloudFormat::pcd;
  if (head.starts_with("ASTM-E57"))
    throw refuse("E57 is not read")
        .allowed(kRead)
        .hint("Convert it first, for example with 'pdal translate in.e57 out.las' or CloudCompare");
  const std::string extension = extension_of(path);
  if (extension == ".las" || extension == ".laz") return CloudFormat::las;
  if (extension == ".ply") return CloudFormat::ply;
  if (extension == ".pcd") return CloudFormat::pcd;
  if (extension == ".obj") return CloudFormat::obj;
  for (const std::string_view text : {".xyz", ".txt", ".csv", ".asc", ".pts"})
    if (extension == text) return CloudFormat::xyz;
  if (looks_like_xyz(head)) return CloudFormat::xyz;
  throw refuse("not a point cloud that cairn reads").found("extension '" + extension + "'").allowed(kRead);
}

CloudFile read_cloud(const std::filesystem::path& path, const LasColumns& columns) {
  CloudFile file;
  CloudData& data = file;
  switch (recognise_cloud(path)) {
    case CloudFormat::las: {
      LasCloud las = read_las(path, columns);
      file.cloud = std::move(las.cloud);
      file.facts = std::move(las.facts);
      file.las = std::move(las.metadata);
      break;
    }
    case CloudFormat::ply: data = read_ply_cloud(path); break;
    case CloudFormat::pcd: data = read_pcd(path); break;
    case CloudFormat::obj: data = read_obj_cloud(path); break;
    case CloudFormat::xyz: data = read_xyz(path); break;
  }
  return file;
}

void write_cloud(const std::filesystem::path& path, const geometry::PointCloud& cloud,
                 const CloudWriteOptions& options) {
  const std::string extension = extension_of(path);
  if (extension == ".las") {
    LasWriteOptions las;
    las.crs = options.crs;
    las.crs_wkt = options.crs_wkt;
    las.source = options.las;
    return write_las(path, cloud, las);
  }
  if (extension == ".ply") return write_ply(path, cloud, PlyWriteOptions{options.crs, {}});
  if (extension == ".pcd") return write_pcd(path, cloud);
  if (extension == ".xyz" || extension == ".txt" || extension == ".csv") return write_xyz(path, cloud);
  throw base::Error(base::ErrorCode::invalid_argument, "cannot write a cloud in this format")
      .file(path.string())
      .found("extension '" + extension + "'")
      .allowed(".las, .ply, .pcd, .xyz, .txt, .csv");
}

}  // namespace cairn::io
