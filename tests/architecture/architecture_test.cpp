// Layers and walls, read from the sources: an include goes strictly down or stays in its module, and
// third-party headers appear behind their module's wall only.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "support/data.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::source_dir;

struct Layer {
  int level = 0;
  std::vector<std::string> walled;
};

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);)
    if (!part.empty()) parts.push_back(part);
  return parts;
}

std::map<std::string, Layer> read_layers() {
  std::map<std::string, Layer> layers;
  std::ifstream file(source_dir() / "tests/architecture/layers.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    const auto fields = split(line, ',');
    layers[fields.at(1)] = {std::stoi(fields.at(0)),
                            fields.size() > 2 ? split(fields[2], '|') : std::vector<std::string>{}};
  }
  return layers;
}

struct Include {
  fs::path file;
  std::string module;
  std::string target;  // text between the brackets or quotes
  bool quoted = false;
};

std::vector<Include> includes_below(const fs::path& root, bool by_folder) {
  std::vector<Include> includes;
  const std::regex pattern(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"])re");
  for (auto it = fs::recursive_directory_iterator(root); it != fs::recursive_directory_iterator(); ++it) {
    const auto& entry = *it;
    if (entry.path().filename() == "node_modules") it.disable_recursion_pending();
    const auto extension = entry.path().extension();
    if (extension != ".hpp" && extension != ".cpp") continue;
    const std::string module =
        by_folder ? fs::relative(entry.path(), root).begin()->string() : root.filename().string();
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      std::smatch match;
      if (std::regex_search(line, match, pattern))
        includes.push_back({fs::relative(entry.path(), source_dir()), module, match[2], match[1] == "\""});
    }
  }
  return includes;
}

std::vector<Include> all_includes() {
  auto includes = includes_below(source_dir() / "lib", true);
  const auto tools = includes_below(source_dir() / "tools", false);
  includes.insert(includes.end(), tools.begin(), tools.end());
  return includes;
}

// Third-party header roots that must stand behind a wall, whoever owns them.
const std::vector<std::string> kHeavy = {"pcl/",           "CGAL/",    "opencv2/", "gdal",   "ogr",  "cpl_",
                                         "embree3/",       "assimp/",  "ceres/",   "exiv2/", "tbb/", "nanoflann",
                                         "nlohmann/",      "pugixml",  "openssl/", "proj.h", "CLI/", "spdlog/",
                                         "GeographicLib/", "btBullet", "Eigen/"};

bool starts_with_any(const std::string& text, const std::vector<std::string>& prefixes) {
  for (const auto& prefix : prefixes)
    if (text.starts_with(prefix)) return true;
  return false;
}

TEST(Architecture, IncludesGoDown) {
  const auto layers = read_layers();
  const auto includes = all_includes();
  ASSERT_GT(includes.size(), 100U);
  for (const auto& include : includes) {
    if (!include.quoted) continue;
    const auto slash = include.target.find('/');
    ASSERT_NE(slash, std::string::npos) << include.file << " includes \"" << include.target << "\" without its module";
    const std::string to = include.target.substr(0, slash);
    ASSERT_TRUE(layers.contains(include.module)) << include.module << " has no layer";
    ASSERT_TRUE(layers.contains(to)) << include.file << " includes unknown module " << to;
    if (to == include.module) continue;
    EXPECT_LT(layers.at(to).level, layers.at(include.module).level)
        << include.file << " includes \"" << include.target << "\": upwards or sideways";
  }
}

TEST(Architecture, HeavyHeadersStayBehindTheirWalls) {
  for (const auto& include : all_includes()) {
    if (include.quoted || !starts_with_any(include.target, kHeavy)) continue;
    // Eigen is public by decision; everything else of it belongs in sources.
    if (include.target == "Eigen/Core") continue;
    if (include.target.starts_with("Eigen/")) {
      EXPECT_EQ(include.file.extension(), ".cpp") << include.file << " includes " << include.target;
      continue;
    }
    EXPECT_EQ(include.file.parent_path().filename(), "adapters")
        << include.file << " includes <" << include.target << "> outside adapters/";
    EXPECT_EQ(include.file.extension(), ".cpp") << include.file;
  }
}

TEST(Architecture, NoCatchAllFiles) {
  for (auto it = fs::recursive_directory_iterator(source_dir() / "lib"); it != fs::recursive_directory_iterator();
       ++it) {
    const auto& entry = *it;
    if (entry.path().filename() == "node_modules") {
      it.disable_recursion_pending();
      continue;
    }
    EXPECT_THAT(entry.path().stem().string(),
                testing::Not(testing::AnyOf("utils", "util", "common", "misc", "helpers", "helper", "types")))
        << entry.path();
  }
}

TEST(Architecture, EveryModuleStandsInTheTable) {
  const auto layers = read_layers();
  for (const auto& entry : fs::directory_iterator(source_dir() / "lib"))
    if (entry.is_directory()) {
      EXPECT_TRUE(layers.contains(entry.path().filename().string())) << entry.path();
    }
}

TEST(Architecture, TestsMirrorTheLibrary) {
  for (const auto& entry : fs::recursive_directory_iterator(source_dir() / "tests")) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".cpp" || name.ends_with("_test.cpp")) continue;
    const fs::path relative = fs::relative(entry.path(), source_dir() / "tests");
    EXPECT_THAT(relative.begin()->string(), testing::AnyOf("support", "bench", "fuzz", "data", "acceptance"))
        << relative << " is neither a test (_test.cpp) nor support";
  }
}

}  // namespace
