#include "io/vector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "io/geojson.hpp"
#include "io/json.hpp"
#include "io/kml.hpp"
#include "io/layer_csv.hpp"
#include "support/command.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Geodetic;
using geometry::Vec3;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const geodesy::LocalFrame kFrame({46.842979, -91.993612, 198.0});

Layer rocks() {
  Layer layer;
  layer.name = "rocks";
  layer.title = "Candidate rocks";
  layer.height_type = survey::HeightType::ellipsoidal;
  layer.columns = {{"id", ColumnType::integer, "", "Id of the rock"},
                   {"name", ColumnType::text, "", "Name"},
                   {"size_m", ColumnType::real, "m", "Length"},
                   {"assumed", ColumnType::boolean, "", "Whether the contact was assumed"}};
  const std::vector<Vec3> places{{0, 0, 0}, {120.5, -40.25, 1.5}, {-300, 200, 12}};
  const auto positions = to_geodetic(kFrame, places);
  layer.features = {{{{{positions[0]}}}, {std::int64_t{0}, "plain", 1.25, true}},
                    {{{{positions[1]}}}, {std::int64_t{7}, "O'Brien \"<&>\", =2+3", {}, false}},
                    {{{{positions[2]}}}, {std::int64_t{12}, "=cmd()", std::nan(""), {}}}};
  LayerStyle style;
  style.name = "by name";
  style.column = "name";
  style.classes = {{"plain", "Plain & simple", {10, 20, 30, 255}}};
  layer.style = style;
  return layer;
}

Layer gaps() {
  Layer layer;
  layer.name = "gaps";
  layer.kind = GeometryKind::polygon;
  layer.height_type = survey::HeightType::ellipsoidal;
  layer.columns = {{"id", ColumnType::integer, "", "Id"}};
  // The outer ring clockwise on purpose; the hole counter-clockwise.
  const geometry::Ring outer{{0, 0}, {0, 10}, {10, 10}, {10, 0}};
  const geometry::Ring hole{{4, 4}, {6, 4}, {6, 6}, {4, 6}};
  layer.features = {{{{to_geodetic(kFrame, outer, 0.0), to_geodetic(kFrame, hole, 0.0)}}, {std::int64_t{1}}},
                    {{}, {std::int64_t{2}}}};
  layer.style = LayerStyle{};
  return layer;
}

Layer flight() {
  Layer layer;
  layer.name = "flight";
  layer.kind = GeometryKind::line;
  layer.with_heights = false;
  layer.columns = {{"id", ColumnType::integer, "", "Id"}};
  const std::vector<Vec3> path{{0, 0, 30}, {50, 0, 30}, {50, 20, 31}};
  layer.features = {{{{to_geodetic(kFrame, path)}}, {std::int64_t{1}}}};
  return layer;
}

std::string error_of(base::ErrorCode code, const std::function<void()>& act) {
  try {
    act();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "no error";
}

TEST(GeoPackage, RoundTrip) {
  constexpr double kToleranceDeg = 1e-14;  // stored as doubles
  const testing::TempFolder folder;
  write_geopackage(folder / "layers.gpkg", {rocks(), gaps(), flight()});
  const auto layers = read_vector(folder / "layers.gpkg");
  ASSERT_EQ(layers.size(), 3U);
  const Layer expected = rocks();
  const ForeignLayer& found = layers[0];
  EXPECT_EQ(found.name, "rocks");
  EXPECT_EQ(found.kind, GeometryKind::point);
  EXPECT_EQ(geodesy::describe_crs(found.crs).authority_code, "EPSG:4326");
  EXPECT_THAT(found.rejects, IsEmpty());
  ASSERT_EQ(found.columns.size(), expected.columns.size());
  for (std::size_t c = 0; c < found.columns.size(); ++c) {
    EXPECT_EQ(found.columns[c].name, expected.columns[c].name);
    EXPECT_EQ(found.columns[c].type, expected.columns[c].type);
    EXPECT_EQ(found.columns[c].unit, expected.columns[c].unit);
    EXPECT_EQ(found.columns[c].definition, expected.columns[c].definition);
  }
  ASSERT_EQ(found.features.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const Geodetic& g = expected.features[i].parts[0][0][0];
    const Vec3& p = found.features[i].parts[0][0][0];
    EXPECT_NEAR(p.x(), g.longitude_deg, kToleranceDeg);
    EXPECT_NEAR(p.y(), g.latitude_deg, kToleranceDeg);
    EXPECT_EQ(p.z(), g.height_m);
  }
  EXPECT_EQ(found.features[1].values, expected.features[1].values);
  EXPECT_EQ(found.features[2].values[2], Value()) << "a number that is not finite must not be written";
  EXPECT_EQ(layers[1].features[0].parts[0].size(), 2U);
  EXPECT_EQ(layers[1].features[0].parts[0][1].size(), 4U);
  EXPECT_THAT(layers[1].features[1].parts, IsEmpty());
  EXPECT_EQ(layers[2].features[0].parts[0][0].size(), 3U);
  EXPECT_EQ(vector_info(folder / "layers.gpkg")[0].feature_count, 3U);
}

TEST(GeoPackage, SameBytesAndNothingBeside) {
  const testing::TempFolder folder;
  write_geopackage(folder / "a.gpkg", {rocks(), gaps(), flight()});
  write_geopackage(folder / "b.gpkg", {rocks(), gaps(), flight()});
  const std::string bytes = base::read_file(folder / "a.gpkg");
  EXPECT_EQ(bytes, base::read_file(folder / "b.gpkg"));
  // Bytes 18 and 19: 1 = rollback journal, 2 = WAL.
  EXPECT_EQ(bytes[18], 1);
  EXPECT_EQ(bytes[19], 1);
  (void)read_vector(folder / "a.gpkg");
  EXPECT_EQ(bytes, base::read_file(folder / "a.gpkg"));
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_THAT(names, ElementsAre("a.gpkg", "b.gpkg"));
}

TEST(GeoPackage, OgrinfoAgreesWithoutWarning) {
  const testing::TempFolder folder;
  const std::string file = (folder / "layers.gpkg").string();
  write_geopackage(file, {rocks(), gaps(), flight()});
  const auto info = testing::run_command("ogrinfo -ro -al " + file);
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.text, Not(HasSubstr("Warning")));
  EXPECT_THAT(info.text, Not(HasSubstr("ERROR")));
  for (const char* expected : {"Layer name: rocks", "Geometry: 3D Point", "3D Polygon", "Geometry: Line String",
                               "OGRFeature(rocks):1", "OGRFeature(rocks):3", "FID Column = fid",
                               "Geometry Column = geom", "ID[\"EPSG\",4326]", "assumed: Integer(Boolean)"})
    EXPECT_THAT(info.text, HasSubstr(expected));
}

TEST(GeoPackage, TablesForQgisArePinned) {
  const testing::TempFolder folder;
  const std::string file = (folder / "layers.gpkg").string();
  write_geopackage(file, {rocks(), gaps(), flight()});
  const auto sql = [&](const std::string& query) {
    return testing::run_command("ogrinfo -ro -q -sql \"" + query + "\" " + file).text;
  };
  EXPECT_THAT(sql("SELECT DISTINCT last_change FROM gpkg_contents"), HasSubstr("2000/01/01 00:00:00"));
  EXPECT_THAT(sql("SELECT count(DISTINCT last_change) AS n FROM gpkg_contents"), HasSubstr("n (Integer) = 1"));
  const std::string styles = sql("SELECT * FROM layer_styles");
  for (const char* expected :
       {"f_table_catalog (String) = ", "f_table_schema (String) = ", "f_table_name (String) = rocks",
        "f_table_name (String) = gaps", "f_geometry_column (String) = geom", "styleName (String) = by name",
        "styleQML (String) = <!DOCTYPE qgis", "styleSLD", "useAsDefault (Integer(Boolean)) = 1", "description", "owner",
        "ui (String)", "update_time (DateTime) = 2000/01/01 00:00:00"})
    EXPECT_THAT(styles, HasSubstr(expected));
  EXPECT_THAT(styles, Not(HasSubstr("f_table_name (String) = flight"))) << "no style was given";
  EXPECT_THAT(sql("SELECT unit FROM cairn_columns WHERE name = 'size_m'"), HasSubstr("unit (String) = m"));
  EXPECT_THAT(sql("SELECT extension_name FROM gpkg_extensions"), HasSubstr("gpkg_rtree_index"));
}

TEST(GeoPackage, RefusesBadLayers) {
  const testing::TempFolder folder;
  const auto refuse = [&](const std::function<void(Layer&)>& change, const char* word) {
    Layer layer = rocks();
    change(layer);
    EXPECT_THAT(error_of(base::ErrorCode::invalid_argument, [&] { write_geopackage(folder / "x.gpkg", {layer}); }),
                HasSubstr(word));
  };
  refuse([](Layer& l) { l.name = "rocks\"; DROP TABLE"; }, "layer name");
  refuse([](Layer& l) { l.columns[0].name = "fid"; }, "taken");
  refuse([](Layer& l) { l.columns[1].name = "id"; }, "taken");
  refuse([](Layer& l) { l.features[1].values.pop_back(); }, "one value a column");
  refuse([](Layer& l) { l.features[1].values[0] = 1.0; }, "another type");
  refuse([](Layer& l) { l.features[1].parts[0][0][0].latitude_deg = 95.0; }, "feature 2");
  refuse([](Layer& l) { l.features[1].parts[0][0][0].height_m = std::nan(""); }, "feature 2");
  refuse([](Layer& l) { l.kind = GeometryKind::polygon; }, "no polygon");
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument,
                       [&] {
                         write_geopackage(folder / "x.gpkg", {rocks(), rocks()});
                       }),
              HasSubstr("two layers"));
  EXPECT_NE(
      error_of(base::ErrorCode::resource_exhausted, [&] { write_geopackage(folder / "absent/x.gpkg", {rocks()}); }),
      "no error");
  EXPECT_FALSE(std::filesystem::exists(folder / "x.gpkg"));
  for (const auto& write : std::vector<std::function<void()>>{
           [] { write_geopackage("/dev/full", {rocks()}); }, [] { write_geojson("/dev/full", rocks()); },
           [] { write_layer_csv("/dev/full", rocks()); }, [] { write_kml("/dev/full", {rocks()}, "x"); }})
    EXPECT_NE(error_of(base::ErrorCode::resource_exhausted, write), "no error");
}

TEST(LayerStyle, QmlIsWellFormed) {
  const testing::TempFolder folder;
  for (const GeometryKind kind : {GeometryKind::point, GeometryKind::line, GeometryKind::polygon}) {
    LayerStyle style = *rocks().style;
    style.label_column = "name";
    base::write_file(folder / "style.qml", qml(style, kind));
    EXPECT_EQ(testing::run_command("xmllint --noout --nonet " + (folder / "style.qml").string()).text, "");
  }
  const std::string text = qml(*rocks().style, GeometryKind::point);
  for (const char* expected :
       {"categorizedSymbol\" attr=\"name\"", "label=\"Plain &amp; simple\"", "10,20,30,255", "class=\"SimpleMarker\""})
    EXPECT_THAT(text, HasSubstr(expected));
  EXPECT_EQ(qml(*rocks().style, GeometryKind::none), "");
}

TEST(GeoJson, FollowsTheRfc) {
  const testing::TempFolder folder;
  write_geojson(folder / "gaps.geojson", gaps());
  const Json json = read_json(folder / "gaps.geojson");
  EXPECT_EQ(json.find("crs"), nullptr);
  const auto& features = json.at("features").as_array();
  ASSERT_EQ(features.size(), 2U);
  EXPECT_TRUE(features[1].at("geometry").is_null());
  const auto& rings = features[0].at("geometry").at("coordinates").as_array();
  ASSERT_EQ(rings.size(), 2U);
  for (std::size_t r = 0; r < 2; ++r) {
    const auto& ring = rings[r].as_array();
    ASSERT_EQ(ring.size(), 5U);
    EXPECT_EQ(ring.front(), ring.back());
    double area = 0.0;
    for (std::size_t i = 0; i + 1 < ring.size(); ++i)
      area += ring[i].as_array()[0].as_real() * ring[i + 1].as_array()[1].as_real() -
              ring[i + 1].as_array()[0].as_real() * ring[i].as_array()[1].as_real();
    EXPECT_EQ(area > 0.0, r == 0) << "outer rings are counter-clockwise, holes clockwise";
  }
  // Longitude first, 7 decimals, ellipsoidal height.
  EXPECT_THAT(geojson_text(rocks()), HasSubstr("\"coordinates\":[-91.9936120,46.8429790,198.000]"));
  Layer sea = rocks();
  sea.height_type = survey::HeightType::orthometric;
  EXPECT_THAT(geojson_text(sea), HasSubstr("\"coordinates\":[-91.9936120,46.8429790]"));
  const auto info = testing::run_command("ogrinfo -ro -al " + (folder / "gaps.geojson").string());
  EXPECT_THAT(info.text, Not(HasSubstr("Warning")));
  EXPECT_THAT(info.text, HasSubstr("Feature Count: 2"));
}

TEST(GeoJson, RefusesTheAntimeridian) {
  Layer layer = flight();
  layer.features[0].parts[0][0][1].longitude_deg = 179.9;
  EXPECT_THAT(error_of(base::ErrorCode::crs_mismatch, [&] { (void)geojson_text(layer); }), HasSubstr("antimeridian"));
}

TEST(LayerCsv, QuotesAndDefusesFormulas) {
  EXPECT_EQ(csv_text(rocks()),
            "id,name,size_m,assumed\n"
            "0,plain,1.25,true\n"
            "7,\"O'Brien \"\"<&>\"\", =2+3\",,false\n"
            "12,'=cmd(),,\n");
}

TEST(Kml, HeightsBecomeSeaLevel) {
  const testing::TempFolder folder;
  const double undulation = geodesy::geoid_undulation("egm96", kFrame.origin());
  EXPECT_LT(undulation, -25.0);
  write_kml(folder / "rocks.kml", {rocks(), gaps(), flight()}, "survey & rocks");
  const std::string text = base::read_file(folder / "rocks.kml");
  EXPECT_EQ(testing::run_command("xmllint --noout --nonet " + (folder / "rocks.kml").string()).text, "");
  char expected[64] = {};
  std::snprintf(expected, sizeof expected, "-91.993612000,46.842979000,%.3f", 198.0 - undulation);
  EXPECT_THAT(text, HasSubstr(expected));
  EXPECT_THAT(text, HasSubstr("converted from ellipsoidal"));
  EXPECT_THAT(text, HasSubstr("survey &amp; rocks"));
  EXPECT_THAT(text, HasSubstr("<color>ff1e140a</color>")) << "aabbggrr";
  const auto info = testing::run_command("ogrinfo -ro -al " + (folder / "rocks.kml").string());
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.text, Not(HasSubstr("Warning")));
  EXPECT_THAT(info.text, HasSubstr("Layer name: gaps"));

  Layer unknown = rocks();
  unknown.height_type = survey::HeightType::relative_takeoff;
  const std::string clamped = kml_text({unknown}, "x");
  EXPECT_THAT(clamped, HasSubstr("clampToGround"));
  EXPECT_THAT(clamped, HasSubstr("relative_takeoff, which KML cannot place"));
  EXPECT_THAT(clamped, Not(HasSubstr("46.842979000,")));
  Layer sea = rocks();
  sea.height_type = survey::HeightType::orthometric;
  sea.geoid = "egm96";
  EXPECT_THAT(kml_text({sea}, "x"), HasSubstr("46.842979000,198.000"));
}

TEST(ReadVector, RealShapefiles) {
  // 24 outlines drawn in degrees although their neighbours are in UTM: the CRS has to be read.
  const auto layers = read_vector(testing::test_data("granite_dells/country_rock.shp"));
  ASSERT_EQ(layers.size(), 1U);
  EXPECT_EQ(layers[0].kind, GeometryKind::polygon);
  EXPECT_EQ(layers[0].features.size() + layers[0].rejects.size(), layers[0].feature_count);
  EXPECT_EQ(layers[0].feature_count, 24U);
  EXPECT_TRUE(geodesy::describe_crs(layers[0].crs).geographic);
  const Vec3 p = layers[0].features[0].parts[0][0][0];
  EXPECT_NEAR(p.x(), -112.4, 0.5);
  EXPECT_NEAR(p.y(), 34.6, 0.5);
}

TEST(ReadVector, OtherSources) {
  const testing::TempFolder folder;
  write_geojson(folder / "gaps.geojson", gaps());
  const auto json = read_vector(folder / "gaps.geojson");
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json[0].features[0].parts[0].size(), 2U);
  EXPECT_NE(json[0].crs, "");
  // Mixed kinds: the first decides, the others are told.
  base::write_file(folder / "mixed.geojson", R"({"type":"FeatureCollection","features":[
    {"type":"Feature","properties":{"a":1},"geometry":{"type":"Point","coordinates":[1,2]}},
    {"type":"Feature","properties":{"a":2},"geometry":{"type":"LineString","coordinates":[[1,2],[3,4]]}},
    {"type":"Feature","properties":{"a":3},"geometry":{"type":"MultiPoint","coordinates":[[1,2],[3,4]]}}]})");
  const auto mixed = read_vector(folder / "mixed.geojson");
  EXPECT_EQ(mixed[0].features.size(), 2U);
  EXPECT_EQ(mixed[0].features[1].parts.size(), 2U);
  ASSERT_EQ(mixed[0].rejects.size(), 1U);
  EXPECT_EQ(mixed[0].rejects[0].reason, "other_geometry_kind");
}

TEST(ReadVector, RefusesBadFiles) {
  const testing::TempFolder folder;
  EXPECT_NE(error_of(base::ErrorCode::not_found, [&] { (void)read_vector(folder / "absent.gpkg"); }), "no error");
  EXPECT_NE(error_of(base::ErrorCode::not_found, [&] { (void)read_vector("http://example.org/a.geojson"); }),
            "no error");
  base::write_file(folder / "noise.gpkg", "not a database");
  EXPECT_NE(error_of(base::ErrorCode::invalid_input, [&] { (void)read_vector(folder / "noise.gpkg"); }), "no error");
  base::write_file(folder / "trap.geojson",
                   "<OGRVRTDataSource><OGRVRTLayer name=\"a\"><SrcDataSource>/etc/passwd</SrcDataSource></OGRVRTLayer>"
                   "</OGRVRTDataSource>");
  EXPECT_NE(error_of(base::ErrorCode::invalid_input, [&] { (void)read_vector(folder / "trap.geojson"); }), "no error");

  write_geopackage(folder / "good.gpkg", {rocks()});
  const std::string good = base::read_file(folder / "good.gpkg");
  for (const std::size_t size : {good.size() / 4, good.size() / 2, good.size() - 5000}) {
    base::write_file(folder / "short.gpkg", good.substr(0, size));
    EXPECT_NE(error_of(base::ErrorCode::invalid_input, [&] { (void)read_vector(folder / "short.gpkg"); }), "no error")
        << size;
  }
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input,
                       [&] {
                         (void)read_vector(folder / "good.gpkg", {2, 100});
                       }),
              HasSubstr("limit"));
  base::write_file(folder / "good.gpkg-wal", "unfinished");
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input, [&] { (void)read_vector(folder / "good.gpkg"); }),
              HasSubstr("-wal"));
}

}  // namespace
}  // namespace cairn::io
