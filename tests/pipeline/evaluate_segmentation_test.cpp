#include "pipeline/evaluate_segmentation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "base/error.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/truth.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;
using geometry::Vec3;

constexpr double kShift = 0.02;  // m, of the found contact line to the east
// The line is sampled every 5 mm; its corners are exact.
constexpr double kAngle = 1e-9;     // deg
constexpr double kDistance = 1e-3;  // m

// A block of 1 x 1 x 3 m on a plane, points on its sides only. Its first 100 points are taken for pedestal.
class EvaluateSegmentation : public ::testing::Test {
 protected:
  void SetUp() override {
    geometry::PointCloud cloud;
    for (int i = 0; i < 10; ++i)
      for (int k = 0; k < 30; ++k) {
        const double t = 0.05 + 0.1 * i, z = 0.05 + 0.1 * k;
        for (const Vec3& p : {Vec3(t, 0, z), Vec3(t, 1, z), Vec3(0, t, z), Vec3(1, t, z)}) cloud.positions.push_back(p);
      }
    const std::size_t rock = cloud.size();
    for (int i = -20; i < 30; ++i)
      for (int k = -20; k < 30; ++k)
        if (i < 0 || i >= 10 || k < 0 || k >= 10) cloud.positions.emplace_back(0.1 * i + 0.05, 0.1 * k + 0.05, 0.0);
    auto& label = cloud.add_scalar("label", geometry::ScalarType::u8, "").values;
    for (std::size_t i = 0; i < label.size(); ++i) label[i] = i < rock ? 2.0 : 1.0;
    auto& id = cloud.add_scalar("target_id", geometry::ScalarType::u32, "").values;
    for (std::size_t i = 0; i < id.size(); ++i) id[i] = i < rock ? 5.0 : 4294967295.0;
    io::write_cloud(folder_ / "truth.las", cloud);
    for (std::size_t i = 0; i < 100; ++i) cloud.scalars[0].values[i] = 3.0;
    io::write_cloud(folder_ / "found.las", cloud);

    survey::Truth truth;
    survey::TruthObject block;
    block.id = survey::ObjectId(5);
    block.object_class = "pbr";
    block.cylinder = {{0.5, 0.5}, 0.0, 3.0, 0.71};
    block.contact_rim = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
    block.centre_of_mass = {0.5, 0.5, 1.5};
    truth.objects.push_back(block);
    fs::create_directories(folder_ / "truth");
    io::write_truth(truth, survey::Origin{}, folder_ / "truth");
    io::ContactFile contact;
    contact.crs = "local";
    for (const auto& p : block.contact_rim.front()) {
      survey::ContactVertex v;
      v.order = static_cast<std::int64_t>(contact.rows.size());
      v.position = p + Vec3(kShift, 0, 0);
      v.observed = true;
      contact.rows.push_back({5, v});
    }
    io::write_contact_csv(folder_ / "found.contact.csv", contact);
  }

  [[nodiscard]] EvaluateSegmentationInputs inputs() const {
    EvaluateSegmentationInputs in;
    in.labelled = folder_ / "found.las";
    in.truth = folder_ / "truth.las";
    return in;
  }

  cairn::testing::TempFolder folder_;
  base::RunContext ctx_;
};

TEST_F(EvaluateSegmentation, OverlapContactAndAlphaOfAShiftedLine) {
  const auto s = evaluate_segmentation(inputs(), {}, ctx_).summary;
  EXPECT_DOUBLE_EQ(s.at("iou").as_real(), 1100.0 / 1200.0);
  EXPECT_DOUBLE_EQ(s.at("dice").as_real(), 2200.0 / 2300.0);
  EXPECT_EQ(s.at("unpaired").as_integer(), 0);
  EXPECT_EQ(s.at("instances").at("matched").as_integer(), 1);
  const auto& rock = s.at("rocks").as_array().at(0);
  // Half of the outline slides along itself (but for its ends), half moves by the shift.
  EXPECT_NEAR(rock.at("contact").at("mean_m").as_real(), 0.5 * kShift, kDistance);
  EXPECT_NEAR(rock.at("contact").at("hausdorff_m").as_real(), kShift, kDistance);
  const double degrees = 180.0 / std::numbers::pi;
  EXPECT_NEAR(rock.at("alpha").at("true_rim_deg").as_real(), degrees * std::atan2(0.5, 1.5), kAngle);
  EXPECT_NEAR(rock.at("alpha").at("contact_error_deg").as_real(),
              degrees * (std::atan2(0.5 - kShift, 1.5) - std::atan2(0.5, 1.5)), kAngle);
  EXPECT_TRUE(rock.at("alpha").at("error_deg").is_null());  // no body: the truth states no volume
  EXPECT_TRUE(rock.at("volume").is_null());
}

// Points left out of the result count as not found, wherever they stood in the file.
TEST_F(EvaluateSegmentation, PairsCloudsOfDifferentOrderByPosition) {
  auto cloud = io::read_cloud(folder_ / "found.las").cloud;
  std::vector<std::size_t> backwards;
  for (std::size_t i = cloud.size(); i > 200; --i) backwards.push_back(i - 1);
  io::write_cloud(folder_ / "found.las", cloud.subset(backwards));
  const auto s = evaluate_segmentation(inputs(), {}, ctx_).summary;
  EXPECT_DOUBLE_EQ(s.at("iou").as_real(), 1000.0 / 1200.0);
}

TEST_F(EvaluateSegmentation, BadInput) {
  auto in = inputs();
  auto cloud = io::read_cloud(in.labelled).cloud;
  for (auto& p : cloud.positions) p.z() += 100.0;
  io::write_cloud(folder_ / "found.las", cloud);
  EXPECT_THROW((void)evaluate_segmentation(in, {}, ctx_), base::Error);
  cloud.scalars.clear();
  io::write_cloud(folder_ / "found.las", cloud);
  EXPECT_THROW((void)evaluate_segmentation(in, {}, ctx_), base::Error);
  in = inputs();
  in.rocks = folder_ / "nowhere";
  in.labelled = in.truth;
  EXPECT_THROW((void)evaluate_segmentation(in, {}, ctx_), base::Error);
}

}  // namespace
}  // namespace cairn::pipeline
