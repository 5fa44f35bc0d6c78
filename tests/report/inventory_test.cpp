#include "report/inventory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn::report {
namespace {

TEST(InventoryIds, AreMadeOfSurveyAndNumber) {
  EXPECT_EQ(slug_of("Brighton Beach, north (2024)"), "brighton-beach-north-2024");
  EXPECT_EQ(slug_of("  "), "survey");
  EXPECT_EQ(inventory_id("a", survey::TargetId(7)), "a-0007");
  EXPECT_EQ(inventory_id("a", survey::TargetId(123456)), "a-123456");
}

TEST(ProtectedText, HidesWhatTellsThePlace) {
  const Protection on{true, 0.01, 100.0};
  EXPECT_EQ(protected_text("at 46.842979, -91.993612", on), "at 46.84, -91.99");
  EXPECT_EQ(protected_text("46°50'34.7\" N", on), "[withheld]°[withheld]'[withheld]\" N");
  EXPECT_EQ(protected_text("UTM 15N 576720 5188112", on), "UTM 15N [withheld] [withheld]");
  EXPECT_EQ(protected_text("see https://maps.example/46.8,91.9 for it", on), "see [withheld] for it");
  EXPECT_EQ(protected_text("46,842979 N", on), "46.84 N");
  // What says nothing about the place stays.
  EXPECT_EQ(protected_text("3 rocks, 1.25 m high, 2600 kg/m3, seen 2026-05-01", on),
            "3 rocks, 1.25 m high, 2600 kg/m3, seen 2026-05-01");
  EXPECT_EQ(protected_text("46.842979", {}), "46.842979");
}

TEST(InventoryFields, KnowTheirNamesAndRanges) {
  EXPECT_EQ(inventory_field("status"), "field_status");
  EXPECT_EQ(inventory_field("lithology"), "lithology");
  EXPECT_FALSE(inventory_field("colour"));
  EXPECT_EQ(field_problem("density_kg_m3", "2600"), "");
  EXPECT_NE(field_problem("density_kg_m3", "2.6"), "");
  EXPECT_NE(field_problem("vs30_m_s", "fast"), "");
  EXPECT_NE(field_problem("vs30_m_s", "nan"), "");
  EXPECT_EQ(field_problem("lithology", "granite"), "");
}

// A rock whose survey stands nowhere has a row, but no position.
TEST(InventoryLayers, RocksWithoutAFrameHaveNoPosition) {
  Inventory inventory;
  inventory.surveys.push_back({"bench", "bench", std::nullopt, "bench", "", std::nullopt});
  InventoryRock rock;
  rock.id = "bench-0000";
  rock.rock.mass = geometry::MassProperties{};
  rock.rock.mass->volume = 1.0;
  inventory.rocks.push_back(rock);
  const auto layers = inventory_layers(inventory);
  ASSERT_EQ(layers.front().features.size(), 1U);
  EXPECT_TRUE(layers.front().features[0].parts.empty());
  EXPECT_EQ(layers.front().features[0].values[layers.front().column("latitude_deg")].index(), 0U);
  EXPECT_EQ(rock_json(layers, 0).at("id").as_string(), "bench-0000");
}

}  // namespace
}  // namespace cairn::report
