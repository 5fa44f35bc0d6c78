#include "coverage/audit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "support/meshes.hpp"

namespace cairn::coverage {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// One facet of 0.5 m^2 a row.
struct Row {
  std::uint32_t in_frame, facing, views;
  float gsd, incidence, second, parallax;
  Verdict expected;
};

FacetCoverage metrics_of(const std::vector<Row>& rows) {
  FacetCoverage m;
  for (const Row& r : rows) {
    m.in_frame.push_back(r.in_frame);
    m.facing.push_back(r.facing);
    m.views.push_back(r.views);
    m.gsd_best_mm.push_back(r.gsd);
    m.gsd_median_mm.push_back(r.gsd);
    m.incidence_best_deg.push_back(r.incidence);
    m.incidence_second_deg.push_back(r.second);
    m.parallax_deg.push_back(r.parallax);
  }
  return m;
}

TEST(Audit, NamesTheFirstReasonThatApplies) {
  const std::vector<Row> rows = {
      {5, 5, 5, 9.0F, 10.0F, 20.0F, 30.0F, Verdict::passed},
      {2, 2, 2, 9.0F, 10.0F, 20.0F, 30.0F, Verdict::out_of_frame},
      {5, 2, 2, 9.0F, 10.0F, 20.0F, 30.0F, Verdict::too_oblique},
      {5, 5, 0, kNan, kNan, kNan, kNan, Verdict::occluded},
      {5, 5, 3, 9.0F, 10.0F, 61.0F, 30.0F, Verdict::too_oblique},
      {5, 5, 3, 11.0F, 10.0F, 20.0F, 30.0F, Verdict::too_coarse},
      {5, 5, 3, 9.0F, 10.0F, 20.0F, 4.9F, Verdict::low_parallax},
      {5, 5, 5, 9.0F, 10.0F, 20.0F, 30.0F, Verdict::no_data},
  };
  const auto mesh = testing::slab(0, 0, 2, 2, 0, 2);  // 8 facets of 0.5 m^2
  std::vector<std::uint8_t> observed(rows.size(), 1);
  observed.back() = 0;
  GateOptions gates;
  gates.max_gsd_mm = 10.0;
  const Audit result = audit(mesh, metrics_of(rows), observed, gates);
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(result.verdicts[i], rows[i].expected) << i;
  EXPECT_DOUBLE_EQ(result.area(Verdict::too_oblique), 1.0);
  EXPECT_DOUBLE_EQ(result.observed_area(), 3.5);
  EXPECT_DOUBLE_EQ(result.completeness(), 0.5 / 3.5);
}

TEST(Audit, OneViewSufficesWhereOneIsAskedFor) {
  const auto mesh = testing::slab(0, 0, 1, 1, 0, 1);
  GateOptions gates;
  gates.min_views = 1;
  gates.min_parallax_deg = 0.0;
  const std::vector<Row> rows = {{1, 1, 1, 9.0F, 10.0F, kNan, kNan, Verdict::passed},
                                 {1, 1, 1, 9.0F, 70.0F, kNan, kNan, Verdict::too_oblique}};
  const Audit result = audit(mesh, metrics_of(rows), {}, gates);
  EXPECT_EQ(result.verdicts[0], Verdict::passed);
  EXPECT_EQ(result.verdicts[1], Verdict::too_oblique);
}

TEST(Audit, NothingObservedIsNothingCovered) {
  const auto mesh = testing::slab(0, 0, 1, 1, 0, 1);
  const std::vector<Row> rows(2, Row{5, 5, 5, 9.0F, 10.0F, 20.0F, 30.0F, Verdict::no_data});
  const Audit result = audit(mesh, metrics_of(rows), std::vector<std::uint8_t>{0, 0}, {});
  EXPECT_EQ(result.completeness(), 0.0);
  EXPECT_EQ(result.facets[static_cast<std::size_t>(Verdict::no_data)], 2U);
}

TEST(Audit, NeedsMetrics) {
  const auto mesh = testing::slab(0, 0, 1, 1, 0, 1);
  FacetCoverage counts;
  counts.views = counts.in_frame = counts.facing = {1, 1};
  EXPECT_THROW(audit(mesh, counts, {}, {}), base::Error);
}

TEST(Audit, VerdictsHaveNames) {
  EXPECT_EQ(name_of(Verdict::passed), "passed");
  EXPECT_EQ(name_of(Verdict::low_parallax), "low_parallax");
}

}  // namespace
}  // namespace cairn::coverage
