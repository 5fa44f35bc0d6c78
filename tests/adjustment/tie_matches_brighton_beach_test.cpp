// Tie points from the photographs' own metadata: GPS errors of a metre, yaw off by degrees, six frames turned.
#include <gmock/gmock.h>

#include <set>

#include "adjustment/evidence_ties.hpp"
#include "adjustment/robust.hpp"
#include "adjustment/rough_alignment.hpp"
#include "adjustment/tie_matches.hpp"
#include "camera/projection.hpp"
#include "io/image.hpp"
#include "support/brighton_beach.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec2;

geometry::GreyImage load(const survey::Frame& frame) {
  return io::read_grey_image(testing::sample("brighton_beach/images_1600/" + frame.image));
}

const MatchedTies& matched() {
  static const MatchedTies result = [] {
    base::RunContext ctx;
    return match_ties(testing::brighton_beach_exif(), load, {}, ctx);
  }();
  return result;
}

// Residuals [px] of the ties when they are triangulated and reprojected with COLMAP's poses.
struct AgainstColmap {
  std::vector<double> residuals_px;
  std::size_t lost = 0;  // observations of ties that COLMAP's poses put nowhere
};

AgainstColmap against_colmap(const MatchedTies& ties) {
  const auto colmap = testing::brighton_beach_colmap();
  std::vector<RoughCamera> cameras;
  for (const auto& frame : colmap.frames) cameras.push_back({frame.T_world_camera});
  AgainstColmap result;
  for (const auto& tie : ties.ties) {
    std::vector<TrackRay> rays;
    for (const auto& seen : tie.observations) {
      const std::string image = "DJI_00" + std::to_string(seen.frame.value) + ".JPG";
      const auto& frame = *std::find_if(colmap.frames.begin(), colmap.frames.end(),
                                        [&](const survey::Frame& f) { return f.image == image; });
      const auto ray = camera::unproject(*colmap.camera(frame.camera), seen.pixel).value();
      rays.push_back({static_cast<std::size_t>(&frame - colmap.frames.data()), ray.head<2>() / ray.z()});
    }
    const auto p = intersect_rays(rays, cameras, 0.01);
    if (!p) {
      result.lost += rays.size();
      continue;
    }
    for (const auto& ray : rays)
      result.residuals_px.push_back(ray_residual(ray, cameras[ray.camera], *p) * colmap.manifest.cameras[0].fx_px);
  }
  return result;
}

TEST(TieMatchesOnBrightonBeach, FindsTheSixTurnedFrames) {
  std::vector<std::int64_t> turned;
  for (const auto& frame : matched().turned) {
    EXPECT_EQ(frame.turned_deg, 180);
    EXPECT_LT(frame.after_m, frame.before_m / 3.0);
    EXPECT_GE(frame.pairs, 2U);
    turned.push_back(frame.frame.value);
  }
  EXPECT_THAT(turned, ::testing::ElementsAre(24, 25, 26, 27, 28, 29));
}

TEST(TieMatchesOnBrightonBeach, TiesAgreeWithColmapsPoses) {
  const auto& ties = matched();
  // Half of DJI_0018 is water; what it shares with the others by matching alone is wrong.
  EXPECT_THAT(ties.unmatched, ::testing::ElementsAre(survey::FrameId(18)));
  // Measured: 6058 points. COLMAP on images of 2400 px: 4881 points, 19 804.
  EXPECT_GT(ties.ties.size(), 5000U);
  EXPECT_GT(static_cast<double>(ties.observations) / static_cast<double>(ties.ties.size()), 2.5);
  const auto check = against_colmap(ties);
  constexpr double kMedianPx = 0.8;  // COLMAP's own mean is 0.81 px of 4000 px wide images, 0.32 of these
  EXPECT_LT(median(check.residuals_px), kMedianPx);
  std::size_t wrong = check.lost;
  constexpr double kWrongPx = 4.0;  // a tenth of a car at 1600 px
  for (const auto r : check.residuals_px) wrong += r > kWrongPx ? 1U : 0U;
  EXPECT_LT(static_cast<double>(wrong), 0.02 * static_cast<double>(ties.observations));
}

}  // namespace
}  // namespace cairn::adjustment
