// acceptance_experiment_2 [--scene FILE] [--results FILE] [--first SEED] [--seeds N] [--grades scene,rtk,gps]
//                         [--boxes tracks|detections] [--modes robust,paper,paper_coasted] [--tables-only]
// Paper A's Experiment II, many seeds. One JSON line a seed and grade is appended to the results; lines that are there
// already are not computed again. Prints the pooled tables as Markdown.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "experiment_run.hpp"
#include "experiment_table.hpp"
#include "pipeline/scene_json.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::io::Json;

struct Settings {
  fs::path scene = fs::path(CAIRN_SOURCE_DIR) / "samples/scenes/experiment_2.json";
  fs::path results = "experiment_2.jsonl";
  std::int64_t first = 1, seeds = 100;
  std::vector<std::string> grades{"scene"};
  cairn::acceptance::RunOptions run;
  bool tables_only = false;
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

Settings parse(int argc, const char* const* argv) {
  using cairn::base::Error;
  using cairn::base::ErrorCode;
  Settings s;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--tables-only") {
      s.tables_only = true;
      continue;
    }
    if (i + 1 == argc) throw Error(ErrorCode::invalid_argument, "option without a value").found(name);
    const std::string value = argv[++i];
    if (name == "--scene") s.scene = value;
    else if (name == "--results") s.results = value;
    else if (name == "--first") s.first = cairn::base::parse_integer(value).value_or(1);
    else if (name == "--seeds") s.seeds = cairn::base::parse_integer(value).value_or(100);
    else if (name == "--grades") s.grades = split(value);
    else if (name == "--boxes") s.run.tracks = value == "tracks";
    else if (name == "--modes") s.run.modes = split(value);
    else throw Error(ErrorCode::invalid_argument, "unknown option").found(name);
  }
  return s;
}

// A line that was cut off by an interruption is dropped and computed again.
std::vector<Json> read_lines(const fs::path& path) {
  std::vector<Json> lines;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) try {
      if (!line.empty()) lines.push_back(cairn::io::parse_json(line, path.string()));
    } catch (const cairn::base::Error&) {
      std::fprintf(stderr, "%s: a broken line is left out\n", path.c_str());
    }
  return lines;
}

// experiment_2.json for `scene`; the same flown with other poses lies beside it, as experiment_2_rtk.json.
fs::path scene_of(const fs::path& scene, const std::string& grade) {
  if (grade == "scene") return scene;
  return scene.parent_path() / (scene.stem().string() + "_" + grade + scene.extension().string());
}

int run(const Settings& settings) {
  auto lines = read_lines(settings.results);
  std::set<std::pair<std::string, std::int64_t>> done;
  for (const auto& line : lines) done.emplace(line.at("grade").as_string(), line.at("seed").as_integer());
  if (!settings.tables_only) {
    std::map<std::string, cairn::simulation::Scene> scenes;
    for (const auto& grade : settings.grades)
      scenes.emplace(grade, cairn::pipeline::read_scene(scene_of(settings.scene, grade)));
    std::ofstream out(settings.results, std::ios::app);
    for (std::int64_t seed = settings.first; seed < settings.first + settings.seeds; ++seed)
      for (const auto& grade : settings.grades) {
        if (done.contains({grade, seed})) continue;
        auto options = settings.run;
        options.grade = grade;
        cairn::base::RunContext ctx;
        lines.push_back(cairn::acceptance::run_seed(scenes.at(grade), static_cast<std::uint64_t>(seed), options, ctx));
        out << lines.back().dump(0) << '\n' << std::flush;
        if (!out) throw cairn::base::Error(cairn::base::ErrorCode::resource_exhausted, "cannot write results");
        std::fprintf(stderr, "%s, seed %lld\n", grade.c_str(), static_cast<long long>(seed));
      }
  }
  for (const auto& grade : settings.grades) std::printf("%s\n", cairn::acceptance::pooled_tables(lines, grade).c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(parse(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
