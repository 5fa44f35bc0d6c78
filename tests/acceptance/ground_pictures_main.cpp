// ground_pictures demos FOLDER [--seed N]
// ground_pictures site SURVEY PRODUCTS COSTMAP.tif ROUTE.json FILE.svg [--title TEXT]
// The figures of docs/science/ground.md: both demonstrations with and without aerial mapping; a surveyed site's
// photographs with obstacles, costmap and route.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"
#include "io/obstacles_json.hpp"
#include "io/raster.hpp"
#include "pipeline/drive_stage.hpp"
#include "pipeline/ground_figures.hpp"
#include "pipeline/scene_json.hpp"
#include "plan_picture.hpp"
#include "report/drive_figure.hpp"

namespace {

namespace fs = std::filesystem;
using namespace cairn;
using geometry::Vec2;

constexpr double kSetPeriod_s = 0.25;  // of the projector
constexpr double kPhotoCell_m = 0.15;

void periods(const pipeline::GroundRecord& record, const std::string& title, const fs::path& file) {
  std::vector<double> times, values;
  for (std::size_t i = 1; i < record.packets.size(); ++i) {
    times.push_back(1e-9 * static_cast<double>(record.packets[i].arrival_time_ns));
    values.push_back(times.back() - 1e-9 * static_cast<double>(record.packets[i - 1].arrival_time_ns));
  }
  base::write_file(file, report::update_periods_svg(title, times, values, kSetPeriod_s));
}

void demos(const fs::path& folder, std::uint64_t seed) {
  base::RunContext ctx;
  for (const auto& [name, title] : {std::pair(std::string("football_field"), std::string("Football field")),
                                    std::pair(std::string("park"), std::string("Park"))}) {
    const auto scene = pipeline::read_scene(fs::path(CAIRN_SOURCE_DIR) / "samples/scenes" / (name + ".json"));
    const simulation::DriveRehearsal rehearsal(scene, ctx);
    for (const bool aerial : {true, false}) {
      pipeline::GroundRunOptions options;
      options.aerial_map = aerial;
      const auto record = pipeline::run_ground(rehearsal, options, seed, ctx);
      const std::string with = aerial ? "with aerial mapping" : "without aerial mapping";
      const std::string stem = "ground_" + name + (aerial ? "_aerial" : "_no_map");
      base::write_file(folder / (stem + ".svg"),
                       pipeline::drive_svg(rehearsal, record, record.snapshots.size(), title + ", " + with));
      // The map at the decision: the first one with the aircraft's obstacles, the last surprise without.
      const std::size_t last = record.snapshots.size() - 1;
      const std::size_t shown = aerial || last < 2 ? 0 : last - 1;
      const auto& snapshot = record.snapshots[shown];
      base::write_file(folder / (stem + "_costmap.svg"),
                       pipeline::drive_svg(rehearsal, record, shown,
                                           title + ", " + with + ": costmap at " +
                                               base::to_fixed(1e-9 * static_cast<double>(snapshot.time_ns), 1) +
                                               " s (" + snapshot.label + ")"));
      if (aerial) periods(record, title + ", update period", folder / ("ground_" + name + "_periods.svg"));
      std::printf("%s %s: %.1f m\n", name.c_str(), with.c_str(), record.path_m);
    }
  }
}

void site(const fs::path& survey, const fs::path& products, const fs::path& costmap, const fs::path& route,
          const fs::path& file, const std::string& title) {
  const auto obstacles = io::read_obstacles(products / "obstacles.json");
  const auto raster = io::read_raster(costmap);
  report::DriveFigure figure;
  figure.title = title;
  figure.cost = std::get<geometry::Grid<std::uint8_t>>(raster.bands.at(0).values);
  figure.cost_opacity = 0.5;
  const auto picture = acceptance::plan_picture(survey, products / "surface.tif", kPhotoCell_m);
  const auto& g = picture.geometry;
  figure.background = {{g.west, g.south()}, {g.east(), g.north}, "jpeg", picture.jpeg};
  for (const auto& o : obstacles.obstacles) {
    geometry::Ring ring;
    for (int i = 0; i < 24; ++i) {
      const double a = 2.0 * 3.14159265358979 * i / 24.0, r = std::max(0.3, 0.5 * o.width_m);
      ring.emplace_back(o.position.x() + r * std::cos(a), o.position.y() + r * std::sin(a));
    }
    const bool ignored = o.kind == survey::ObstacleKind::ignored;
    const std::string colour = ignored ? "#00e08a" : o.object_class == "car" ? "#ff4d4d" : "#ffb000";
    figure.outlines.push_back({ring, "none", colour});
  }
  const auto json = io::read_json(route);
  report::DriveTrack track{"route, " + base::to_fixed(json.at("length_m").as_real(), 1) + " m", "#0072b2", false, {}};
  for (const auto& p : json.at("path_m").as_array())
    track.points.emplace_back(p.as_array()[0].as_real(), p.as_array()[1].as_real());
  figure.marks = {{track.points.front(), "start"}, {track.points.back(), "goal"}};
  figure.tracks.push_back(std::move(track));
  base::write_file(file, report::drive_figure_svg(figure));
}

int run(const std::vector<std::string>& arguments) {
  std::vector<std::string> words;
  std::string title = "Obstacles, costmap and route";
  std::uint64_t seed = 1;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--seed" && i + 1 < arguments.size())
      seed = static_cast<std::uint64_t>(base::parse_integer(arguments[++i]).value_or(1));
    else if (arguments[i] == "--title" && i + 1 < arguments.size()) title = arguments[++i];
    else words.push_back(arguments[i]);
  }
  if (words.size() == 2 && words[0] == "demos") demos(words[1], seed);
  else if (words.size() == 6 && words[0] == "site") site(words[1], words[2], words[3], words[4], words[5], title);
  else throw base::Error(base::ErrorCode::invalid_argument, "see the head of ground_pictures_main.cpp");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const base::Error& error) {
    std::fprintf(stderr, "ground_pictures: %s %s %s\n", error.message().c_str(), error.file().c_str(),
                 error.found().c_str());
    return 1;
  }
}
