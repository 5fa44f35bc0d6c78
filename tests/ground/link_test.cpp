#include "ground/link.hpp"

#include <gtest/gtest.h>

#include <set>

#include "base/error.hpp"
#include "io/packets.hpp"

namespace {

using namespace cairn;
using ground::Link;
using ground::LinkOptions;

constexpr std::int64_t kSecond = 1'000'000'000;

survey::Packet packet_at(std::int64_t capture_ns, std::uint32_t sequence) {
  survey::Packet p;
  p.sequence = sequence;
  p.capture_time_ns = capture_ns;
  p.vehicles.push_back({{1, 2, 0}, geometry::Mat2::Identity()});
  return p;
}

// Packets every 0.25 s, as the paper's projector sends them.
std::vector<survey::ReceivedPacket> driven(const LinkOptions& options, double duration_s, std::uint64_t seed,
                                           ground::LinkCounts* counts = nullptr) {
  std::vector<survey::ReceivedPacket> packets;
  const auto end = static_cast<std::int64_t>(duration_s * 1e9);
  for (std::int64_t t = 0; t < end; t += kSecond / 4)
    packets.push_back({t, packet_at(t, static_cast<std::uint32_t>(packets.size()))});
  return ground::replay(packets, options, seed, counts);
}

LinkOptions profile(const char* name) {
  LinkOptions o;
  o.profile = name;
  return o;
}

TEST(Link, FootballHasThePapersPeriods) {
  constexpr double kMean = 0.02, kLongest = 1.7;  // s; 2400 updates have a mean within 0.01, and take 1 ms to send
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const auto p = ground::update_periods(driven(profile("football"), 1200.0, seed));
    EXPECT_NEAR(p.mean_s, 0.5, kMean);
    EXPECT_LE(p.max_s, kLongest);
    EXPECT_GT(p.max_s, 1.2);
    EXPECT_GT(p.mean_age_s, p.mean_s);
  }
}

TEST(Link, ParkHasThePapersPeriods) {
  constexpr double kMean = 0.02, kLongest = 3.12;  // s
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const auto p = ground::update_periods(driven(profile("park"), 1200.0, seed));
    EXPECT_NEAR(p.mean_s, 0.34, kMean);
    EXPECT_LE(p.max_s, kLongest);
    EXPECT_GT(p.max_s, 2.0);
  }
}

TEST(Link, EveryPacketIsAccountedFor) {
  auto options = profile("football");
  options.loss = 0.2;
  ground::LinkCounts counts;
  const auto arrived = driven(options, 600.0, 5, &counts);
  EXPECT_EQ(counts.sent, 2400U);
  EXPECT_EQ(counts.delivered, arrived.size());
  EXPECT_EQ(counts.sent, counts.delivered + counts.lost + counts.replaced);
  constexpr double kShare = 0.04;  // of about 1200 packets, 3 sigma
  EXPECT_NEAR(static_cast<double>(counts.lost) / static_cast<double>(counts.lost + counts.delivered), 0.2, kShare);
  EXPECT_EQ(counts.bytes, arrived.size() * ground::packet_bytes(arrived.front().packet));
}

TEST(Link, ArrivalsAscendAndAreNotBeforeCapture) {
  auto options = profile("park");
  options.reordering = 0.1;
  const auto arrived = driven(options, 300.0, 9);
  std::size_t overtaken = 0;
  std::set<std::uint32_t> seen;
  for (std::size_t i = 0; i < arrived.size(); ++i) {
    EXPECT_GT(arrived[i].arrival_time_ns, arrived[i].packet.capture_time_ns);
    EXPECT_TRUE(seen.insert(arrived[i].packet.sequence).second);
    if (i == 0) continue;
    EXPECT_GE(arrived[i].arrival_time_ns, arrived[i - 1].arrival_time_ns);
    overtaken += arrived[i].packet.sequence < arrived[i - 1].packet.sequence ? 1U : 0U;
  }
  EXPECT_GT(overtaken, 10U);
}

TEST(Link, SameSeedSameArrivalsOnlineAndInReplay) {
  const auto options = profile("football");
  const auto whole = driven(options, 60.0, 3);
  Link link(options, 3);
  std::vector<survey::ReceivedPacket> online;
  // Asked every 10 ms, as a closed loop does.
  for (std::int64_t t = 0; t < 100 * kSecond; t += kSecond / 100) {
    if (t < 60 * kSecond && t % (kSecond / 4) == 0)
      link.send(packet_at(t, static_cast<std::uint32_t>(t / (kSecond / 4))), t);
    for (auto& r : link.receive(t)) {
      EXPECT_LE(r.arrival_time_ns, t);
      online.push_back(r);
    }
  }
  ASSERT_EQ(online.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(online[i].arrival_time_ns, whole[i].arrival_time_ns);
    EXPECT_EQ(online[i].packet.sequence, whole[i].packet.sequence);
  }
  const auto other = driven(options, 60.0, 4);
  EXPECT_NE(other.front().arrival_time_ns, whole.front().arrival_time_ns);
}

TEST(Link, BandwidthDelays) {
  auto options = profile("ideal");
  options.bandwidth_bit_s = 8e3;  // a byte a millisecond
  const auto arrived = driven(options, 0.2, 1);
  ASSERT_EQ(arrived.size(), 1U);
  EXPECT_EQ(arrived[0].arrival_time_ns, static_cast<std::int64_t>(ground::packet_bytes(arrived[0].packet)) * 1'000'000);
}

TEST(Link, OutagesAreSilent) {
  auto options = profile("football");
  options.outage_every_s = 60.0;
  options.outage_s = 10.0;
  const auto p = ground::update_periods(driven(options, 1200.0, 2));
  EXPECT_GE(p.max_s, 10.0);
  EXPECT_LE(p.max_s, 10.0 + 2 * 1.7);  // the update that is held up, and its own delay
  const auto without = ground::update_periods(driven(profile("football"), 1200.0, 2));
  EXPECT_NEAR(static_cast<double>(p.count) / static_cast<double>(without.count), 50.0 / 60.0, 0.05);
}

TEST(Link, PacketBytesAreTheCodecs) {
  survey::Packet p = packet_at(0, 1);
  EXPECT_EQ(ground::packet_bytes(p), io::encode(p).size());
  p.footprint = {{0, 0}, {1, 0}, {0, 1}};
  for (int i = 0; i < 20; ++i) {
    survey::PacketObject o;
    o.object_class = "boulder";
    p.objects.push_back(o);
  }
  EXPECT_EQ(ground::packet_bytes(p), io::encode(p).size());
}

TEST(Link, OptionsThatContradictAreRefused) {
  auto options = profile("own");
  options.low_s = 1.0;
  EXPECT_THROW(Link(options, 0), base::Error);
  options = profile("football");
  options.outage_s = 5.0;
  EXPECT_THROW(Link(options, 0), base::Error);
  options = profile("radio");
  EXPECT_THROW(Link(options, 0), base::Error);
}

}  // namespace
