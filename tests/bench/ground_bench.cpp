// The ground filter on boulders of known labels and on the ISPRS samples, beside PCL's.
// usage: bench_ground boulders FOLDER [pcl] [option=value ...]   FOLDER: terrain_xyz.f64, terrain_label.u8
//        bench_ground isprs FOLDER [pcl] [option=value ...]      FOLDER: samp11-utm.pcd, samp11-utm-ground.pcd, ...
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "bench/cpu_clock.hpp"
#include "bench/ground_bench_pcl.hpp"
#include "io/pcd.hpp"
#include "segmentation/candidates.hpp"
#include "segmentation/ground_filter.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::geometry::Vec3;
using cairn::segmentation::GroundFilterOptions;
using cairn::segmentation::PointClass;

struct Scores {
  double ground_as_object = 0, object_as_ground = 0, ground_right = 0, object_right = 0;

  void add(bool truth_object, bool found_object) {
    (truth_object ? (found_object ? object_right : object_as_ground)
                  : (found_object ? ground_as_object : ground_right)) += 1;
  }
  double all() const { return ground_as_object + object_as_ground + ground_right + object_right; }
  double type1() const { return ground_as_object / (ground_as_object + ground_right); }
  double type2() const { return object_as_ground / (object_as_ground + object_right); }
  double total() const { return (ground_as_object + object_as_ground) / all(); }
  double iou() const { return object_right / (object_right + object_as_ground + ground_as_object); }
  double kappa() const {
    const double n = all(), agree = (ground_right + object_right) / n;
    const double chance = ((ground_right + ground_as_object) * (ground_right + object_as_ground) +
                           (object_right + object_as_ground) * (object_right + ground_as_object)) /
                          (n * n);
    return (agree - chance) / (1.0 - chance);
  }
};

template <typename T>
std::vector<T> read_raw(const fs::path& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) throw std::runtime_error("cannot read " + file.string());
  std::vector<T> values(static_cast<std::size_t>(in.tellg()) / sizeof(T));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
  return values;
}

std::vector<std::uint8_t> objects(const std::vector<Vec3>& points, const GroundFilterOptions& options) {
  cairn::base::RunContext ctx;
  const auto result = cairn::segmentation::filter_ground(points, options, ctx);
  std::vector<std::uint8_t> object(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) object[i] = result.classes[i] != PointClass::ground;
  return object;
}

Scores score(const std::vector<std::uint8_t>& truth, const std::vector<std::uint8_t>& found) {
  Scores s;
  for (std::size_t i = 0; i < truth.size(); ++i) s.add(truth[i] != 0, found[i] != 0);
  return s;
}

void print(const char* name, const Scores& s, double cpu) {
  std::printf("%-24s IoU %.4f  type I %6.2f %%  type II %6.2f %%  total %6.2f %%  kappa %6.2f %%  %.3f CPU s\n", name,
              s.iou(), 100 * s.type1(), 100 * s.type2(), 100 * s.total(), 100 * s.kappa(), cpu);
}

struct PclChoices {
  std::vector<float> cell;
  std::vector<int> max_window;
  std::vector<float> slope, initial_distance, max_distance;
};

// One parameter at a time from `start`, until nothing gets better.
template <typename Value>
cairn::bench::PclGroundOptions tune(cairn::bench::PclGroundOptions best, const PclChoices& choices, Value value) {
  using O = cairn::bench::PclGroundOptions;
  double most = value(best);
  for (bool better = true; better;) {
    better = false;
    const auto attempt = [&](auto member, const auto& values) {
      for (const auto v : values) {
        auto o = best;
        o.*member = v;
        const double reached = value(o);
        if (!(reached > most + 1e-6)) continue;
        most = reached, best = o, better = true;
      }
    };
    attempt(&O::cell, choices.cell);
    attempt(&O::max_window, choices.max_window);
    attempt(&O::exponential, std::vector<bool>{false, true});
    attempt(&O::slope, choices.slope);
    attempt(&O::initial_distance, choices.initial_distance);
    attempt(&O::max_distance, choices.max_distance);
    attempt(&O::base, std::vector<float>{2.0F, 3.0F});
  }
  return best;
}

void print_options(const cairn::bench::PclGroundOptions& o) {
  std::printf("PCL cell %g window %d %s slope %g initial %g max %g\n", static_cast<double>(o.cell), o.max_window,
              o.exponential ? "exponential" : "linear", static_cast<double>(o.slope),
              static_cast<double>(o.initial_distance), static_cast<double>(o.max_distance));
}

int boulders(const fs::path& folder, bool pcl, const GroundFilterOptions& options) {
  const auto points = read_raw<Vec3>(folder / "terrain_xyz.f64");
  const auto truth = read_raw<std::uint8_t>(folder / "terrain_label.u8");
  if (pcl) {
    // Tuned on a corner of this very cloud.
    std::vector<Vec3> corner;
    std::vector<std::uint8_t> corner_truth;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].x() < 25.0 && points[i].y() < 25.0) corner.push_back(points[i]), corner_truth.push_back(truth[i]);
    cairn::bench::PclGroundOptions first;
    first.cell = 0.1F, first.max_window = 30, first.slope = 0.5F, first.initial_distance = 0.05F;
    first.max_distance = 0.3F;
    const auto best = tune(first,
                           {{0.06F, 0.1F, 0.15F, 0.2F, 0.3F},
                            {10, 16, 22, 30, 40},
                            {0.1F, 0.2F, 0.3F, 0.5F, 0.8F, 1.2F},
                            {0.015F, 0.03F, 0.05F, 0.08F, 0.12F},
                            {0.05F, 0.1F, 0.2F, 0.3F, 0.5F}},
                           [&](const cairn::bench::PclGroundOptions& o) {
                             return score(corner_truth, cairn::bench::pcl_objects(corner, o)).iou();
                           });
    print_options(best);
    const double start = cairn::bench::cpu_seconds();
    const auto found = cairn::bench::pcl_objects(points, best);
    print("PCL", score(truth, found), cairn::bench::cpu_seconds() - start);
  }
  const int rounds = 5;
  double cpu = 1e9;
  cairn::base::RunContext ctx;
  for (int i = 0; i < rounds; ++i) {
    const double start = cairn::bench::cpu_seconds();
    const auto result = cairn::segmentation::filter_ground(points, options, ctx);
    cpu = std::min(cpu, cairn::bench::cpu_seconds() - start);
    if (i + 1 < rounds) continue;
    std::vector<std::uint8_t> object(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) object[k] = result.classes[k] != PointClass::ground;
    print(folder.filename().c_str(), score(truth, object), cpu);
    const double before = cairn::bench::cpu_seconds();
    const auto found = cairn::segmentation::find_candidates(points, result, {});
    std::printf("  cell %.3f m, %zu candidates in %.3f CPU s, peak %.0f MB\n", result.surface.height.geometry.cell,
                found.size(), cairn::bench::cpu_seconds() - before, cairn::bench::peak_megabytes());
  }
  return 0;
}

struct Sample {
  std::string name;
  std::vector<Vec3> points;
  std::vector<std::uint8_t> truth;  // 1 object
};

std::vector<Sample> isprs_samples(const fs::path& folder) {
  std::vector<Sample> samples;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with("-utm.pcd")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    Sample sample;
    sample.name = file.filename().string().substr(0, 6);
    sample.points = cairn::io::read_pcd(file).cloud.positions;
    std::multiset<std::array<double, 3>> ground;
    for (const Vec3& p : cairn::io::read_pcd(folder / (sample.name + "-utm-ground.pcd")).cloud.positions)
      ground.insert({p.x(), p.y(), p.z()});
    for (const Vec3& p : sample.points) {
      const auto at = ground.find({p.x(), p.y(), p.z()});
      sample.truth.push_back(at == ground.end() ? 1 : 0);
      if (at != ground.end()) ground.erase(at);
    }
    if (!ground.empty())
      std::printf("%s: %zu ground points are not in the cloud\n", sample.name.c_str(), ground.size());
    samples.push_back(std::move(sample));
  }
  return samples;
}

template <typename Filter>
std::pair<double, double> over_all(const std::vector<Sample>& samples, const char* who, bool each, Filter filter) {
  double total = 0, kappa = 0;
  for (const Sample& sample : samples) {
    const double start = cairn::bench::cpu_seconds();
    const Scores s = score(sample.truth, filter(sample.points));
    if (each) print((std::string(who) + " " + sample.name).c_str(), s, cairn::bench::cpu_seconds() - start);
    total += s.total() / static_cast<double>(samples.size());
    kappa += s.kappa() / static_cast<double>(samples.size());
  }
  return {total, kappa};
}

int isprs(const fs::path& folder, bool pcl, const GroundFilterOptions& options, bool each) {
  const auto samples = isprs_samples(folder);
  if (pcl) {
    // Tuned on these very samples: one parameter at a time, until nothing gets better.
    const auto mean = [&](const cairn::bench::PclGroundOptions& o) {
      return over_all(samples, "PCL", false, [&](const auto& p) { return cairn::bench::pcl_objects(p, o); });
    };
    const PclChoices choices{{0.75F, 1.0F, 1.25F, 1.5F, 2.0F, 2.5F},
                             {8, 11, 14, 17, 20, 24, 28, 33, 40},
                             {0.1F, 0.15F, 0.2F, 0.25F, 0.3F, 0.4F, 0.5F, 0.7F, 1.0F},
                             {0.15F, 0.25F, 0.35F, 0.5F, 0.7F, 1.0F},
                             {0.7F, 1.0F, 1.3F, 1.6F, 2.0F, 2.5F, 3.0F, 4.0F, 6.0F}};
    const auto tuned = [&](auto value) {
      return tune({}, choices, [&](const cairn::bench::PclGroundOptions& o) { return value(mean(o)); });
    };
    const auto best = tuned([](const auto& s) { return -s.first; });
    const auto best_kappa = tuned([](const auto& s) { return s.second; });
    for (const auto& o : {best, best_kappa}) {
      print_options(o);
      const auto [total, kappa] =
          over_all(samples, "PCL", true, [&](const auto& p) { return cairn::bench::pcl_objects(p, o); });
      std::printf("PCL mean: total %.2f %%  kappa %.2f %%\n", 100 * total, 100 * kappa);
    }
  }
  const auto [total, kappa] = over_all(samples, "cairn", each, [&](const auto& p) { return objects(p, options); });
  std::printf("cairn mean: total %.2f %%  kappa %.2f %%\n", 100 * total, 100 * kappa);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::string what = argv[1];
  GroundFilterOptions options;
  bool pcl = false, each = true;
  for (int i = 3; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto equals = argument.find('=');
    if (argument == "pcl") pcl = true;
    else if (argument == "mean") each = false;
    else if (equals != std::string::npos)
      cairn::base::set_option(cairn::base::bind_options(options), argument.substr(0, equals),
                              argument.substr(equals + 1));
  }
  return what == "isprs" ? isprs(argv[2], pcl, options, each) : boulders(argv[2], pcl, options);
}
