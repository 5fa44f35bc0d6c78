#include "segmentation/cell_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/random.hpp"

namespace cairn::segmentation {
namespace {

using geometry::GridGeometry;
using geometry::Vec3;

const GridGeometry kGrid{-5.0, 5.0, 0.7, 14, 13};

std::vector<Vec3> points() {
  base::Random random(5, "cells", 0);
  std::vector<Vec3> p;
  for (int i = 0; i < 5000; ++i) p.emplace_back(random.uniform(-6, 6), random.uniform(-6, 6), random.uniform(-3, 9));
  p.emplace_back(std::nan(""), 0, 0);
  p.emplace_back(0, 0, std::nan(""));
  p.emplace_back(-5.0, 5.0, 100.0);  // a cell owns its western and northern border
  return p;
}

TEST(CellStatistics, EqualsAPlainCount) {
  const auto p = points();
  std::map<std::size_t, std::vector<double>> expected;
  std::size_t outside = 0;
  for (const Vec3& v : p) {
    const auto cell = kGrid.cell_at(v.head<2>());
    if (!cell || !std::isfinite(v.z())) {
      ++outside;
    } else {
      expected[cell->first * kGrid.columns + cell->second].push_back(v.z());
    }
  }
  const CellStatistics s = cell_statistics(p, kGrid);
  EXPECT_EQ(s.outside, outside);
  std::size_t heights_outside = 0;
  const auto heights = cell_heights(p, kGrid, heights_outside);
  EXPECT_EQ(heights_outside, outside);
  for (std::size_t k = 0; k < kGrid.cells(); ++k) {
    auto values = expected[k];
    ASSERT_EQ(s.count.values[k], values.size());
    ASSERT_EQ(heights.values[k].points, values.size());
    if (values.empty()) {
      ASSERT_TRUE(std::isnan(s.max.values[k]));
      continue;
    }
    double sum = 0.0;
    for (const double v : values) sum += v;
    std::sort(values.begin(), values.end());
    ASSERT_EQ(s.max.values[k], static_cast<float>(values.back()));
    ASSERT_EQ(s.mean.values[k], static_cast<float>(sum / static_cast<double>(values.size())));
    ASSERT_EQ(heights.values[k].low, static_cast<float>(values.front()));
    ASSERT_EQ(heights.values[k].high, static_cast<float>(values.back()));
    const std::size_t second = std::min<std::size_t>(1, values.size() - 1);
    ASSERT_EQ(heights.values[k].second_low, static_cast<float>(values[second]));
    ASSERT_EQ(heights.values[k].second_high, static_cast<float>(values[values.size() - 1 - second]));
  }
}

}  // namespace
}  // namespace cairn::segmentation
