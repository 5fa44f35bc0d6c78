#include "report/layer_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::report {
namespace {

TEST(LayerTable, ManualPageHoldsTheTable) {
  const std::string page = base::read_file(testing::source_dir() / "docs/formats/layers.md");
  EXPECT_NE(page.find(layer_table_markdown()), std::string::npos)
      << "Replace the sections of the layers in docs/formats/layers.md by:\n"
      << layer_table_markdown();
}

TEST(LayerTable, NamesCarryTheirUnits) {
  for (const auto& spec : layer_table()) {
    std::set<std::string> names;
    for (const auto& column : spec.columns) {
      EXPECT_TRUE(names.insert(column.name).second) << spec.name << " " << column.name;
      EXPECT_FALSE(column.definition.empty()) << spec.name << " " << column.name;
      if (column.unit == "m" || column.unit == "deg" || column.unit == "m2" || column.unit == "m3") {
        EXPECT_TRUE(column.name.ends_with("_" + column.unit)) << spec.name << " " << column.name;
      }
    }
  }
}

TEST(LayerTable, UnknownLayerIsADefect) {
  EXPECT_THROW((void)layer_spec("roads"), base::Error);
}

}  // namespace
}  // namespace cairn::report
