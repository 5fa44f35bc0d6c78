// Bundle adjustment of a BAL problem: Ceres with our analytic Jacobians, beside Ceres with automatic derivatives (the
// cost function of its own example). Row 11 of the table of goals: 50 cameras, 209 000 observations, <= 2 CPU s.
//   bench_bundle ours|automatic|both [BAL file | cameras points]
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <glog/logging.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "bench/cpu_clock.hpp"
#include "support/bal.hpp"

namespace {

using namespace cairn;

// u = f (1 + k1 r^2 + k2 r^4) p.xy / p.z with p = R X + t, camera axes as ours.
struct Automatic {
  double u, v;
  template <typename T>
  bool operator()(const T* camera, const T* point, T* residuals) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera, point, p);
    p[0] += camera[3];
    p[1] += camera[4];
    p[2] += camera[5];
    const T x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y;
    const T distortion = 1.0 + r2 * (camera[7] + camera[8] * r2);
    residuals[0] = camera[6] * distortion * x - u;
    residuals[1] = camera[6] * distortion * y - v;
    return true;
  }
};

void report(const char* what, double cpu_s, double before, double after, long iterations, const std::string& message) {
  std::printf("%-10s cpu %.2f s, cost %.4f -> %.4f, %ld iterations, peak %.0f MB, %s\n", what, cpu_s, before, after,
              iterations, bench::peak_megabytes(), message.c_str());
}

double run_ours(adjustment::BundleSystem system) {
  base::RunContext ctx;
  const double start = bench::cpu_seconds();
  const auto round = adjustment::solve_bundle(system, {50, 1e-6}, ctx);
  const double cpu = bench::cpu_seconds() - start;
  report("ours", cpu, round.cost_before, round.cost_after, round.iterations, round.termination);
  return round.cost_after;
}

double run_automatic(const adjustment::BundleSystem& system) {
  FLAGS_minloglevel = google::GLOG_FATAL;
  std::vector<std::array<double, 9>> cameras;
  for (std::size_t i = 0; i < system.poses.size(); ++i) {
    const auto T = system.poses[i].inverse();
    const auto w = adjustment::log_rotation(T.rotation);
    const auto& c = system.cameras[i];
    cameras.push_back(
        {w.x(), w.y(), w.z(), T.translation.x(), T.translation.y(), T.translation.z(), c.fx_px, c.k1, c.k2});
  }
  auto points = system.points;
  const double start = bench::cpu_seconds();
  ceres::Problem problem;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const auto& o : system.observations)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Automatic, 2, 9, 3>(new Automatic{o.pixel.x(), o.pixel.y()}), nullptr,
        cameras[static_cast<std::size_t>(o.frame)].data(), points[static_cast<std::size_t>(o.point)].data());
  for (auto& p : points) ordering->AddElementToGroup(p.data(), 0);
  for (auto& c : cameras) ordering->AddElementToGroup(c.data(), 1);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.linear_solver_ordering = ordering;
  options.max_num_iterations = 50;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  report("automatic", bench::cpu_seconds() - start, summary.initial_cost, summary.final_cost,
         static_cast<long>(summary.iterations.size()) - 1, summary.message);
  return summary.final_cost;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string which = argc > 1 ? argv[1] : "both";
  const auto count = [&](int i, std::size_t otherwise) {
    return argc > i ? static_cast<std::size_t>(std::strtoull(argv[i], nullptr, 10)) : otherwise;
  };
  const auto system = argc == 3 ? testing::read_bal(argv[2]) : testing::made_up_bal(count(2, 50), count(3, 20000));
  std::printf("%zu cameras, %zu points, %zu observations\n", system.poses.size(), system.points.size(),
              system.observations.size());
  if (which != "automatic") static_cast<void>(run_ours(system));
  if (which != "ours") static_cast<void>(run_automatic(system));
  return 0;
}
