#include "io/packets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/packet_bytes.hpp"

namespace cairn::io {
namespace {

constexpr std::array<char, 4> kMagic{'C', 'D', 'P', 'K'};
constexpr std::size_t kMaxCount = std::numeric_limits<std::uint16_t>::max();
constexpr std::size_t kMaxClass = std::numeric_limits<std::uint8_t>::max();
// A covariance may miss positive semi-definiteness by the rounding of its producer.
constexpr double kCorrelationSlack = 1e-9;

struct Fault {
  const char* reason;
  std::string message;
};

Fault not_finite(std::string what) {
  return {"not_finite", std::move(what) + " is not a finite number"};
}

std::optional<Fault> covariance_fault(const geometry::Mat2& c, const std::string& what) {
  if (!c.allFinite()) return not_finite("covariance of " + what);
  const double xy = 0.5 * (c(0, 1) + c(1, 0));
  if (c(0, 0) < 0.0 || c(1, 1) < 0.0 || xy * xy > c(0, 0) * c(1, 1) * (1.0 + kCorrelationSlack))
    return Fault{"out_of_range", "covariance of " + what + " is not positive semi-definite: xx " +
                                     base::to_text(c(0, 0)) + ", xy " + base::to_text(xy) + ", yy " +
                                     base::to_text(c(1, 1))};
  return std::nullopt;
}

std::optional<Fault> object_fault(const survey::PacketObject& o, const std::string& what) {
  if (!o.position.allFinite()) return not_finite("position of " + what);
  if (auto fault = covariance_fault(o.covariance, what)) return fault;
  if (!std::isfinite(o.size_m) || !std::isfinite(o.height_m)) return not_finite("size of " + what);
  if (!std::isfinite(o.score)) return not_finite("score of " + what);
  if (o.size_m < 0.0 || o.height_m < 0.0)
    return Fault{"out_of_range", "size of " + what + " is negative: width " + base::to_text(o.size_m) + " m, height " +
                                     base::to_text(o.height_m) + " m"};
  if (o.score < 0.0 || o.score > 1.0)
    return Fault{"out_of_range", "score of " + what + " is " + base::to_text(o.score) + ", allowed 0 to 1"};
  if (o.object_class.size() > kMaxClass)
    return Fault{"out_of_range", "class of " + what + " has " + std::to_string(o.object_class.size()) +
                                     " bytes, allowed " + std::to_string(kMaxClass)};
  if (std::any_of(o.object_class.begin(), o.object_class.end(),
                  [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }))
    return Fault{"out_of_range", "class of " + what + " has control characters"};
  return std::nullopt;
}

// What keeps a packet from being sent, and from being taken.
std::optional<Fault> content_fault(const survey::Packet& packet) {
  const auto too_many = [](const char* what, std::size_t count) -> Fault {
    return {"out_of_range", std::to_string(count) + " " + what + ", allowed " + std::to_string(kMaxCount)};
  };
  if (packet.objects.size() > kMaxCount) return too_many("objects", packet.objects.size());
  if (packet.vehicles.size() > kMaxCount) return too_many("vehicles", packet.vehicles.size());
  if (packet.footprint.size() > kMaxCount) return too_many("footprint corners", packet.footprint.size());
  for (std::size_t i = 0; i < packet.objects.size(); ++i)
    if (auto fault = object_fault(packet.objects[i], "object " + std::to_string(i))) return fault;
  for (std::size_t i = 0; i < packet.vehicles.size(); ++i) {
    const auto what = "vehicle " + std::to_string(i);
    if (!packet.vehicles[i].position.allFinite()) return not_finite("position of " + what);
    if (auto fault = covariance_fault(packet.vehicles[i].covariance, what)) return fault;
  }
  for (const auto& corner : packet.footprint)
    if (!corner.allFinite()) return not_finite("a footprint corner");
  return std::nullopt;
}

void append_position(std::vector<std::byte>& out, const geometry::Vec3& position, const geometry::Mat2& covariance) {
  for (int a = 0; a < 3; ++a) append_le(out, position[a]);
  append_le(out, covariance(0, 0));
  // Equal elements stay as they are: (a + a) / 2 is a.
  append_le(out, 0.5 * (covariance(0, 1) + covariance(1, 0)));
  append_le(out, covariance(1, 1));
}

// Steps through bytes that may be too few; `short_` then stays set and zeros come back.
class Cursor {
 public:
  explicit Cursor(Bytes bytes) : bytes_(bytes) {}

  template <typename T>
  T take() {
    if (!has(sizeof(T))) return T{};
    const T value = load_le<T>(bytes_.data() + position_);
    position_ += sizeof(T);
    return value;
  }
  std::string take_text(std::size_t count) {
    if (!has(count)) return {};
    std::string text(reinterpret_cast<const char*>(bytes_.data() + position_), count);
    position_ += count;
    return text;
  }
  void take_position(geometry::Vec3& position, geometry::Mat2& covariance) {
    for (int a = 0; a < 3; ++a) position[a] = take<double>();
    covariance(0, 0) = take<double>();
    covariance(0, 1) = covariance(1, 0) = take<double>();
    covariance(1, 1) = take<double>();
  }
  [[nodiscard]] bool ran_out() const { return short_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }

 private:
  bool has(std::size_t count) {
    if (remaining() < count) short_ = true;
    return !short_;
  }
  Bytes bytes_;
  std::size_t position_ = 0;
  bool short_ = false;
};

std::optional<Fault> frame_fault(Bytes bytes) {
  if (bytes.size() < kMinPacketBytes)
    return Fault{"truncated",
                 std::to_string(bytes.size()) + " bytes, the shortest packet has " + std::to_string(kMinPacketBytes)};
  if (std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return Fault{"not_a_packet", "does not start with CDPK"};
  const auto version = load_le<std::uint16_t>(bytes.data() + 4);
  if (version != kPacketVersion)
    return Fault{"unknown_version",
                 "version " + std::to_string(version) + ", known is " + std::to_string(kPacketVersion)};
  const auto length = load_le<std::uint32_t>(bytes.data() + 8);
  if (length > bytes.size())
    return Fault{"truncated", std::to_string(bytes.size()) + " bytes of " + std::to_string(length)};
  if (length < bytes.size())
    return Fault{"not_a_packet", std::to_string(bytes.size() - length) + " bytes behind its stated length"};
  if (load_le<std::uint16_t>(bytes.data() + 6) != 0 || load_le<std::uint16_t>(bytes.data() + 30) != 0)
    return Fault{"not_a_packet", "reserved bytes are not zero"};
  const auto checked = bytes.first(bytes.size() - kChecksumBytes);
  if (load_le<std::uint32_t>(bytes.data() + checked.size()) != packet_checksum(checked))
    return Fault{"bad_checksum", "its checksum is not that of its bytes"};
  return std::nullopt;
}

}  // namespace

std::vector<std::byte> encode(const survey::Packet& packet) {
  if (const auto fault = content_fault(packet))
    throw base::Error(base::ErrorCode::invalid_argument, "packet cannot be sent: " + fault->message)
        .record("packet " + std::to_string(packet.sequence));
  std::vector<std::byte> out;
  for (const char c : kMagic) append_le(out, c);
  append_le(out, static_cast<std::uint16_t>(kPacketVersion));
  append_le(out, std::uint16_t{0});
  append_le(out, std::uint32_t{0});  // length, set below
  append_le(out, packet.sequence);
  append_le(out, packet.capture_time_ns);
  append_le(out, static_cast<std::uint16_t>(packet.objects.size()));
  append_le(out, static_cast<std::uint16_t>(packet.vehicles.size()));
  append_le(out, static_cast<std::uint16_t>(packet.footprint.size()));
  append_le(out, std::uint16_t{0});
  for (const auto& o : packet.objects) {
    append_position(out, o.position, o.covariance);
    append_le(out, o.size_m);
    append_le(out, o.height_m);
    append_le(out, o.score);
    append_le(out, static_cast<std::uint8_t>(o.object_class.size()));
    for (const char c : o.object_class) append_le(out, c);
  }
  for (const auto& v : packet.vehicles) append_position(out, v.position, v.covariance);
  for (const auto& corner : packet.footprint) {
    append_le(out, corner.x());
    append_le(out, corner.y());
  }
  const auto length = static_cast<std::uint32_t>(out.size() + kChecksumBytes);
  std::memcpy(out.data() + 8, &length, sizeof(length));
  append_le(out, packet_checksum(out));
  return out;
}

std::variant<survey::Packet, base::Reject> try_decode(std::span<const std::byte> bytes, std::string_view record) {
  const auto reject = [&](const Fault& fault) {
    return base::Reject{std::string(record), fault.reason, std::string(record) + ": " + fault.message};
  };
  if (const auto fault = frame_fault(bytes)) return reject(*fault);
  Cursor cursor(bytes.subspan(12, bytes.size() - 12 - kChecksumBytes));
  survey::Packet packet;
  packet.sequence = cursor.take<std::uint32_t>();
  packet.capture_time_ns = cursor.take<std::int64_t>();
  const auto objects = cursor.take<std::uint16_t>(), vehicles = cursor.take<std::uint16_t>(),
             corners = cursor.take<std::uint16_t>();
  static_cast<void>(cursor.take<std::uint16_t>());
  for (std::size_t i = 0; i < objects && !cursor.ran_out(); ++i) {
    survey::PacketObject o;
    cursor.take_position(o.position, o.covariance);
    o.size_m = cursor.take<double>();
    o.height_m = cursor.take<double>();
    o.score = cursor.take<double>();
    o.object_class = cursor.take_text(cursor.take<std::uint8_t>());
    packet.objects.push_back(std::move(o));
  }
  for (std::size_t i = 0; i < vehicles && !cursor.ran_out(); ++i) {
    survey::PacketVehicle v;
    cursor.take_position(v.position, v.covariance);
    packet.vehicles.push_back(v);
  }
  for (std::size_t i = 0; i < corners && !cursor.ran_out(); ++i) {
    const double east = cursor.take<double>();
    packet.footprint.emplace_back(east, cursor.take<double>());
  }
  if (cursor.ran_out() || cursor.remaining() != 0)
    return reject({"wrong_count", "its counts (" + std::to_string(objects) + " objects, " + std::to_string(vehicles) +
                                      " vehicles, " + std::to_string(corners) + " corners) ask for " +
                                      (cursor.ran_out() ? "more" : "fewer") + " bytes than its " +
                                      std::to_string(bytes.size())});
  if (const auto fault = content_fault(packet)) return reject(*fault);
  return packet;
}

survey::Packet decode(std::span<const std::byte> bytes) {
  auto decoded = try_decode(bytes);
  if (const auto* reject = std::get_if<base::Reject>(&decoded))
    throw base::Error(base::ErrorCode::invalid_input, reject->message).record(reject->record).found(reject->reason);
  return std::get<survey::Packet>(std::move(decoded));
}

}  // namespace cairn::io
