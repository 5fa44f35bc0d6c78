// acceptance_ground [--results FILE] [--first SEED] [--seeds N] [--scenes football_field,park]
//                   [--variants aerial,no_map,outage_10] [--tables-only]
// Paper B's demonstrations in closed loop, many seeds. One JSON line a run is appended to the results; lines that are
// there already are not computed again. Prints the table as Markdown.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "ground_case.hpp"
#include "pipeline/scene_json.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::base::Error;
using cairn::base::ErrorCode;
using cairn::io::Json;

struct Settings {
  fs::path folder = fs::path(CAIRN_SOURCE_DIR) / "samples/scenes", results = "ground.jsonl";
  std::int64_t first = 1, seeds = 50;
  std::vector<std::string> scenes{"football_field", "park"}, variants{"aerial", "no_map", "outage_10"};
  bool tables_only = false;
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

Settings parse(int argc, const char* const* argv) {
  Settings s;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--tables-only") {
      s.tables_only = true;
      continue;
    }
    if (i + 1 == argc) throw Error(ErrorCode::invalid_argument, "option without a value").found(name);
    const std::string value = argv[++i];
    if (name == "--results") s.results = value;
    else if (name == "--first") s.first = cairn::base::parse_integer(value).value_or(1);
    else if (name == "--seeds") s.seeds = cairn::base::parse_integer(value).value_or(50);
    else if (name == "--scenes") s.scenes = split(value);
    else if (name == "--variants") s.variants = split(value);
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
    } catch (const Error&) {
      std::fprintf(stderr, "%s: a broken line is left out\n", path.c_str());
    }
  return lines;
}

int run(const Settings& settings) {
  auto lines = read_lines(settings.results);
  std::set<std::tuple<std::string, std::string, std::int64_t>> done;
  for (const auto& line : lines)
    done.emplace(line.at("scene").as_string(), line.at("variant").as_string(), line.at("seed").as_integer());
  if (!settings.tables_only) {
    std::ofstream out(settings.results, std::ios::app);
    cairn::base::RunContext ctx;
    for (const auto& name : settings.scenes) {
      const auto scene = cairn::pipeline::read_scene(settings.folder / (name + ".json"));
      const cairn::simulation::DriveRehearsal rehearsal(scene, ctx);
      for (std::int64_t seed = settings.first; seed < settings.first + settings.seeds; ++seed)
        for (const auto& variant : settings.variants) {
          if (done.count({name, variant, seed}) != 0) continue;
          lines.push_back(
              cairn::acceptance::ground_case(rehearsal, name, variant, static_cast<std::uint64_t>(seed), ctx));
          out << lines.back().dump(0) << std::endl;
        }
    }
  }
  std::fputs(cairn::acceptance::ground_table(lines).c_str(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(parse(argc, argv));
  } catch (const Error& error) {
    std::fprintf(stderr, "acceptance_ground: %s %s %s\n", error.message().c_str(), error.record().c_str(),
                 error.found().c_str());
    return 1;
  }
}
