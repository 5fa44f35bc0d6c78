// The packets that an aircraft sends to a ground vehicle (paper B, equation (4)): their bytes on the link, and
// recordings of them (packets.bin). docs/formats/packets.md is the contract of every byte.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/reject.hpp"
#include "base/time.hpp"
#include "survey/packet.hpp"

namespace cairn::io {

inline constexpr int kPacketVersion = 1;

// The bytes of one packet, checksum included. Doubles are written as they are: decode gives back the same packet (the
// two off-diagonal elements of a covariance are written once, as their mean). Throws invalid_argument for what decode
// would refuse: a number that is not finite, a negative size or variance, a score outside 0..1, more than 65535
// objects, vehicles or corners, a class longer than 255 bytes or with control characters. Cost linear in bytes.
[[nodiscard]] std::vector<std::byte> encode(const survey::Packet& packet);

// The packet whose bytes are exactly `bytes`, or why they are none. Reason codes: truncated, not_a_packet,
// unknown_version, bad_checksum, wrong_count (the counts ask for another number of bytes than there are), not_finite,
// out_of_range. encode(decode(bytes)) == bytes. `record` names the packet in the reject.
[[nodiscard]] std::variant<survey::Packet, base::Reject> try_decode(std::span<const std::byte> bytes,
                                                                    std::string_view record = "packet");
// The same; throws invalid_input with the record and the reason.
[[nodiscard]] survey::Packet decode(std::span<const std::byte> bytes);

// A recording, with what of it could not be read.
struct PacketLog {
  base::TimeBase time_base = base::TimeBase::unknown;  // of arrival and capture times, as the file declares it
  std::vector<survey::ReceivedPacket> packets;         // in the order of the file
  std::vector<base::Reject> rejects;  // broken records; beside try_decode's reasons: bad_record_checksum
};

// Reads every record that can be read. A recording that was cut off gives its whole records and the reject
// `truncated`; a header count that is not the number of records gives the reject `wrong_count`. Throws not_found, or
// invalid_input where the file's header is no packets.bin or of another version. Nothing is reserved by the header's
// count. Cost linear in bytes.
[[nodiscard]] PacketLog read_packet_log(const std::filesystem::path& path);
// The packets of a recording without fault; throws invalid_input, naming the record, at the first one that has one.
[[nodiscard]] std::vector<survey::ReceivedPacket> read_packets(const std::filesystem::path& path);

// Written straight to `path`, in the order given. Throws as encode, and resource_exhausted where a write fails.
void write_packets(const std::filesystem::path& path, std::span<const survey::ReceivedPacket> packets,
                   base::TimeBase time_base = base::TimeBase::unknown);

}  // namespace cairn::io
