#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>

#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"
#include "io/ply.hpp"
#include "io/rocks_json.hpp"
#include "io/targets_json.hpp"
#include "io/vector.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
namespace io = ::cairn::io;
namespace survey = ::cairn::survey;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;
using ::testing::Not;

using Row = std::map<std::string, std::string>;

// A site on Earth that no product of a protected inventory may give away.
constexpr double kLatitude = 46.842979, kLongitude = -91.993612, kHeight = 198.25;

survey::Rock measured_rock(std::int64_t id, const ::cairn::geometry::Vec3& centre, survey::Grade grade,
                           double alpha_rad) {
  survey::Rock rock;
  rock.target = survey::TargetId(id);
  rock.object_class = "boulder";
  rock.point_count = 2500;
  rock.point_spacing_m = 0.02;
  rock.size_m = {1.0, 1.0, 3.0};
  rock.base_height_m = centre.z() - 1.5;
  rock.cap = survey::CapModel::patch;
  rock.unseen_area_fraction = 0.1;
  ::cairn::geometry::MassProperties mass;
  mass.volume = 3.0;
  mass.centre_of_mass = centre;
  mass.inertia_per_density = ::cairn::geometry::Mat3::Identity() * 2.5;
  rock.mass = mass;
  rock.hull_volume_m3 = 3.1;
  rock.density_kg_m3 = 2600.0;
  rock.tipping.grade = grade;
  rock.tipping.reasons = {"contact_partly_seen"};
  for (const auto& corner : {std::pair{-.5, -.5}, {.5, -.5}, {.5, .5}, {-.5, .5}})
    rock.tipping.contact.emplace_back(centre.x() + corner.first, centre.y() + corner.second, centre.z() - 1.5);
  if (grade == survey::Grade::not_measurable) return rock;
  survey::TippingEdge edge;
  edge.azimuth_deg = 90.0;
  edge.alpha_rad = alpha_rad;
  edge.r_m = 1.58;
  edge.p_rad_s = 2.157;
  edge.a_qs_g = 0.333;
  edge.v_min_m_s = 1.535;
  edge.inertia_m2 = 3.33;
  edge.barrier_j_kg = 0.8;
  edge.ends = {rock.tipping.contact[1], rock.tipping.contact[2]};
  rock.tipping.critical = edge;
  rock.tipping.edges = {edge};
  rock.tipping.a_qs_g_by_azimuth.assign(360, 0.4);
  survey::TippingUncertainty u;
  u.draws = 1000;
  u.scalars = {{"alpha_min_deg", {15.0, 16.0, 18.0, 20.0, 21.0}}, {"mass_kg", {7000, 7400, 7800, 8200, 8600}}};
  u.variance_shares = {{"contact", 0.7}, {"density", 0.0}};
  rock.tipping.uncertainty = u;
  return rock;
}

// A result folder: three rocks that count and one that was rejected.
void write_result(const fs::path& folder, double east_shift = 0.0) {
  fs::create_directories(folder / "rocks");
  io::RocksFile rocks;
  rocks.frame = {{kLatitude, kLongitude, kHeight}, survey::HeightType::ellipsoidal, ""};
  rocks.rocks = {measured_rock(3, {10.0 + east_shift, -5.0, 1.5}, survey::Grade::bounded, 0.32),
                 measured_rock(7, {25.0 + east_shift, 4.0, 1.5}, survey::Grade::screening, 0.25),
                 measured_rock(8, {60.0 + east_shift, 9.0, 1.5}, survey::Grade::not_measurable, 0.0)};
  survey::Rock rejected;
  rejected.target = survey::TargetId(12);
  rejected.object_class = "boulder";
  rejected.rejected = true;
  rejected.reasons = {"too_few_points"};
  rocks.rocks.push_back(rejected);
  io::write_rocks(folder / "rocks.json", rocks);
  io::TargetsFile targets;
  targets.frame = rocks.frame;
  for (const auto& rock : rocks.rocks) {
    survey::Target t;
    t.id = rock.target;
    t.object_class = "boulder";
    t.state = survey::TargetState::mapped;
    t.centre = rock.mass ? rock.mass->centre_of_mass : ::cairn::geometry::Vec3(30.0, 40.0, 0.0);
    t.covariance = ::cairn::geometry::Mat3::Identity() * 0.04;
    targets.targets.push_back(t);
  }
  io::write_targets(folder / "targets.json", targets);
  for (const auto& rock : rocks.rocks) {
    if (!rock.mass) continue;
    auto mesh = ::cairn::testing::block(1, 1, 3);
    for (auto& v : mesh.vertices) v += rock.mass->centre_of_mass - ::cairn::geometry::Vec3(0, 0, 1.5);
    io::write_ply(folder / "rocks" / (std::to_string(rock.target.value) + ".ply"), mesh);
  }
}

std::map<std::string, Row> table(const fs::path& csv_file) {
  io::CsvReader csv(csv_file);
  std::map<std::string, Row> rows;
  while (csv.next()) {
    Row row;
    for (std::size_t c = 0; c < csv.header().size(); ++c) row[csv.header()[c]] = std::string(csv.text(c));
    rows[row.at("id")] = row;
  }
  return rows;
}

class InventoryCommand : public ::testing::Test {
 protected:
  void SetUp() override { write_result(folder_ / "north site"); }
  [[nodiscard]] std::string path(std::string_view name) const { return (folder_ / name).string(); }
  TempFolder folder_;
};

TEST_F(InventoryCommand, EveryFieldHasItsUnitAndDefinition) {
  const auto run = cairn({"inventory", path("north site"), "-o", path("out"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto rows = table(folder_ / "out" / "inventory.csv");
  ASSERT_EQ(rows.size(), 4U);
  const Row& rock = rows.at("north-site-0003");
  EXPECT_EQ(rock.at("status"), "candidate");
  EXPECT_EQ(rock.at("grade"), "bounded");
  EXPECT_NEAR(*::cairn::base::parse_real(rock.at("alpha_min_deg")), 18.3346, 1e-4);
  EXPECT_EQ(rock.at("alpha_min_deg_p05"), "15");
  EXPECT_EQ(rock.at("alpha_min_deg_p95"), "21");
  EXPECT_EQ(rock.at("mass_kg"), "7800");
  EXPECT_EQ(rock.at("density_source"), "assumed");
  EXPECT_EQ(rock.at("dominant_uncertainty"), "contact");
  EXPECT_EQ(rock.at("support_polygon_from_com_wkt_z").substr(0, 11), "POLYGON Z (");
  EXPECT_NEAR(*::cairn::base::parse_real(rock.at("latitude_deg")), kLatitude, 1e-3);
  // Nothing that follows from alpha where the grade forbids it, and nothing of a rejected rock.
  for (const char* id : {"north-site-0008", "north-site-0012"})
    for (const char* column : {"alpha_min_deg", "alpha_min_deg_p50", "a_qs_g", "v_min_m_s", "barrier_j"})
      EXPECT_EQ(rows.at(id).at(column), "") << id << column;
  EXPECT_EQ(rows.at("north-site-0012").at("reasons"), "too_few_points");

  // Each column of each table: type, unit in the name or beside it, definition.
  io::CsvReader columns(folder_ / "out" / "columns.csv");
  std::size_t defined = 0;
  while (columns.next()) {
    EXPECT_NE(columns.text(columns.column("definition")), "") << columns.text(columns.column("column"));
    ++defined;
  }
  EXPECT_GT(defined, 150U);
  std::map<std::string, std::size_t> layers;
  for (const auto& layer : io::read_vector(folder_ / "out" / "inventory.gpkg"))
    layers[layer.name] = layer.features.size();
  EXPECT_EQ(layers.at("inventory"), 4U);
  EXPECT_EQ(layers.at("contacts"), 3U);
  EXPECT_EQ(layers.at("tipping_edges"), 2U);
  EXPECT_EQ(layers.at("tipping_by_azimuth"), 720U);
  for (const char* name : {"inventory.geojson", "inventory.kml", "index.html", "contact_sheet.svg", "grades.svg",
                           "rejects.svg", "map.svg", "rejects.csv", "run.json", "rocks/north-site-0003.json"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
  const auto json = io::read_json(folder_ / "out" / "rocks/north-site-0003.json");
  EXPECT_EQ(json.at("tipping_by_azimuth").size(), 360U);
  EXPECT_EQ(json.at("tipping_edges").as_array().at(0).at("barrier_j").as_real(), 0.8 * 7800);
  // Best grade first, then the most fragile; the rejected rock is not drawn.
  const std::string sheet = ::cairn::base::read_file(folder_ / "out" / "contact_sheet.svg");
  EXPECT_LT(sheet.find(">3</text>"), sheet.find(">7</text>"));
  EXPECT_LT(sheet.find(">7</text>"), sheet.find(">8</text>"));
  EXPECT_EQ(sheet.find(">12</text>"), std::string::npos);
}

TEST_F(InventoryCommand, NotesJoinByIdAndByNearestPosition) {
  ::cairn::base::write_file(folder_ / "notes.csv",
                            "id,lat,lon,observed_utc,name,status,density,Soil depth\n"
                            "3,,,2025-05-01,The Needle,standing,2700,deep\n"
                            "north-site-0003,,,2026-06-01T10:00:00Z,,removed,,\n"
                            ",46.843015,-91.993284,2026-06-01,Second,standing,,\n"  // rock 7 is at 25 E, 4 N
                            ",46.850000,-91.993000,2026-06-01,Nowhere,,,\n");
  const auto run = cairn({"inventory", path("north site"), "--notes", path("notes.csv"), "-o", path("out"), "--json"});
  EXPECT_EQ(run.exit_code, 3) << run.err;  // one note could not be joined
  EXPECT_THAT(run.out, HasSubstr("\"with_field_notes\": 2"));
  const auto rows = table(folder_ / "out" / "inventory.csv");
  const Row& needle = rows.at("north-site-0003");
  EXPECT_EQ(needle.at("name"), "The Needle");
  EXPECT_EQ(needle.at("field_status"), "removed");  // the later note counts
  EXPECT_EQ(needle.at("note_match"), "id");
  EXPECT_EQ(needle.at("field_notes"), "2");
  EXPECT_EQ(needle.at("note_soil_depth"), "deep");
  EXPECT_EQ(needle.at("density_kg_m3"), "2700");
  EXPECT_EQ(needle.at("density_source"), "field");
  EXPECT_EQ(needle.at("mass_kg"), "8100");
  EXPECT_NEAR(*::cairn::base::parse_real(needle.at("mass_kg_p50")), 8100.0, 1e-6);
  const Row& second = rows.at("north-site-0007");
  EXPECT_EQ(second.at("name"), "Second");
  EXPECT_EQ(second.at("note_match"), "position");
  EXPECT_LT(*::cairn::base::parse_real(second.at("note_distance_m")), 0.2);

  const auto bad = [&](const std::string& text) {
    ::cairn::base::write_file(folder_ / "notes.csv", text);
    const auto result = cairn({"inventory", path("north site"), "--notes", path("notes.csv"), "-o", path("bad")});
    EXPECT_EQ(result.exit_code, 4) << text;
    EXPECT_FALSE(fs::exists(folder_ / "bad"));
    return result.err;
  };
  EXPECT_THAT(bad("id,name\n99,x\n"), HasSubstr("not in the inventory"));
  EXPECT_THAT(bad("id,density\n3,heavy\n"), HasSubstr("line 2, column density"));
  EXPECT_THAT(bad("name\nx\n"), HasSubstr("nothing joins the notes"));
  EXPECT_THAT(bad("id,lat,lon\n,46.8,\n"), HasSubstr("half a position"));
  EXPECT_THAT(bad("id,observed_utc\n3,May\n"), HasSubstr("not a time"));
}

// Everything under a folder, as one text: file names, and contents but for the geometry inside the GeoPackage.
std::string everything(const fs::path& folder) {
  std::string text;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    text += entry.path().lexically_relative(folder).string() + "\n";
    if (entry.is_regular_file()) text += ::cairn::base::read_file(entry.path()) + "\n";
  }
  return text;
}

TEST_F(InventoryCommand, ProtectLeavesNoTrace) {
  // The folder's name, the notes and the paths tell the place as well.
  const std::string secret = "site 46.842979 N 91.993612 W";
  write_result(folder_ / secret);
  ::cairn::base::write_file(folder_ / "notes.csv",
                            "id,access_note,field_note,name\n"
                            "3,turn left at the mill,\"at 46.842979, -91.993612; UTM 576720 5188112\","
                            "\"Rock at 46°50'34.7\"\" N\"\n");
  const auto open = cairn({"inventory", path(secret), "--notes", path("notes.csv"), "-o", path("open")});
  ASSERT_EQ(open.exit_code, 0) << open.err;
  EXPECT_THAT(everything(folder_ / "open"), HasSubstr("46.84"));
  const auto run =
      cairn({"inventory", path(secret), "--notes", path("notes.csv"), "--protect", "-o", path("public"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("PROTECTED"));
  const std::string all = everything(folder_ / "public");
  for (const char* trace :
       {"46.842", "46.843", "91.993", "91.994", "576720", "5188112", "turn left", "50'34", "198.25", "46-842979"})
    EXPECT_THAT(all, Not(HasSubstr(trace))) << trace;
  EXPECT_THAT(all, Not(HasSubstr(folder_.path().string())));
  EXPECT_FALSE(fs::exists(folder_ / "public" / "map.svg"));
  for (const auto& [id, row] : table(folder_ / "public" / "inventory.csv")) {
    EXPECT_EQ(row.at("coordinates_protected"), "true");
    EXPECT_EQ(row.at("east_m") + row.at("north_m") + row.at("up_m"), "");
    EXPECT_EQ(row.at("latitude_deg"), "46.84");
    EXPECT_EQ(row.at("longitude_deg"), "-91.99");
    EXPECT_EQ(row.at("height_m"), "200");
  }
  for (const auto& layer : io::read_vector(folder_ / "public" / "inventory.gpkg")) {
    EXPECT_NE(layer.name, "contacts");
    EXPECT_NE(layer.name, "photos");
    for (const auto& feature : layer.features)
      for (const auto& part : feature.parts)
        for (const auto& ring : part)
          for (const auto& p : ring) {
            EXPECT_NEAR(p.x(), -91.99, 1e-9);
            EXPECT_NEAR(p.y(), 46.84, 1e-9);
            EXPECT_EQ(p.z(), 200.0);
          }
  }
  // Every number in the map formats is one of the rounded ones.
  for (const char* name : {"inventory.geojson", "inventory.kml"}) {
    const std::string text = ::cairn::base::read_file(folder_ / "public" / name);
    const std::regex degrees("-?(46|91)\\.[0-9]+");
    for (auto it = std::sregex_iterator(text.begin(), text.end(), degrees); it != std::sregex_iterator(); ++it) {
      const double value = std::abs(std::stod(it->str()));
      EXPECT_TRUE(std::abs(value - 46.84) < 1e-9 || std::abs(value - 91.99) < 1e-9) << name << ": " << it->str();
    }
  }
}

TEST_F(InventoryCommand, IdsAreUniqueAndPersistentOverSurveys) {
  write_result(folder_ / "south", 500.0);
  write_result(folder_ / "again", 0.2);  // the north site, flown again: every rock 20 cm beside
  const auto two = cairn({"inventory", path("north site"), path("south"), "-o", path("both"), "--json"});
  ASSERT_EQ(two.exit_code, 0) << two.err;
  EXPECT_EQ(table(folder_ / "both" / "inventory.csv").size(), 8U);

  const auto again = cairn({"inventory", path("north site"), path("again"), "-o", path("revisit")});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(table(folder_ / "revisit" / "inventory.csv").at("again-0003").at("revisit_of"), "north-site-0003");

  // A new run of the same site keeps the ids of the inventory made before, whatever its numbers.
  const auto kept = cairn({"inventory", path("again"), "--previous", (folder_ / "both" / "inventory.csv").string(),
                           "-o", path("kept"), "--json"});
  ASSERT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_THAT(kept.out, HasSubstr("\"ids_kept\": 4"));
  const auto rows = table(folder_ / "kept" / "inventory.csv");
  EXPECT_EQ(rows.at("north-site-0003").at("aliases"), "again-0003");

  const auto clash = cairn({"inventory", path("north site"), path("north site") + "/", "-o", path("clash")});
  EXPECT_EQ(clash.exit_code, 4);
  EXPECT_THAT(clash.err, HasSubstr("--names"));
  const auto named =
      cairn({"inventory", path("north site"), path("north site"), "--names", "a", "--names", "b", "-o", path("named")});
  EXPECT_EQ(named.exit_code, 0) << named.err;
  const auto protectd = cairn({"inventory", path("south"), "--protect", "-o", path("public")});
  ASSERT_EQ(protectd.exit_code, 0);
  const auto refused = cairn(
      {"inventory", path("south"), "--previous", (folder_ / "public" / "inventory.csv").string(), "-o", path("x")});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_THAT(refused.err, HasSubstr("protected"));
  EXPECT_EQ(cairn({"inventory", path("nothing"), "-o", path("x")}).exit_code, 4);
}

TEST_F(InventoryCommand, SameInputsGiveTheSameBytes) {
  const auto one = cairn({"inventory", path("north site"), "--threads", "1", "-o", path("one")});
  const auto two = cairn({"inventory", path("north site"), "--threads", "2", "-o", path("two")});
  ASSERT_EQ(one.exit_code + two.exit_code, 0) << one.err << two.err;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "one")) {
    if (!entry.is_regular_file() || entry.path().filename() == "run.json") continue;
    const auto other = folder_ / "two" / entry.path().lexically_relative(folder_ / "one").string();
    EXPECT_EQ(::cairn::base::read_file(entry.path()), ::cairn::base::read_file(other)) << other;
  }
}

}  // namespace
