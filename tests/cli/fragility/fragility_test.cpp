#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "base/atomic_file.hpp"
#include "io/gaps_json.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_rocks.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;
using ::testing::Not;

std::string read_text(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class FragilityCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string mesh_ = (folder_ / "block.ply").string(), out_ = (folder_ / "out").string(),
              contact_ = (folder_ / "contact.csv").string();
  void SetUp() override {
    ::cairn::io::write_ply(mesh_, ::cairn::testing::block(1, 2, 3));
    write_contact("observed", 0.0);
  }
  void write_contact(const std::string& status, double east) const {
    std::string text = "# crs: local\nrock_id,pad_id,order,x,y,z,status,sigma_m,closed\n";
    const double corners[4][2] = {{-.5, -1}, {.5, -1}, {.5, 1}, {-.5, 1}};
    for (int i = 0; i < 4; ++i)
      text += "0,0," + std::to_string(i) + "," + std::to_string(corners[i][0] + east) + "," +
              std::to_string(corners[i][1]) + ",0," + status + ",0.01,1\n";
    ::cairn::base::write_file(contact_, text);
  }
};

TEST_F(FragilityCommand, BlockWithItsContact) {
  const auto result = cairn({"fragility", mesh_, "--contact", contact_, "--density", "2700", "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  const auto& rock = summary.at("rocks").as_array().at(0);
  EXPECT_EQ(rock.at("grade").as_string(), "bounded");  // how the mesh was made is not known
  EXPECT_NEAR(rock.at("volume_m3").as_real(), 6.0, 1e-12);
  EXPECT_NEAR(rock.at("mass_kg").as_real(), 16200.0, 1e-8);
  EXPECT_FALSE(rock.at("density_assumed").as_bool());
  EXPECT_NEAR(rock.at("alpha_min_deg").as_real(), 18.434949, 5.1e-7);
  EXPECT_NEAR(rock.at("a_qs_g").as_real(), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(rock.at("r_m").as_real(), 1.58113883, 5.1e-9);
  EXPECT_NEAR(rock.at("p_rad_s").as_real(), 2.15678059, 5.1e-9);
  EXPECT_NEAR(rock.at("v_min_m_s").as_real(), 1.535458, 5.1e-7);
  EXPECT_EQ(rock.at("a_qs_g_by_azimuth").size(), 360U);
  EXPECT_NEAR(rock.at("a_qs_g_by_azimuth").as_array().at(0).as_real(), 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(rock.at("inertia_kg_m2").as_array().at(0).as_array().at(0).as_real(), 2700 * 6 * 13.0 / 12.0, 1e-8);
  EXPECT_TRUE(fs::exists(fs::path(out_) / "rocks.json"));
  EXPECT_TRUE(fs::exists(fs::path(out_) / "block_tipping.svg"));
  EXPECT_TRUE(fs::exists(fs::path(out_) / "block_tipping.json"));
}

TEST_F(FragilityCommand, AssumedBaseIsScreeningAtBest) {
  const auto result = cairn({"fragility", mesh_, "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  const auto& rock = summary.at("rocks").as_array().at(0);
  EXPECT_EQ(rock.at("grade").as_string(), "screening");
  EXPECT_TRUE(rock.at("contact_assumed").as_bool());
  EXPECT_TRUE(rock.at("density_assumed").as_bool());
  EXPECT_EQ(rock.at("density_kg_m3").as_real(), 2600.0);
  EXPECT_NEAR(rock.at("alpha_min_deg").as_real(), 18.434949, 5.1e-7);
}

// The plumb point outside the support: flagged, and no angle in any file.
TEST_F(FragilityCommand, NotInEquilibriumHasNoAngleAnywhere) {
  std::string text = "# crs: local\nrock_id,pad_id,order,x,y,z,status,sigma_m,closed\n";
  text += "0,0,0,0.2,-1,0,observed,,1\n0,0,1,0.5,-1,0,observed,,1\n0,0,2,0.5,1,0,observed,,1\n";
  ::cairn::base::write_file(contact_, text);
  const auto result = cairn({"fragility", mesh_, "--contact", contact_, "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("not_in_equilibrium"));
  for (const auto& entry : fs::directory_iterator(out_)) {
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("tipping")));
    if (entry.path().filename() == "rocks.json") {
      const auto rocks = ::cairn::io::read_json(entry.path());
      const auto& tipping = rocks.at("rocks").as_array().at(0).at("tipping");
      EXPECT_TRUE(tipping.find("critical") == nullptr || tipping.at("critical").is_null());
      EXPECT_EQ(tipping.at("a_qs_g_by_azimuth").size(), 0U);
    }
  }
  EXPECT_THAT(result.out, Not(HasSubstr("alpha")));
}

// Interval, quantiles, draws file; the same bytes whatever the threads.
TEST_F(FragilityCommand, DrawsAndIntervals) {
  const auto run = [&](const std::string& out, const char* threads) {
    return cairn({"fragility", mesh_, "--contact", contact_, "--draws", "100", "--seed", "7", "--threads", threads,
                  "-o", out, "--json"});
  };
  const auto result = run(out_, "1");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  const auto& rock = summary.at("rocks").as_array().at(0);
  for (const auto* name :
       {"alpha_min_deg", "azimuth_deg", "r_m", "p_rad_s", "a_qs_g", "v_min_m_s", "barrier_j", "volume_m3", "mass_kg",
        "com_x_m", "com_y_m", "com_z_m", "inertia_xx_kg_m2", "inertia_xy_kg_m2", "alpha_bearing_deg"}) {
    const auto& q = rock.at("quantiles").at(name);
    double before = -1e30;
    for (const auto* level : {"p05", "p16", "p50", "p84", "p95"}) {
      EXPECT_GE(q.at(level).as_real(), before) << name;
      before = q.at(level).as_real();
    }
  }
  const auto& interval = rock.at("alpha_interval_deg").as_array();
  EXPECT_NEAR(std::tan(interval.at(0).as_real() * std::numbers::pi / 180), 0.5 / 3.0, 1e-9);  // inset 0.5
  EXPECT_NEAR(interval.at(1).as_real(), rock.at("alpha_min_deg").as_real(), 1e-12);
  double rose = 0.0;
  for (const auto& share : rock.at("uncertainty").at("rose").as_array()) rose += share.as_real();
  EXPECT_NEAR(rose, 1.0, 1e-9);
  const std::string other = (folder_ / "other").string();
  ASSERT_EQ(run(other, "2").exit_code, 0);
  for (const auto* name : {"rocks.json", "block_draws.csv", "block_tipping.json", "block_tipping.svg"})
    EXPECT_EQ(read_text(fs::path(out_) / name), read_text(fs::path(other) / name)) << name;
  const std::string draws = read_text(fs::path(out_) / "block_draws.csv");
  EXPECT_EQ(std::count(draws.begin(), draws.end(), '\n'), 101);
  EXPECT_THAT(draws, HasSubstr("draw,standing,alpha_min_deg,azimuth_deg"));
}

// A second rock, or another id, draws other numbers; the text says what was assumed.
TEST_F(FragilityCommand, TextSaysWhatWasAssumed) {
  const auto result = cairn({"fragility", mesh_, "-o", out_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("2600 kg/m3 (assumed)"));
  EXPECT_THAT(result.out, HasSubstr("contact: at most 18.4 deg"));
}

TEST_F(FragilityCommand, PointAndLineContacts) {
  const auto reasons = [&](const std::string& rows) {
    ::cairn::base::write_file(contact_, "# crs: local\nrock_id,pad_id,order,x,y,z,status,sigma_m,closed\n" + rows);
    const auto result = cairn({"fragility", mesh_, "--contact", contact_, "-o", out_, "--overwrite", "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, Not(HasSubstr("alpha")));
    return result.out;
  };
  EXPECT_THAT(reasons("0,0,0,0,0,0,observed,,1\n"), HasSubstr("point_contact"));
  EXPECT_THAT(reasons("0,0,0,0,-1,0,observed,,1\n0,0,1,0,1,0,observed,,1\n"), HasSubstr("line_contact"));
}

// An audit that could not see the western half of the contact: `bounded` by the mesh, `screening` by the audit.
TEST_F(FragilityCommand, CoverageLimitsTheGrade) {
  ::cairn::survey::CoverageGap gap;
  gap.id = ::cairn::survey::GapId(0);
  gap.rings = {::cairn::geometry::Ring{{-2, -2}, {0.4, -2}, {0.4, 2}, {-2, 2}}};
  gap.area_m2 = 1.0;
  gap.facets = 1;
  gap.reason = "no_view";
  ::cairn::io::write_gaps(folder_ / "gaps.json",
                          {{{46.8, -92.0, 100.0}, ::cairn::survey::HeightType::ellipsoidal, ""}, {gap}});
  const auto result = cairn({"fragility", mesh_, "--contact", contact_, "--coverage", (folder_ / "gaps.json").string(),
                             "--draws", "0", "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  const auto& rock = summary.at("rocks").as_array().at(0);
  EXPECT_EQ(rock.at("grade").as_string(), "screening");
  EXPECT_THAT(result.out, HasSubstr("contact_not_covered"));
  EXPECT_EQ(
      cairn({"fragility", mesh_, "--coverage", (folder_ / "none").string(), "-o", (folder_ / "no").string()}).exit_code,
      4);
}

TEST_F(FragilityCommand, FromCloudToGrade) {
  ::cairn::testing::write_small_rocks(folder_.path());
  const std::string labelled = (folder_ / "labelled.las").string(), surfaces = (folder_ / "surfaces").string();
  ASSERT_EQ(cairn({"segment", (folder_ / "cloud.las").string(), "--targets", (folder_ / "targets.json").string(), "-o",
                   labelled})
                .exit_code,
            0);
  ASSERT_EQ(cairn({"surface", labelled, "-o", surfaces}).exit_code, 0);
  const auto result = cairn({"fragility", surfaces, "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  ASSERT_EQ(summary.at("rocks").size(), 2U);
  // The sparse dome is 0.35 m high with points 5 cm apart at best.
  const auto& dome = summary.at("rocks").as_array().at(0);
  EXPECT_NE(dome.at("grade").as_string(), "measured");
  EXPECT_NE(dome.at("grade").as_string(), "bounded");
  // The post was scanned all round: tan(alpha) = 0.5 / 0.6 at its rim, which is assumed to be the contact.
  const auto& post = summary.at("rocks").as_array().at(1);
  EXPECT_EQ(post.at("grade").as_string(), "screening");
  EXPECT_NEAR(post.at("alpha_min_deg").as_real(), 39.8, 1.5);
  EXPECT_NEAR(post.at("volume_m3").as_real(), 0.942, 0.04);
}

TEST_F(FragilityCommand, AnOpenBaseIsClosedAndSaidSo) {
  auto open = ::cairn::testing::block(1, 1, 3);
  std::erase_if(open.triangles, [&](const auto& t) {
    return std::all_of(t.begin(), t.end(), [&](auto i) { return open.vertices[i].z() <= open.bounds().min.z(); });
  });
  ASSERT_EQ(open.triangles.size(), 10U);
  ::cairn::io::write_ply(folder_ / "open.ply", open);
  const auto result = cairn({"fragility", (folder_ / "open.ply").string(), "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto rock = ::cairn::io::parse_json(result.out, "stdout").at("rocks").as_array().at(0);
  std::vector<std::string> notes;
  for (const auto& note : rock.at("notes").as_array()) notes.push_back(note.as_string());
  EXPECT_THAT(notes, ::testing::Contains("base_closed"));
  EXPECT_NEAR(rock.at("volume_m3").as_real(), 3.0, 1e-12);
  EXPECT_EQ(rock.at("grade").as_string(), "screening");
}

TEST_F(FragilityCommand, BadInput) {
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "fragility");
    arguments.insert(arguments.end(), {"-o", out_});
    auto result = cairn(arguments);
    EXPECT_FALSE(fs::exists(out_));
    return result;
  };
  auto open = ::cairn::testing::block(1, 1, 3);
  std::erase_if(open.triangles, [&](const auto& t) {  // the southern flank
    return std::all_of(t.begin(), t.end(), [&](auto i) { return open.vertices[i].y() <= open.bounds().min.y(); });
  });
  ::cairn::io::write_ply(folder_ / "open.ply", open);
  const auto refused = run({(folder_ / "open.ply").string()});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err, HasSubstr("surface_not_closed"));

  auto two = ::cairn::testing::block(1, 1, 3);
  const auto second = ::cairn::testing::moved(two, ::cairn::geometry::Vec3(5, 0, 0));
  const auto base = static_cast<std::uint32_t>(two.vertices.size());
  two.vertices.insert(two.vertices.end(), second.vertices.begin(), second.vertices.end());
  for (const auto& t : second.triangles) two.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  ::cairn::io::write_ply(folder_ / "two.ply", two);
  const auto shells = run({(folder_ / "two.ply").string()});
  EXPECT_EQ(shells.exit_code, 4);
  EXPECT_THAT(shells.err, HasSubstr("several_pieces"));

  write_contact("observed", 40.0);
  const auto elsewhere = run({mesh_, "--contact", contact_});
  EXPECT_EQ(elsewhere.exit_code, 4);
  EXPECT_THAT(elsewhere.err, HasSubstr("contact_outside_rock"));

  write_contact("guessed", 0.0);
  const auto status = run({mesh_, "--contact", contact_});
  EXPECT_EQ(status.exit_code, 4);
  EXPECT_THAT(status.err, HasSubstr("observed, inferred"));

  ::cairn::base::write_file(contact_, "# crs: EPSG:32615\nrock_id,pad_id,order,x,y,z,status,sigma_m,closed\n");
  EXPECT_EQ(run({mesh_, "--contact", contact_}).exit_code, 6);
  EXPECT_EQ(run({(folder_ / "none.ply").string()}).exit_code, 4);
  EXPECT_EQ(run({mesh_, "--density", "0"}).exit_code, 2);
}

}  // namespace
