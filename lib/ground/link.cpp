#include "ground/link.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"

namespace cairn::ground {
namespace {

constexpr double kNanoseconds = 1e9;

std::int64_t nanoseconds(double s) {
  return static_cast<std::int64_t>(std::llround(s * kNanoseconds));
}

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) / kNanoseconds;
}

LinkOptions resolved(LinkOptions o) {
  base::validate(base::bind_options(o), "link");
  // The next packet always waits (one is sent every 0.25 s), so that delays are the times between updates.
  if (o.profile == "football") o.low_s = 0.25, o.spread_s = 0.255, o.high_s = 1.68, o.stall_share = 0.0;
  if (o.profile == "park") o.low_s = 0.25, o.spread_s = 0.08, o.high_s = 3.1, o.stall_share = 0.008;
  if (o.profile == "ideal") o.low_s = o.spread_s = o.high_s = o.stall_share = 0.0;
  if (o.low_s > o.high_s)
    throw base::Error(base::ErrorCode::invalid_argument, "the link's least delay is above its greatest")
        .found("link-low-s " + std::to_string(o.low_s))
        .allowed("at most link-high-s " + std::to_string(o.high_s));
  if (o.outage_s > 0.0 && o.outage_every_s <= o.outage_s)
    throw base::Error(base::ErrorCode::invalid_argument, "the link's outages are longer than their interval")
        .found("link-outage-s " + std::to_string(o.outage_s))
        .allowed("less than link-outage-every-s " + std::to_string(o.outage_every_s));
  return o;
}

// The profile's delay: an exponential cut at `high`, by inversion, so that one number is drawn.
double delay_s(const LinkOptions& o, base::Random& random) {
  const double share = random.uniform(), u = random.uniform();
  if (share < o.stall_share) return o.low_s + u * (o.high_s - o.low_s);
  if (!(o.spread_s > 0.0)) return o.low_s;
  const double cut = -std::expm1(-(o.high_s - o.low_s) / o.spread_s);
  return o.low_s - o.spread_s * std::log1p(-u * cut);
}

}  // namespace

void LinkOptions::visit(base::OptionVisitor& v) {
  v.choice("link-profile", profile, {"football", "park", "ideal", "own"}, "delays of the link: as measured, or own");
  v.real("link-low-s", low_s, 0.0, 3600.0, "profile own: least delay");
  v.real("link-spread-s", spread_s, 0.0, 3600.0, "profile own: mean of the exponential above it");
  v.real("link-high-s", high_s, 0.0, 3600.0, "profile own: greatest delay");
  v.real("link-stall-share", stall_share, 0.0, 1.0, "profile own: share of delays uniform between least and greatest");
  v.real("link-bandwidth-bit-s", bandwidth_bit_s, 1.0, 1e12, "bandwidth of the link");
  v.real("link-latency-s", latency_s, 0.0, 3600.0, "added to each packet");
  v.real("link-loss", loss, 0.0, 1.0, "share of the packets that never arrive");
  v.real("link-reordering", reordering, 0.0, 1.0, "share of the packets that are overtaken");
  v.real("link-reordering-delay-s", reordering_delay_s, 0.0, 3600.0, "how much later those arrive");
  v.real("link-outage-every-s", outage_every_s, 0.0, 1e6, "one outage in each such interval; 0 = never");
  v.real("link-outage-s", outage_s, 0.0, 1e6, "length of an outage");
  v.integer("link-queue", queue, 1, 1000000, "packets that wait; the oldest gives way");
}

Link::Link(const LinkOptions& options, std::uint64_t seed) : options_(resolved(options)), seed_(seed) {
  base::Random random(seed, "link outage", 0);
  outage_offset_s_ = random.uniform(0.0, std::max(0.0, options_.outage_every_s - options_.outage_s));
}

double Link::outage_phase_s(std::int64_t time_ns) const {
  const double since = seconds(time_ns - first_ns_.value_or(time_ns)) - outage_offset_s_;
  return since < 0.0 ? since : std::fmod(since, options_.outage_every_s);
}

void Link::run(std::int64_t now_ns) {
  const bool outages = options_.outage_s > 0.0;
  while (!waiting_.empty()) {
    const std::int64_t start_ns = std::max(free_ns_, waiting_.front().ready_ns);
    if (start_ns > now_ns) return;
    const double phase = outages ? outage_phase_s(start_ns) : 0.0;
    if (outages && phase >= 0.0 && phase < options_.outage_s) {
      // At least a nanosecond on: the phase is a double.
      free_ns_ = start_ns + std::max<std::int64_t>(1, nanoseconds(options_.outage_s - phase));
      continue;
    }
    survey::Packet packet = std::move(waiting_.front().packet);
    waiting_.pop_front();
    base::Random random(seed_, "link", carried_++);
    const std::size_t bytes = packet_bytes(packet);
    double taken =
        options_.latency_s + 8.0 * static_cast<double>(bytes) / options_.bandwidth_bit_s + delay_s(options_, random);
    // An outage on the way holds it up.
    if (outages) {
      const double next = phase < 0.0 ? -phase : options_.outage_every_s - phase;
      if (taken > next) taken += options_.outage_s;
    }
    free_ns_ = start_ns + nanoseconds(taken);
    const bool lost = random.uniform() < options_.loss, overtaken = random.uniform() < options_.reordering;
    if (lost) {
      ++counts_.lost;
      continue;
    }
    ++counts_.delivered;
    counts_.bytes += bytes;
    survey::ReceivedPacket received{free_ns_, std::move(packet)};
    if (overtaken) received.arrival_time_ns += nanoseconds(options_.reordering_delay_s);
    const auto place = std::upper_bound(arriving_.begin(), arriving_.end(), received, [](const auto& a, const auto& b) {
      return a.arrival_time_ns < b.arrival_time_ns;
    });
    arriving_.insert(place, std::move(received));
  }
}

void Link::send(const survey::Packet& packet, std::int64_t now_ns) {
  if (!first_ns_) {
    first_ns_ = now_ns;
    free_ns_ = now_ns;
  }
  run(now_ns - 1);
  ++counts_.sent;
  waiting_.push_back({now_ns, packet});
  while (waiting_.size() > static_cast<std::size_t>(options_.queue) + (free_ns_ <= now_ns ? 1U : 0U)) {
    waiting_.pop_front();
    ++counts_.replaced;
  }
  run(now_ns);
}

std::vector<survey::ReceivedPacket> Link::receive(std::int64_t now_ns) {
  run(now_ns);
  const auto end = std::upper_bound(arriving_.begin(), arriving_.end(), now_ns,
                                    [](std::int64_t now, const auto& r) { return now < r.arrival_time_ns; });
  std::vector<survey::ReceivedPacket> out(std::make_move_iterator(arriving_.begin()), std::make_move_iterator(end));
  arriving_.erase(arriving_.begin(), end);
  return out;
}

std::size_t packet_bytes(const survey::Packet& packet) {
  // docs/formats/packets.md; a test compares it with io::encode.
  constexpr std::size_t kHeaderAndChecksum = 36, kObject = 73, kVehicle = 48, kCorner = 16;
  std::size_t bytes = kHeaderAndChecksum + kVehicle * packet.vehicles.size() + kCorner * packet.footprint.size();
  for (const auto& o : packet.objects) bytes += kObject + o.object_class.size();
  return bytes;
}

std::vector<survey::ReceivedPacket> replay(const std::vector<survey::ReceivedPacket>& packets,
                                           const LinkOptions& options, std::uint64_t seed, LinkCounts* counts) {
  std::vector<const survey::Packet*> sent;
  sent.reserve(packets.size());
  for (const auto& p : packets) sent.push_back(&p.packet);
  std::stable_sort(sent.begin(), sent.end(),
                   [](const auto* a, const auto* b) { return a->capture_time_ns < b->capture_time_ns; });
  Link link(options, seed);
  std::vector<survey::ReceivedPacket> arrived;
  const auto take = [&](std::int64_t now_ns) {
    for (auto& r : link.receive(now_ns)) arrived.push_back(std::move(r));
  };
  for (const auto* p : sent) {
    take(p->capture_time_ns);
    link.send(*p, p->capture_time_ns);
  }
  // Whatever still waits comes in the end.
  constexpr double kLongest_s = 1e5;
  if (!sent.empty()) take(sent.back()->capture_time_ns + nanoseconds(kLongest_s));
  if (counts != nullptr) *counts = link.counts();
  return arrived;
}

UpdatePeriods update_periods(const std::vector<survey::ReceivedPacket>& packets) {
  UpdatePeriods out;
  if (packets.size() < 2) return out;
  std::vector<std::int64_t> arrival;
  double age = 0.0;
  for (const auto& p : packets) {
    arrival.push_back(p.arrival_time_ns);
    const double own = seconds(p.arrival_time_ns - p.packet.capture_time_ns);
    age += own;
    out.max_age_s = std::max(out.max_age_s, own);
  }
  out.mean_age_s = age / static_cast<double>(packets.size());
  std::sort(arrival.begin(), arrival.end());
  std::vector<double> periods;
  for (std::size_t i = 1; i < arrival.size(); ++i) periods.push_back(seconds(arrival[i] - arrival[i - 1]));
  std::sort(periods.begin(), periods.end());
  out.count = periods.size();
  out.mean_s = seconds(arrival.back() - arrival.front()) / static_cast<double>(periods.size());
  out.median_s = periods[periods.size() / 2];
  out.max_s = periods.back();
  return out;
}

}  // namespace cairn::ground
