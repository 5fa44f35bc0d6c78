#include "io/records_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/atomic_file.hpp"
#include "base/random.hpp"
#include "io/obstacles_json.hpp"
#include "io/rocks_json.hpp"
#include "io/targets_json.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::HasSubstr;

const survey::Origin kFrame{{46.8426, -91.994, 158.0}, survey::HeightType::ellipsoidal, ""};

std::vector<double> reals(base::Random& random, std::size_t count) {
  std::vector<double> out(count);
  for (auto& value : out) value = random.normal();
  return out;
}
geometry::Vec3 vec3(base::Random& random) {
  return {random.normal(), random.normal(), random.normal()};
}
geometry::Mat3 mat3(base::Random& random) {
  geometry::Mat3 m;
  for (int i = 0; i < 9; ++i) m.data()[i] = random.normal() * 1e-3;
  return m;
}

survey::Target target(std::int64_t id, bool with_cylinder) {
  base::Random random(3, "target", static_cast<std::uint64_t>(id));
  survey::Target t;
  t.id = survey::TargetId(id);
  t.object_class = "boulder";
  t.state = survey::TargetState::deregistered;
  t.centre = vec3(random);
  t.covariance = mat3(random);
  t.detections = {survey::DetectionId(4), survey::DetectionId(8)};
  t.keyframes = {survey::FrameId(1), survey::FrameId(0)};
  if (with_cylinder) t.bcylinder = geometry::VerticalCylinder{{random.normal(), random.normal()}, -1.25, 2.1, 0.3};
  t.entropy_nats = reals(random, 3);
  t.divergence = reals(random, 2);
  t.reasons = {"too_few_boxes", "\xC3\xA9"};
  t.mean_score = random.uniform();
  t.history = {{survey::TargetState::generated, survey::FrameId(0)},
               {survey::TargetState::deregistered, survey::FrameId(12)}};
  if (with_cylinder) {
    survey::RefinedBody r;
    r.centre = vec3(random);
    r.covariance = mat3(random);
    r.cylinder = {{random.normal(), random.normal()}, -2.5, 0.125, 0.7};
    r.semi_axes_m = vec3(random);
    r.azimuth_deg = 12.75;
    r.rms_px = random.uniform();
    r.boxes = 17;
    r.rejected_boxes = 2;
    t.refined = r;
  }
  return t;
}

void expect_same(const survey::Target& a, const survey::Target& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.object_class, b.object_class);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.centre, b.centre);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.detections, b.detections);
  EXPECT_EQ(a.keyframes, b.keyframes);
  ASSERT_EQ(a.bcylinder.has_value(), b.bcylinder.has_value());
  if (a.bcylinder) {
    EXPECT_EQ(a.bcylinder->axis, b.bcylinder->axis);
    EXPECT_EQ(a.bcylinder->bottom, b.bcylinder->bottom);
    EXPECT_EQ(a.bcylinder->top, b.bcylinder->top);
    EXPECT_EQ(a.bcylinder->radius, b.bcylinder->radius);
  }
  EXPECT_EQ(a.entropy_nats, b.entropy_nats);
  EXPECT_EQ(a.divergence, b.divergence);
  EXPECT_EQ(a.reasons, b.reasons);
  EXPECT_EQ(a.mean_score, b.mean_score);
  EXPECT_EQ(a.history, b.history);
  ASSERT_EQ(a.refined.has_value(), b.refined.has_value());
  if (a.refined) {
    EXPECT_EQ(a.refined->centre, b.refined->centre);
    EXPECT_EQ(a.refined->covariance, b.refined->covariance);
    EXPECT_EQ(a.refined->cylinder.axis, b.refined->cylinder.axis);
    EXPECT_EQ(a.refined->cylinder.bottom, b.refined->cylinder.bottom);
    EXPECT_EQ(a.refined->cylinder.top, b.refined->cylinder.top);
    EXPECT_EQ(a.refined->cylinder.radius, b.refined->cylinder.radius);
    EXPECT_EQ(a.refined->semi_axes_m, b.refined->semi_axes_m);
    EXPECT_EQ(a.refined->azimuth_deg, b.refined->azimuth_deg);
    EXPECT_EQ(a.refined->rms_px, b.refined->rms_px);
    EXPECT_EQ(a.refined->boxes, b.refined->boxes);
    EXPECT_EQ(a.refined->rejected_boxes, b.refined->rejected_boxes);
  }
}

TEST(TargetsJson, RoundTripsBitForBit) {
  const testing::TempFolder folder;
  const TargetsFile written{kFrame, {target(0, true), target(7, false)}};
  write_targets(folder / "targets.json", written);
  const TargetsFile read = read_targets(folder / "targets.json");
  EXPECT_EQ(read.frame.position, kFrame.position);
  EXPECT_EQ(read.frame.height_type, kFrame.height_type);
  ASSERT_EQ(read.targets.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) expect_same(read.targets[i], written.targets[i]);
  ASSERT_NE(read.find(survey::TargetId(7)), nullptr);
  EXPECT_EQ(read.find(survey::TargetId(1)), nullptr);
}

TEST(TargetsJson, HasTheMembersOtherProgramsReadByName) {
  const Json json = to_json(target(5, true));
  for (const auto* key : {"id", "class", "state", "centre_m", "covariance_m2", "detections", "bcylinder", "reasons"})
    EXPECT_NE(json.find(key), nullptr) << key;
  EXPECT_EQ(json.at("id").as_integer(), 5);
  EXPECT_EQ(json.at("centre_m").as_array().size(), 3U);
}

TEST(TargetsJson, NonFiniteNumbersAreNotWritten) {
  const testing::TempFolder folder;
  survey::Target bad = target(1, true);
  bad.covariance(1, 2) = std::nan("");
  EXPECT_THROW(write_targets(folder / "targets.json", {kFrame, {bad}}), base::Error);
  bad = target(1, true);
  bad.entropy_nats[0] = HUGE_VAL;
  EXPECT_THROW(write_targets(folder / "targets.json", {kFrame, {bad}}), base::Error);
}

std::string refusal(const std::string& text) {
  const testing::TempFolder folder;
  base::write_file(folder / "targets.json", text);
  try {
    (void)read_targets(folder / "targets.json");
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_THAT(error.file(), HasSubstr("targets.json"));
    return error.what();
  }
  return "accepted";
}

TEST(TargetsJson, RefusesBadFiles) {
  const std::string good =
      Json::object(
          {{"schema_version", 1}, {"frame", to_json(kFrame)}, {"targets", Json(Json::Array{to_json(target(1, true))})}})
          .dump(0);
  EXPECT_EQ(refusal(good), "accepted");
  const auto edited = [&](const std::string& find, const std::string& replace) {
    std::string text = good;
    const auto at = text.find(find);
    EXPECT_NE(at, std::string::npos) << find;
    return text.replace(at, find.size(), replace);
  };
  EXPECT_THAT(refusal(edited("\"schema_version\":1", "\"schema_version\":2")), HasSubstr("schema version"));
  EXPECT_THAT(refusal(edited("deregistered", "lost")), AllOf(HasSubstr("'lost'"), HasSubstr("target 1 of the list")));
  EXPECT_THAT(refusal(edited("\"id\":1", "\"id\":-1")), HasSubstr("negative"));
  EXPECT_THAT(refusal(edited("\"centre_m\":[", "\"centre_m\":[1,")), HasSubstr("3 numbers"));
  EXPECT_THAT(refusal(edited("\"covariance_m2\":[", "\"covariance_m2\":[[1,2,3],")), HasSubstr("matrix"));
  EXPECT_THAT(refusal(edited("\"radius_m\":", "\"radius_m\":-")), HasSubstr("inside out"));
  EXPECT_THAT(refusal("[]"), HasSubstr("wrong kind"));
  EXPECT_THAT(refusal(good.substr(0, good.size() / 2)), HasSubstr("not valid JSON"));
}

survey::TippingEdge edge(base::Random& random) {
  const auto v = reals(random, 9);
  return {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], {vec3(random), vec3(random)}, random.uniform()};
}

// A value of its own for every member of the tipping record.
void fill(survey::Tipping& t, base::Random& random) {
  t.critical = edge(random);
  t.contact_observed_share = 0.71;
  t.contact_pads = 3;
  t.contact_slope_rad = 0.11;
  t.contact_aspect_deg = 222.5;
  t.edges = {edge(random), edge(random)};
  t.edges[1].a_qs_g = t.edges[1].v_min_m_s = HUGE_VAL;  // passes above the centre of mass
  t.alpha_point_rad = 0.37;
  t.a_qs_min_g = 0.21;
  t.a_qs_min_azimuth_deg = 14.25;
  t.inner = survey::TippingBound{"inner", "", edge(random), reals(random, 360)};
  t.outer = survey::TippingBound{"rim", "line_contact", std::nullopt, {}};
  t.friction = 0.65;
  t.slides_first = true;
  t.without_pad = {{"pad 2", 2.0, "", 0.2, 15.0}, {"pad 3", 3.0, "not_in_equilibrium", std::nullopt, std::nullopt}};
  t.gaps = {{"gap 0.02 m", 0.02, "", 0.25, 95.0}};
  t.photo_views = {{30.0, 0.3, 0.4, 1.1, 1.2}};
  t.rolling = survey::RollingContact{0.9, 1.5, -0.25, true};
  survey::TippingUncertainty u;
  u.draws = 1000;
  u.standing = 998;
  u.slides_first_share = 0.125;
  u.scalars = {{"alpha_min_deg", {1, 2, 3, 4, 5}}, {"mass_kg", {6, 7, 8, 9, 10}}};
  for (auto& level : u.a_qs_g_by_azimuth) level = reals(random, 360);
  u.rose = reals(random, 36);
  u.variance_shares = {{"contact", 0.75}, {"vertical", 0.25}};
  u.variance_shares_bearing = {{"hidden_bearing", 1.0}};
  u.inputs = {{"vertical_sigma_deg", 0.5}};
  u.draws_file = "12_draws.csv";
  t.uncertainty = u;
}

// Spot checks beside the comparison of texts, which a member missing from both directions would pass.
void expect_filled(const survey::Tipping& a, const survey::Tipping& b) {
  EXPECT_EQ(a.contact_observed_share, b.contact_observed_share);
  EXPECT_EQ(a.contact_pads, b.contact_pads);
  EXPECT_EQ(a.contact_slope_rad, b.contact_slope_rad);
  EXPECT_EQ(a.contact_aspect_deg, b.contact_aspect_deg);
  ASSERT_EQ(a.edges.size(), b.edges.size());
  EXPECT_EQ(a.edges[0].ends, b.edges[0].ends);
  EXPECT_EQ(a.edges[0].inertia_m2, b.edges[0].inertia_m2);
  EXPECT_EQ(a.edges[0].barrier_j_kg, b.edges[0].barrier_j_kg);
  EXPECT_EQ(a.edges[0].inclination_rad, b.edges[0].inclination_rad);
  EXPECT_EQ(a.edges[0].critical_share, b.edges[0].critical_share);
  EXPECT_EQ(a.edges[1].a_qs_g, b.edges[1].a_qs_g);
  EXPECT_EQ(a.alpha_point_rad, b.alpha_point_rad);
  EXPECT_EQ(a.a_qs_min_g, b.a_qs_min_g);
  EXPECT_EQ(a.a_qs_min_azimuth_deg, b.a_qs_min_azimuth_deg);
  ASSERT_TRUE(a.inner && a.inner->critical && a.outer);
  EXPECT_EQ(a.inner->critical->alpha_rad, b.inner->critical->alpha_rad);
  EXPECT_EQ(a.inner->a_qs_g_by_azimuth, b.inner->a_qs_g_by_azimuth);
  EXPECT_EQ(a.outer->reason, b.outer->reason);
  EXPECT_FALSE(a.outer->critical);
  EXPECT_EQ(a.friction, b.friction);
  EXPECT_TRUE(a.slides_first);
  ASSERT_EQ(a.without_pad.size(), 2U);
  EXPECT_EQ(a.without_pad[0].alpha_rad, b.without_pad[0].alpha_rad);
  EXPECT_EQ(a.without_pad[1].reason, b.without_pad[1].reason);
  ASSERT_EQ(a.gaps.size(), 1U);
  EXPECT_EQ(a.gaps[0].azimuth_deg, b.gaps[0].azimuth_deg);
  ASSERT_EQ(a.photo_views.size(), 1U);
  EXPECT_EQ(a.photo_views[0].r_right_m, b.photo_views[0].r_right_m);
  ASSERT_TRUE(a.rolling);
  EXPECT_EQ(a.rolling->pedestal_curvature_1_m, b.rolling->pedestal_curvature_1_m);
  ASSERT_TRUE(a.uncertainty);
  ASSERT_NE(a.uncertainty->find("mass_kg"), nullptr);
  EXPECT_EQ(a.uncertainty->find("mass_kg")->p84, 9.0);
  EXPECT_EQ(a.uncertainty->find("none"), nullptr);
  EXPECT_EQ(a.uncertainty->rose, b.uncertainty->rose);
  EXPECT_EQ(a.uncertainty->a_qs_g_by_azimuth, b.uncertainty->a_qs_g_by_azimuth);
  EXPECT_EQ(a.uncertainty->standing, b.uncertainty->standing);
  EXPECT_EQ(a.uncertainty->variance_shares[1].value, 0.25);
  ASSERT_EQ(a.uncertainty->variance_shares_bearing.size(), 1U);
  EXPECT_EQ(a.uncertainty->draws_file, b.uncertainty->draws_file);
}

TEST(RocksJson, RoundTripsBitForBit) {
  const testing::TempFolder folder;
  base::Random random(5, "rock", 0);
  survey::Rock rock;
  rock.target = survey::TargetId(12);
  rock.object_class = "boulder";
  rock.point_count = 281;
  rock.point_spacing_m = random.uniform();
  rock.size_m = vec3(random);
  rock.base_height_m = random.normal();
  rock.length_azimuth_deg = 179.99999999999997;
  rock.cap = survey::CapModel::plane;
  rock.unseen_area_fraction = 0.37;
  rock.mass = geometry::MassProperties{random.uniform(), vec3(random), mat3(random), random.uniform()};
  rock.hull_volume_m3 = random.uniform();
  rock.density_kg_m3 = 2670.0;
  rock.density_assumed = false;
  rock.tipping.grade = survey::Grade::screening;
  rock.tipping.reasons = {"contact_assumed"};
  rock.tipping.contact = {vec3(random), vec3(random), vec3(random)};
  rock.tipping.contact_assumed = true;
  rock.tipping.a_qs_g_by_azimuth = reals(random, 360);
  rock.noise_m = 0.004;
  rock.cap_height_sigma_m = 0.03;
  rock.shape_ratios = {{"hwr_axis", 2.4}, {"hwr_upright", 1.9}};
  rock.name = "Balanced Rock";
  rock.aliases = {survey::TargetId(3)};
  rock.supersedes = {survey::TargetId(4), survey::TargetId(5)};
  rock.review = "accept";
  fill(rock.tipping, random);
  survey::Rock rejected;
  rejected.target = survey::TargetId(13);
  rejected.rejected = true;
  rejected.reasons = {"too_few_points"};
  write_rocks(folder / "rocks.json", {kFrame, {rock, rejected}});
  const auto read = read_rocks(folder / "rocks.json").rocks;
  ASSERT_EQ(read.size(), 2U);
  const survey::Rock& r = read[0];
  EXPECT_EQ(r.target, rock.target);
  EXPECT_EQ(r.object_class, rock.object_class);
  EXPECT_EQ(r.point_count, rock.point_count);
  EXPECT_EQ(r.point_spacing_m, rock.point_spacing_m);
  EXPECT_EQ(r.size_m, rock.size_m);
  EXPECT_EQ(r.base_height_m, rock.base_height_m);
  EXPECT_EQ(r.length_azimuth_deg, rock.length_azimuth_deg);
  EXPECT_EQ(r.cap, rock.cap);
  EXPECT_EQ(r.unseen_area_fraction, rock.unseen_area_fraction);
  ASSERT_TRUE(r.mass);
  EXPECT_EQ(r.mass->volume, rock.mass->volume);
  EXPECT_EQ(r.mass->centre_of_mass, rock.mass->centre_of_mass);
  EXPECT_EQ(r.mass->inertia_per_density, rock.mass->inertia_per_density);
  EXPECT_EQ(r.mass->area, rock.mass->area);
  EXPECT_EQ(r.hull_volume_m3, rock.hull_volume_m3);
  EXPECT_EQ(r.density_kg_m3, rock.density_kg_m3);
  EXPECT_EQ(r.density_assumed, rock.density_assumed);
  EXPECT_EQ(r.tipping.grade, rock.tipping.grade);
  EXPECT_EQ(r.tipping.reasons, rock.tipping.reasons);
  EXPECT_EQ(r.tipping.contact, rock.tipping.contact);
  EXPECT_EQ(r.tipping.contact_assumed, rock.tipping.contact_assumed);
  ASSERT_TRUE(r.tipping.critical);
  EXPECT_EQ(r.tipping.critical->azimuth_deg, rock.tipping.critical->azimuth_deg);
  EXPECT_EQ(r.tipping.critical->alpha_rad, rock.tipping.critical->alpha_rad);
  EXPECT_EQ(r.tipping.critical->r_m, rock.tipping.critical->r_m);
  EXPECT_EQ(r.tipping.critical->p_rad_s, rock.tipping.critical->p_rad_s);
  EXPECT_EQ(r.tipping.critical->a_qs_g, rock.tipping.critical->a_qs_g);
  EXPECT_EQ(r.tipping.critical->v_min_m_s, rock.tipping.critical->v_min_m_s);
  EXPECT_EQ(r.tipping.a_qs_g_by_azimuth, rock.tipping.a_qs_g_by_azimuth);
  EXPECT_EQ(r.noise_m, rock.noise_m);
  EXPECT_EQ(r.cap_height_sigma_m, rock.cap_height_sigma_m);
  ASSERT_EQ(r.shape_ratios.size(), 2U);
  EXPECT_EQ(r.shape_ratios[1].name, "hwr_upright");
  EXPECT_EQ(r.shape_ratios[1].value, 1.9);
  EXPECT_EQ(r.name, rock.name);
  EXPECT_EQ(r.aliases, rock.aliases);
  EXPECT_EQ(r.supersedes, rock.supersedes);
  EXPECT_EQ(r.review, rock.review);
  // Every member was given a value of its own, so the same text means the same record.
  EXPECT_EQ(to_json(r).dump(), to_json(rock).dump());
  expect_filled(r.tipping, rock.tipping);
  EXPECT_FALSE(r.rejected);
  EXPECT_TRUE(read[1].rejected);
  EXPECT_EQ(read[1].reasons, rejected.reasons);
  EXPECT_FALSE(read[1].mass);
  EXPECT_FALSE(read[1].tipping.critical);
}

TEST(ObstaclesJson, RoundTripsBitForBit) {
  const testing::TempFolder folder;
  survey::Obstacle o;
  o.target = survey::TargetId(2);
  o.object_class = "car";
  o.kind = survey::ObstacleKind::vehicle;
  o.position = {1.1, -2.2, 3.3};
  o.covariance << 0.01, 0.002, 0.002, 0.03;
  o.width_m = 4.2;
  o.height_m = 1.5;
  o.score = 0.1;
  o.observations = 6;
  o.misses = 2;
  o.first_seen_ns = 1'466'699'519'000'000'000;
  o.last_seen_ns = 1'466'699'520'250'000'000;
  o.sigma_width_m = 0.05;
  o.sigma_height_m = 0.07;
  o.velocity = geometry::Vec2(0.4, -0.1);
  o.velocity_covariance << 0.001, 0.0, 0.0, 0.002;
  write_obstacles(folder / "obstacles.json", {kFrame, {o}});
  const auto read = read_obstacles(folder / "obstacles.json").obstacles;
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].target, o.target);
  EXPECT_EQ(read[0].object_class, o.object_class);
  EXPECT_EQ(read[0].kind, o.kind);
  EXPECT_EQ(read[0].position, o.position);
  EXPECT_EQ(read[0].covariance, o.covariance);
  EXPECT_EQ(read[0].width_m, o.width_m);
  EXPECT_EQ(read[0].height_m, o.height_m);
  EXPECT_EQ(read[0].score, o.score);
  EXPECT_EQ(read[0].observations, o.observations);
  EXPECT_EQ(read[0].misses, o.misses);
  EXPECT_EQ(read[0].first_seen_ns, o.first_seen_ns);
  EXPECT_EQ(read[0].last_seen_ns, o.last_seen_ns);
  EXPECT_EQ(read[0].sigma_width_m, o.sigma_width_m);
  EXPECT_EQ(read[0].sigma_height_m, o.sigma_height_m);
  EXPECT_EQ(read[0].velocity, o.velocity);
  EXPECT_EQ(read[0].velocity_covariance, o.velocity_covariance);
}

TEST(ObstaclesJson, RefusesWhatIsNoCovarianceOrSize) {
  const testing::TempFolder folder;
  survey::Obstacle o;
  o.target = survey::TargetId(1);
  o.covariance(0, 1) = o.covariance(1, 0) = std::nan("");
  EXPECT_THROW(write_obstacles(folder / "a.json", {kFrame, {o}}), base::Error);
  for (const double correlation : {1.5, -1.5}) {
    o.covariance << 1.0, correlation, correlation, 1.0;
    write_obstacles(folder / "b.json", {kFrame, {o}});
    EXPECT_THROW(static_cast<void>(read_obstacles(folder / "b.json")), base::Error);
  }
  o.covariance.setIdentity();
  o.width_m = -1.0;
  write_obstacles(folder / "c.json", {kFrame, {o}});
  EXPECT_THROW(static_cast<void>(read_obstacles(folder / "c.json")), base::Error);
}

TEST(RecordsJson, FilesOfAnotherLocalFrameAreRefused) {
  survey::Origin other = kFrame;
  EXPECT_NO_THROW(require_same_frame(other, kFrame, "targets.json"));
  other.position.height_m += 1.0;
  try {
    require_same_frame(other, kFrame, "targets.json");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::crs_mismatch);
  }
}

}  // namespace
}  // namespace cairn::io
