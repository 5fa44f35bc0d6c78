#include "io/packets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <limits>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/random.hpp"
#include "io/packet_bytes.hpp"
#include "support/data.hpp"

namespace {

using namespace cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

survey::Packet small_packet() {
  survey::Packet packet;
  packet.sequence = 7;
  packet.capture_time_ns = 1'234'567'890'123;
  survey::PacketObject cone;
  cone.position = {1.5, -2.25, 0.0};
  cone.covariance << 0.04, 0.01, 0.01, 0.09;
  cone.size_m = 0.38;
  cone.height_m = 0.7;
  cone.object_class = "cone";
  cone.score = 0.875;
  packet.objects.push_back(cone);
  packet.vehicles.push_back({{3.0, 4.0, 0.5}, 0.25 * geometry::Mat2::Identity()});
  packet.footprint = {{0, 0}, {4, 0}, {4, 3}};
  return packet;
}

survey::Packet random_packet(std::uint64_t seed) {
  base::Random random(seed, "packets_test", 0);
  survey::Packet packet;
  packet.sequence = static_cast<std::uint32_t>(random.bits());
  packet.capture_time_ns = static_cast<std::int64_t>(random.bits() >> 1);
  const auto covariance = [&] {
    geometry::Mat2 a;
    for (int i = 0; i < 4; ++i) a(i / 2, i % 2) = random.normal();
    geometry::Mat2 c = a * a.transpose();
    c(1, 0) = c(0, 1);
    return c;
  };
  const auto position = [&] { return geometry::Vec3(1e3 * random.normal(), 1e3 * random.normal(), random.normal()); };
  for (std::uint64_t i = random.below(20); i > 0; --i) {
    survey::PacketObject o{position(), covariance(), random.uniform(0, 3), random.uniform(0, 2), "", random.uniform()};
    for (std::uint64_t c = random.below(12); c > 0; --c) o.object_class += static_cast<char>('a' + random.below(26));
    packet.objects.push_back(o);
  }
  for (std::uint64_t i = random.below(4); i > 0; --i) packet.vehicles.push_back({position(), covariance()});
  for (std::uint64_t i = random.below(6); i > 0; --i) packet.footprint.emplace_back(position().head<2>());
  return packet;
}

void expect_equal(const survey::Packet& a, const survey::Packet& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.capture_time_ns, b.capture_time_ns);
  EXPECT_EQ(a.footprint, b.footprint);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].position, b.objects[i].position);
    EXPECT_EQ(a.objects[i].covariance, b.objects[i].covariance);
    EXPECT_EQ(a.objects[i].size_m, b.objects[i].size_m);
    EXPECT_EQ(a.objects[i].height_m, b.objects[i].height_m);
    EXPECT_EQ(a.objects[i].object_class, b.objects[i].object_class);
    EXPECT_EQ(a.objects[i].score, b.objects[i].score);
  }
  ASSERT_EQ(a.vehicles.size(), b.vehicles.size());
  for (std::size_t i = 0; i < a.vehicles.size(); ++i) {
    EXPECT_EQ(a.vehicles[i].position, b.vehicles[i].position);
    EXPECT_EQ(a.vehicles[i].covariance, b.vehicles[i].covariance);
  }
}

std::string reason_of(const std::vector<std::byte>& bytes) {
  const auto decoded = io::try_decode(bytes);
  const auto* reject = std::get_if<base::Reject>(&decoded);
  return reject ? reject->reason : "accepted";
}

// Puts the checksum of changed bytes right, so that the change itself is judged.
std::vector<std::byte> sealed(std::vector<std::byte> bytes) {
  const auto checked = std::span(bytes).first(bytes.size() - io::kChecksumBytes);
  const auto sum = io::packet_checksum(checked);
  std::memcpy(bytes.data() + checked.size(), &sum, sizeof(sum));
  return bytes;
}

template <typename T>
std::vector<std::byte> with(std::vector<std::byte> bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
  return sealed(std::move(bytes));
}

// The page docs/formats/packets.md as constants.
constexpr std::size_t kHeader = 32, kObject = 73, kVehicle = 48, kCorner = 16, kChecksum = 4;

TEST(Packets, ChecksumIsTheStandardOne) {
  const std::string_view check = "123456789";
  EXPECT_EQ(io::packet_checksum(std::as_bytes(std::span(check))), 0xCBF43926U);
}

TEST(Packets, BytesAreWhereThePageSays) {
  const auto bytes = io::encode(small_packet());
  ASSERT_EQ(bytes.size(), kHeader + kObject + 4 + kVehicle + 3 * kCorner + kChecksum);
  const auto at = [&](std::size_t offset, auto value) {
    decltype(value) found;
    std::memcpy(&found, bytes.data() + offset, sizeof(found));
    return found == value;
  };
  EXPECT_EQ(std::memcmp(bytes.data(), "CDPK", 4), 0);
  EXPECT_TRUE(at(4, std::uint16_t{1}));
  EXPECT_TRUE(at(8, static_cast<std::uint32_t>(bytes.size())));
  EXPECT_TRUE(at(12, std::uint32_t{7}));
  EXPECT_TRUE(at(16, std::int64_t{1'234'567'890'123}));
  EXPECT_TRUE(at(24, std::uint16_t{1}));
  EXPECT_TRUE(at(26, std::uint16_t{1}));
  EXPECT_TRUE(at(28, std::uint16_t{3}));
  EXPECT_TRUE(at(32, 1.5));
  EXPECT_TRUE(at(40, -2.25));
  EXPECT_TRUE(at(56, 0.04));
  EXPECT_TRUE(at(64, 0.01));
  EXPECT_TRUE(at(72, 0.09));
  EXPECT_TRUE(at(80, 0.38));
  EXPECT_TRUE(at(88, 0.7));
  EXPECT_TRUE(at(96, 0.875));
  EXPECT_TRUE(at(104, std::uint8_t{4}));
  EXPECT_EQ(std::memcmp(bytes.data() + 105, "cone", 4), 0);
  EXPECT_TRUE(at(109, 3.0));
}

TEST(Packets, RoundTripIsExactBothWays) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const auto packet = random_packet(seed);
    const auto bytes = io::encode(packet);
    const auto back = io::decode(bytes);
    expect_equal(back, packet);
    EXPECT_EQ(io::encode(back), bytes);
  }
}

TEST(Packets, EveryCutIsSeen) {
  const auto bytes = io::encode(small_packet());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_EQ(reason_of({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}), "truncated") << size;
}

TEST(Packets, EveryFlippedBitIsSeen) {
  const auto bytes = io::encode(small_packet());
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    auto broken = bytes;
    broken[bit / 8] ^= std::byte{1} << (bit % 8);
    EXPECT_NE(reason_of(broken), "accepted") << bit;
  }
}

TEST(Packets, WrongCountsAreSeen) {
  const auto bytes = io::encode(small_packet());
  for (const std::size_t field : {24U, 26U, 28U})
    for (const std::uint16_t count : {std::uint16_t{0}, std::uint16_t{2}, std::uint16_t{65535}})
      EXPECT_EQ(reason_of(with(bytes, field, count)), "wrong_count") << field << ' ' << count;
}

TEST(Packets, EachFaultHasItsReason) {
  const auto bytes = io::encode(small_packet());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(reason_of(with(bytes, 0, 'X')), "not_a_packet");
  EXPECT_EQ(reason_of(with(bytes, 4, std::uint16_t{2})), "unknown_version");
  EXPECT_EQ(reason_of(with(bytes, 30, std::uint16_t{1})), "not_a_packet");
  EXPECT_EQ(reason_of(with(bytes, 32, nan)), "not_finite");                                       // position
  EXPECT_EQ(reason_of(with(bytes, 56, nan)), "not_finite");                                       // covariance
  EXPECT_EQ(reason_of(with(bytes, 56, -0.04)), "out_of_range");                                   // variance
  EXPECT_EQ(reason_of(with(bytes, 64, 1.0)), "out_of_range");                                     // correlation above 1
  EXPECT_EQ(reason_of(with(bytes, 80, -1.0)), "out_of_range");                                    // size
  EXPECT_EQ(reason_of(with(bytes, 96, 1.5)), "out_of_range");                                     // score
  EXPECT_EQ(reason_of(with(bytes, 105, '\n')), "out_of_range");                                   // class
  EXPECT_EQ(reason_of(with(bytes, 109, std::numeric_limits<double>::infinity())), "not_finite");  // vehicle
  auto longer = bytes;
  longer.push_back(std::byte{0});
  EXPECT_EQ(reason_of(longer), "not_a_packet");
}

TEST(Packets, WhatCannotBeReadIsNotSent) {
  const auto refusal = [](auto change) {
    auto packet = small_packet();
    change(packet);
    try {
      static_cast<void>(io::encode(packet));
    } catch (const base::Error& e) {
      return e.code() == base::ErrorCode::invalid_argument ? std::string(e.what()) : "wrong code";
    }
    return std::string("sent");
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal([&](auto& p) { p.objects[0].covariance(0, 0) = nan; }), HasSubstr("covariance of object 0"));
  EXPECT_THAT(refusal([&](auto& p) { p.vehicles[0].position.x() = nan; }), HasSubstr("position of vehicle 0"));
  EXPECT_THAT(refusal([&](auto& p) { p.footprint[1].y() = nan; }), HasSubstr("footprint"));
  EXPECT_THAT(refusal([](auto& p) { p.objects.resize(65536); }), HasSubstr("65536 objects"));
  EXPECT_THAT(refusal([](auto& p) { p.objects[0].object_class.assign(256, 'x'); }), HasSubstr("256 bytes"));
}

class PacketFile : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::filesystem::path path_ = folder_ / "packets.bin";
  std::vector<survey::ReceivedPacket> packets_;

  void SetUp() override {
    for (std::uint64_t i = 0; i < 5; ++i)
      packets_.push_back({static_cast<std::int64_t>(i) * 500'000'000, random_packet(i)});
    io::write_packets(path_, packets_, base::TimeBase::gps);
  }
  [[nodiscard]] std::string content() const { return base::read_file(path_); }
  [[nodiscard]] io::PacketLog log_of(const std::string& content) const {
    base::write_file(path_, content);
    return io::read_packet_log(path_);
  }
  [[nodiscard]] std::string strict_refusal(const std::string& content) const {
    base::write_file(path_, content);
    try {
      static_cast<void>(io::read_packets(path_));
    } catch (const base::Error& e) {
      return e.what();
    }
    return "accepted";
  }
};

TEST_F(PacketFile, RoundTrip) {
  const auto log = io::read_packet_log(path_);
  EXPECT_EQ(log.time_base, base::TimeBase::gps);
  EXPECT_TRUE(log.rejects.empty());
  ASSERT_EQ(log.packets.size(), packets_.size());
  for (std::size_t i = 0; i < packets_.size(); ++i) {
    EXPECT_EQ(log.packets[i].arrival_time_ns, packets_[i].arrival_time_ns);
    expect_equal(log.packets[i].packet, packets_[i].packet);
  }
  const auto before = content();
  io::write_packets(path_, log.packets, log.time_base);
  EXPECT_EQ(content(), before);
}

TEST_F(PacketFile, ACutRecordingGivesItsWholePackets) {
  const auto whole = content();
  for (std::size_t size = 24; size < whole.size(); size += 7) {
    const auto log = log_of(whole.substr(0, size));
    EXPECT_LT(log.packets.size(), packets_.size());
    ASSERT_FALSE(log.rejects.empty());
    EXPECT_EQ(log.rejects.back().reason, "wrong_count");
    for (std::size_t i = 0; i < log.packets.size(); ++i) expect_equal(log.packets[i].packet, packets_[i].packet);
  }
  EXPECT_THAT(strict_refusal(whole.substr(0, whole.size() - 1)), HasSubstr("ends inside it"));
}

TEST_F(PacketFile, AWrongCountIsSeen) {
  auto more = content();
  more[16] = 9;
  const auto log = log_of(more);
  EXPECT_EQ(log.packets.size(), packets_.size());
  ASSERT_EQ(log.rejects.size(), 1U);
  EXPECT_EQ(log.rejects[0].reason, "wrong_count");
  EXPECT_THAT(strict_refusal(more), HasSubstr("says 9 packets, the file has 5"));
}

TEST_F(PacketFile, AFlippedBitCostsOneRecord) {
  auto broken = content();
  broken[24 + 12 + 16] ^= 1;  // in the first packet's capture time
  const auto log = log_of(broken);
  EXPECT_EQ(log.packets.size(), packets_.size() - 1);
  ASSERT_EQ(log.rejects.size(), 1U);
  EXPECT_EQ(log.rejects[0].reason, "bad_record_checksum");
  EXPECT_THAT(log.rejects[0].record, HasSubstr("packet 0 at byte 24"));
}

TEST_F(PacketFile, OtherFilesAreRefused) {
  const auto whole = content();
  EXPECT_THAT(strict_refusal(""), HasSubstr("not a recording of packets"));
  EXPECT_THAT(strict_refusal("time_ns,x_m\n1,2\n3,4\n5,6\n7,8\n"), HasSubstr("not a recording of packets"));
  auto version = whole;
  version[8] = 2;
  EXPECT_THAT(strict_refusal(version), HasSubstr("another version"));
  auto time_base = whole;
  time_base[10] = 9;
  EXPECT_THAT(strict_refusal(time_base), HasSubstr("unknown time base"));
}

}  // namespace
