#include "report/layers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "base/error.hpp"
#include "io/vector.hpp"
#include "report/layer_table.hpp"
#include "support/data.hpp"
#include "support/layer_records.hpp"

namespace cairn::report {
namespace {

using io::Layer;
using io::Value;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kDegTolerance = 1e-9;

const Layer& layer(const std::vector<Layer>& layers, std::string_view name) {
  for (const auto& candidate : layers)
    if (candidate.name == name) return candidate;
  throw std::runtime_error("no layer " + std::string(name));
}

const Value& value(const Layer& from, std::size_t feature, std::string_view column) {
  return from.features.at(feature).values.at(from.column(column));
}
double real(const Layer& from, std::size_t feature, std::string_view column) {
  return std::get<double>(value(from, feature, column));
}

TEST(Layers, AreThoseOfTheTable) {
  const auto layers = build_layers(testing::example_records());
  ASSERT_EQ(layers.size(), layer_table().size());
  for (std::size_t i = 0; i < layers.size(); ++i) {
    EXPECT_EQ(layers[i].name, layer_table()[i].name);
    EXPECT_NO_THROW(io::validate(layers[i]));
    EXPECT_TRUE(layers[i].style.has_value());
    EXPECT_EQ(layers[i].height_type, survey::HeightType::ellipsoidal);
  }
}

// No column stays empty in a survey that has everything: a column nobody fills is a defect.
TEST(Layers, EveryColumnIsFilled) {
  for (const auto& built : build_layers(testing::example_records()))
    for (std::size_t c = 0; c < built.columns.size(); ++c) {
      bool filled = false;
      for (const auto& feature : built.features) filled = filled || feature.values[c].index() != 0;
      EXPECT_TRUE(filled) << built.name << " " << built.columns[c].name;
    }
}

TEST(Layers, NothingFromNothing) {
  LayerRecords records;
  records.origin = testing::example_records().origin;
  for (const auto& built : build_layers(records)) EXPECT_THAT(built.features, IsEmpty());
}

TEST(Layers, PositionsAreTheLocalFrames) {
  const auto records = testing::example_records();
  const geodesy::LocalFrame frame(records.origin.position);
  const auto layers = build_layers(records);
  const Layer& targets = layer(layers, "targets");
  const auto expected = frame.to_geodetic(records.targets[0].centre);
  EXPECT_EQ(targets.features[0].parts[0][0][0], expected);
  EXPECT_EQ(real(targets, 0, "latitude_deg"), expected.latitude_deg);
  EXPECT_EQ(real(targets, 0, "height_m"), expected.height_m);
  EXPECT_EQ(real(targets, 0, "east_m"), 10.0);
  EXPECT_EQ(value(targets, 0, "height_type"), Value(std::string("ellipsoidal")));
  // Eigenvalues of [[0.04 0.03] [0.03 0.04]] are 0.07 and 0.01.
  EXPECT_NEAR(real(targets, 0, "sigma_horizontal_m"), std::sqrt(0.07), 1e-12);
  EXPECT_NEAR(real(targets, 0, "sigma_vertical_m"), 0.3, 1e-12);
  EXPECT_EQ(value(targets, 0, "detections"), Value(std::int64_t{3}));
}

TEST(Layers, RocksKeepWhatTheirGradeAllows) {
  const auto layers = build_layers(testing::example_records());
  const Layer& rocks = layer(layers, "rocks");
  ASSERT_THAT(rocks.features, SizeIs(3));
  EXPECT_NEAR(real(rocks, 0, "alpha_min_deg"), 30.0, kDegTolerance);
  EXPECT_EQ(real(rocks, 0, "topple_toward_deg"), 135.0);
  EXPECT_EQ(real(rocks, 0, "hwr"), 1.5);
  EXPECT_EQ(real(rocks, 0, "mass_kg"), 1.25 * 2650.0);
  EXPECT_EQ(value(rocks, 0, "grade_reasons"), Value(std::string("contact_assumed;base_unseen")));
  EXPECT_EQ(real(rocks, 0, "east_m"), 10.1) << "the centre of mass";
  EXPECT_NEAR(real(rocks, 0, "base_height_m"), 197.8, 1e-4);
  // Not measurable: no alpha nor what follows from it, though the record has them.
  for (const char* column : {"alpha_min_deg", "topple_toward_deg", "r_m", "p_rad_s", "a_qs_g", "v_min_m_s"})
    EXPECT_EQ(value(rocks, 1, column), Value()) << column;
  EXPECT_EQ(value(rocks, 1, "grade"), Value(std::string("not_measurable")));
  // Rejected, and its target unknown: no place, no size, but the reason.
  EXPECT_THAT(rocks.features[2].parts, IsEmpty());
  EXPECT_EQ(value(rocks, 2, "status"), Value(std::string("rejected")));
  EXPECT_EQ(value(rocks, 2, "reasons"), Value(std::string("too_few_points")));
  EXPECT_EQ(value(rocks, 2, "length_m"), Value());
  EXPECT_EQ(value(rocks, 2, "grade"), Value());

  const Layer inventory = inventory_layer(testing::example_records());
  EXPECT_EQ(inventory.name, "inventory");
  EXPECT_THAT(inventory.features, SizeIs(3));
}

TEST(Layers, FramesTellWhereTheyLook) {
  const auto layers = build_layers(testing::example_records());
  const Layer& frames = layer(layers, "frames");
  EXPECT_NEAR(real(frames, 0, "axis_depression_deg"), 90.0, kDegTolerance);
  EXPECT_EQ(value(frames, 0, "axis_azimuth_deg"), Value()) << "vertical";
  EXPECT_NEAR(real(frames, 0, "image_top_azimuth_deg"), 0.0, kDegTolerance);
  EXPECT_NEAR(real(frames, 1, "axis_depression_deg"), 45.0, kDegTolerance);
  EXPECT_NEAR(real(frames, 1, "axis_azimuth_deg"), 90.0, kDegTolerance);
  EXPECT_NEAR(real(frames, 1, "image_top_azimuth_deg"), 90.0, kDegTolerance);
  EXPECT_EQ(real(frames, 0, "above_ground_m"), 31.0);
  const Layer& footprints = layer(layers, "footprints");
  ASSERT_THAT(footprints.features, SizeIs(1)) << "the second frame has none";
  EXPECT_EQ(real(footprints, 0, "area_m2"), 1200.0);
}

TEST(Layers, GapsSuggestAView) {
  const auto layers = build_layers(testing::example_records());
  const Layer& gaps = layer(layers, "gaps");
  EXPECT_THAT(gaps.features[0].parts[0], SizeIs(2)) << "outer ring and hole";
  EXPECT_EQ(value(gaps, 0, "nearest_frames"), Value(std::string("1;0")));
  EXPECT_NEAR(real(gaps, 0, "view_azimuth_deg"), 0.0, kDegTolerance);
  EXPECT_NEAR(real(gaps, 0, "view_depression_deg"), 45.0, kDegTolerance);
}

TEST(Layers, StylesFollowTheRecords) {
  const auto layers = build_layers(testing::example_records());
  const auto names = [](const Layer& from) {
    std::vector<std::string> values;
    for (const auto& c : from.style->classes) values.push_back(c.value);
    return values;
  };
  EXPECT_THAT(names(layer(layers, "targets")), ElementsAre("boulder", "tree"));
  EXPECT_THAT(names(layer(layers, "rocks")), ElementsAre("measured", "bounded", "screening", "not_measurable"));
  EXPECT_THAT(names(layer(layers, "gaps")), ElementsAre("too_few_views"));
  for (const auto& built : layers)
    if (!built.style->column.empty()) {
      EXPECT_LT(built.column(built.style->column), built.columns.size()) << built.name;
    }
}

TEST(Layers, HeightsNameTheirDatum) {
  auto records = testing::example_records();
  records.origin.height_type = survey::HeightType::orthometric;
  records.origin.geoid = "egm96";
  const auto layers = build_layers(records);
  EXPECT_EQ(value(layer(layers, "targets"), 0, "height_type"), Value(std::string("orthometric (egm96)")));
  EXPECT_EQ(layer(layers, "targets").geoid, "egm96");
}

TEST(Layers, NumbersThatAreNotFiniteNeverGetOut) {
  auto records = testing::example_records();
  records.targets[0].mean_score = std::numeric_limits<double>::infinity();
  const testing::TempFolder folder;
  io::write_geopackage(folder / "layers.gpkg", build_layers(records));
  const auto read = io::read_vector(folder / "layers.gpkg");
  EXPECT_EQ(read[0].features[0].values[15], Value());
  EXPECT_EQ(read[0].columns[15].name, "mean_score");
  records.targets[0].centre.x() = std::nan("");
  EXPECT_THROW(io::write_geopackage(folder / "layers.gpkg", build_layers(records)), base::Error);
}

}  // namespace
}  // namespace cairn::report
