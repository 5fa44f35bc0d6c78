// The radio link between aircraft and ground vehicle: what delay, loss and order packets arrive with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/random.hpp"
#include "survey/packet.hpp"

namespace cairn::ground {

// One connection that carries one packet at a time, as TCP does, and always the newest that waits: paper B's link,
// whose measured figures are the times between two updates (B15, B16). An update takes latency + bytes / bandwidth + a
// delay of the profile: low + an exponential of mean `spread`, and rarely a stall, never longer than `high`.
struct LinkOptions {
  // football: updates every 0.5 s on average, 1.68 s at most; park: 0.34 s and 3.1 s; ideal: no delay of its own. All
  // for packets sent every 0.25 s. own: the fields below.
  std::string profile = "football";
  double low_s = 0.0, spread_s = 0.0, high_s = 0.0;  // of profile own
  double stall_share = 0.0;                          // of the packets, own: delays uniform between low and high

  double bandwidth_bit_s = 2e6;  // paper B's 802.11a link
  double latency_s = 0.0;        // added to each packet
  double loss = 0.0;             // share of the packets that never arrive (0: TCP repeats them)
  double reordering = 0.0;       // share of the packets that are overtaken: they take another way, later by
  double reordering_delay_s = 1.0;
  double outage_every_s = 0.0;  // nothing passes for outage_s, once in each such interval; 0 = never
  double outage_s = 0.0;
  std::int64_t queue = 1;  // packets that wait; the oldest is dropped for a new one

  void visit(base::OptionVisitor& visitor);
};

// What a link did so far.
struct LinkCounts {
  std::size_t sent = 0, delivered = 0, lost = 0, replaced = 0;  // replaced: dropped for a newer one
  std::size_t bytes = 0;                                        // delivered
};

// Deterministic: the same options, seed and calls give the same arrivals. Times must not descend.
class Link {
 public:
  // Throws invalid_argument where an option is out of range.
  Link(const LinkOptions& options, std::uint64_t seed);

  // A packet that is ready at now_ns.
  void send(const survey::Packet& packet, std::int64_t now_ns);
  // What has arrived up to now_ns and was not given before, by arrival time.
  [[nodiscard]] std::vector<survey::ReceivedPacket> receive(std::int64_t now_ns);
  [[nodiscard]] const LinkCounts& counts() const { return counts_; }

 private:
  struct Waiting {
    std::int64_t ready_ns;
    survey::Packet packet;
  };
  void run(std::int64_t now_ns);
  // Seconds since the last outage began, before the first: negative.
  [[nodiscard]] double outage_phase_s(std::int64_t time_ns) const;

  LinkOptions options_;
  std::uint64_t seed_;
  std::deque<Waiting> waiting_;
  std::vector<survey::ReceivedPacket> arriving_;  // ascending arrival
  std::optional<std::int64_t> first_ns_;          // of the first packet sent
  std::int64_t free_ns_ = 0;                      // when the connection can take the next packet
  double outage_offset_s_ = 0.0;                  // of the first outage behind first_ns_
  std::uint64_t carried_ = 0;
  LinkCounts counts_;
};

// Bytes of a packet on the link: the size that io::encode gives.
[[nodiscard]] std::size_t packet_bytes(const survey::Packet& packet);

// Packets once more over a simulated link: each is sent at its capture time. Ascending arrival.
[[nodiscard]] std::vector<survey::ReceivedPacket> replay(const std::vector<survey::ReceivedPacket>& packets,
                                                         const LinkOptions& options, std::uint64_t seed,
                                                         LinkCounts* counts = nullptr);

// The times between arrivals, s.
struct UpdatePeriods {
  std::size_t count = 0;
  double mean_s = 0.0, median_s = 0.0, max_s = 0.0;
  double mean_age_s = 0.0, max_age_s = 0.0;  // arrival minus capture
};
[[nodiscard]] UpdatePeriods update_periods(const std::vector<survey::ReceivedPacket>& packets);

}  // namespace cairn::ground
