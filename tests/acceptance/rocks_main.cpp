// acceptance_rocks [--results FILE] [--first SEED] [--seeds N] [--family F] [--held-out] [--hiding H] [--spacing M]
//                  [--unguided | --true-labels] [--resamplings N] [--scenes N] [--keep DIR] [--tables-only]
// Simulated rocks through segment, surface and fragility in one process. One JSON line a rock is appended to the
// results; lines that are there already are not computed again. Prints the tables as Markdown.
//   --seeds N        rocks of the families that are not held out
//   --held-out       the held-out family instead, under the same seeds
//   --resamplings N  each seed sampled N times more
//   --cloud FILE     that cloud alone, its line to stdout; --truth names a truth.json whose cylinders are targets
//   --scenes N       clouds of many rocks, unguided, instead of single rocks
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "rock_run.hpp"
#include "rock_table.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::base::Error;
using cairn::base::ErrorCode;
using cairn::io::Json;
using cairn::testing::Hiding;

struct Settings {
  fs::path results = "rocks.jsonl", cloud, truth;
  std::int64_t first = 1, seeds = 200, resamplings = 0, scenes = 0;
  cairn::acceptance::RockRunOptions run;
  cairn::testing::RockSceneOptions scene;
  bool tables_only = false;
};

Hiding hiding_from(const std::string& name) {
  const std::vector<std::string> names = {"drawn", "none", "brush", "sector", "absent"};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return static_cast<Hiding>(i);
  throw Error(ErrorCode::invalid_argument, "unknown hiding").found(name).allowed("drawn, none, brush, sector, absent");
}

bool flag(Settings& s, const std::string& name) {
  if (name == "--tables-only") s.tables_only = true;
  else if (name == "--unguided") s.run.guided = false;
  else if (name == "--true-labels") s.run.true_labels = true;
  else if (name == "--held-out") s.run.scan.family = s.scene.family = cairn::testing::kHeldOutFamily;
  else return false;
  return true;
}

Settings parse(int argc, const char* const* argv) {
  Settings s;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (flag(s, name)) continue;
    if (i + 1 == argc) throw Error(ErrorCode::invalid_argument, "option without a value").found(name);
    const std::string value = argv[++i];
    const auto count = cairn::base::parse_integer(value).value_or(1);
    if (name == "--results") s.results = value;
    else if (name == "--first") s.first = count;
    else if (name == "--seeds") s.seeds = count;
    else if (name == "--resamplings") s.resamplings = count;
    else if (name == "--scenes") s.scenes = count;
    else if (name == "--family") s.run.scan.family = s.scene.family = value;
    else if (name == "--hiding") s.run.scan.hiding = hiding_from(value);
    else if (name == "--spacing") s.run.scan.spacing_m = cairn::base::parse_real(value).value_or(0.01);
    else if (name == "--cloud") s.cloud = value;
    else if (name == "--truth") s.truth = value;
    else if (name == "--keep") s.run.keep = value;
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

// Kind, family asked for ("" = drawn), seed, sampling.
using Key = std::tuple<std::string, std::string, std::int64_t, std::int64_t>;

Key key_of(const Json& line) {
  const Json* sampling = line.find("sampling");
  return {line.at("kind").as_string(), line.at("asked_family").as_string(), line.at("seed").as_integer(),
          sampling == nullptr ? 0 : sampling->as_integer()};
}

int run(const Settings& s) {
  if (!s.cloud.empty()) {
    cairn::base::RunContext ctx;
    std::printf("%s\n", cairn::acceptance::run_cloud(s.cloud, s.truth, s.run.keep, ctx).dump().c_str());
    return 0;
  }
  auto lines = read_lines(s.results);
  std::set<Key> done;
  for (const auto& line : lines) done.insert(key_of(line));
  std::ofstream out(s.results, std::ios::app);
  const auto keep = [&](Json line) {
    line.set("asked_family", s.run.scan.family);
    out << line.dump(0) << '\n' << std::flush;
    if (!out) throw Error(ErrorCode::resource_exhausted, "cannot write results");
    std::fprintf(stderr, "%s, seed %lld %s\n", line.at("kind").as_string().c_str(),
                 static_cast<long long>(line.at("seed").as_integer()), line.at("failed").as_string().c_str());
    lines.push_back(std::move(line));
  };
  const std::int64_t count = s.tables_only ? 0 : s.scenes > 0 ? s.scenes : s.seeds;
  for (std::int64_t seed = s.first; seed < s.first + count; ++seed)
    for (std::int64_t sampling = 0; sampling <= (s.scenes > 0 ? 0 : s.resamplings); ++sampling) {
      const std::string kind = s.scenes > 0 ? "scene" : "rock";
      if (done.contains({kind, s.run.scan.family, seed, sampling})) continue;
      cairn::base::RunContext ctx;
      auto options = s.run;
      options.scan.sampling = static_cast<std::uint64_t>(sampling);
      const auto number = static_cast<std::uint64_t>(seed);
      keep(s.scenes > 0 ? cairn::acceptance::run_scene(number, s.scene, s.run.keep, ctx)
                        : cairn::acceptance::run_rock(number, options, ctx));
    }
  std::printf("%s", cairn::acceptance::rock_tables(lines).c_str());
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
