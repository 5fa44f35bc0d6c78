// The whole localisation of a long video: 200 things on 80 m x 80 m, about 50 of them in each frame from 40 m, lanes
// flown again and again at 1 m/s and 5 Hz. Goal: 10 000 frames in 60 s on two cores, growing linearly.
//   bench_localisation_video FRAMES [tracks|detections] [robust|paper]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/random.hpp"
#include "cpu_clock.hpp"
#include "localisation/locate.hpp"
#include "support/nadir_survey.hpp"

namespace {

using namespace cairn;

constexpr int kThings = 200;
constexpr double kSide_m = 80.0, kLane_m = 13.0, kStep_m = 0.2;

geometry::Vec3 position(int frame) {
  const double along = kStep_m * frame;
  const int lane = static_cast<int>(along / kSide_m), lanes = 7;
  const double u = along - kSide_m * lane;
  return {lane % 2 == 0 ? u : kSide_m - u, kLane_m * (lane % lanes) + 1.0, 40.0};
}

}  // namespace

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 2500;
  const bool tracked = argc <= 2 || std::string(argv[2]) == "tracks";
  base::Random random(1, "video bench", 0);
  testing::NadirSurvey s(0);
  std::vector<geometry::Vec3> things;
  for (int i = 0; i < kThings; ++i)
    things.push_back({random.uniform(0.0, kSide_m), random.uniform(0.0, kSide_m), random.uniform(0.2, 1.0)});
  std::vector<int> last_seen(kThings, -100), visit(kThings, 0);
  std::vector<survey::TrackedBox> rows;
  for (int f = 0; f < frames; ++f) {
    survey::Frame frame;
    frame.id = survey::FrameId(f + 1);
    frame.camera = survey::CameraId(1);
    frame.time_ns = static_cast<std::int64_t>(f) * 200'000'000;
    frame.T_world_camera.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    frame.T_world_camera.translation = position(f);
    frame.sigma_xy_m = frame.sigma_z_m = 0.3;
    frame.sigma_rot_deg = 0.3;
    s.survey.frames.push_back(frame);
    const auto add = [&](double u, double v, double half, int thing) {
      const auto jitter = [&] { return 1.5 * random.normal(); };
      s.box(frame.id, {u - half + jitter(), v - half + jitter(), u + half + jitter(), v + half + jitter()}, "boulder");
      if (thing >= 0)
        rows.push_back({survey::TrackId(1000 * visit[static_cast<std::size_t>(thing)] + thing),
                        survey::TrackState::detected, s.survey.detections.back()});
    };
    for (int i = 0; i < kThings; ++i) {
      const auto n = static_cast<std::size_t>(i);
      const geometry::Vec3 p =
          frame.T_world_camera.rotation.transpose() * (things[n] - frame.T_world_camera.translation);
      const double u = 1000.0 * p.x() / p.z() + 500.0, v = 1000.0 * p.y() / p.z() + 500.0, half = 500.0 / p.z();
      if (u < half + 10 || u > 990 - half || v < half + 10 || v > 990 - half) continue;
      if (f - last_seen[n] > 20) ++visit[n];
      last_seen[n] = f;
      if (random.uniform() < 0.15) continue;
      add(u, v, half, i);
    }
    if (!tracked)
      for (int k = 0; k < 2; ++k) add(random.uniform(50, 950), random.uniform(50, 950), 15.0, -1);
  }
  localisation::LocateOptions options;
  options.ground_up_m = 0.0;
  options.height_above_ground_m = 3.0;
  if (argc > 3) options.mode = argv[3];
  base::RunContext ctx;
  const double before = bench::cpu_seconds();
  const auto result = tracked ? localisation::locate(s.survey, localisation::Tracks(rows), options, ctx)
                              : localisation::locate(s.survey, options, ctx);
  std::printf("frames %d, boxes %zu (%.1f a frame): %.2f CPU s; targets %zu, converged %zu\n", frames,
              s.survey.detections.size(), static_cast<double>(s.survey.detections.size()) / frames,
              bench::cpu_seconds() - before, result.targets.size(), result.counts.converged);
}
