#include <array>
#include <cstring>

#include "base/error.hpp"
#include "io/bytes.hpp"
#include "io/packet_bytes.hpp"
#include "io/packets.hpp"

namespace cairn::io {
namespace {

constexpr std::array<char, 8> kMagic{'C', 'A', 'I', 'R', 'N', 'P', 'K', 'T'};
constexpr std::size_t kHeaderBytes = 24, kRecordHeadBytes = 12;
// The file's code of a time base is its index.
constexpr std::array kTimeBases{base::TimeBase::unknown, base::TimeBase::utc, base::TimeBase::gps,
                                base::TimeBase::boot};

constexpr std::array<std::uint32_t, 256> checksum_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}

base::TimeBase read_header(Bytes bytes, const std::string& name, std::uint64_t& count) {
  if (bytes.size() < kHeaderBytes || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    throw bad_bytes(name, 0, "not a recording of packets").allowed("a header of 24 bytes that starts with CAIRNPKT");
  const auto version = load_le<std::uint16_t>(bytes.data() + 8);
  if (version != kPacketVersion)
    throw bad_bytes(name, 8, "recording of another version")
        .found(std::to_string(version))
        .allowed(std::to_string(kPacketVersion));
  const auto time_base = load_le<std::uint8_t>(bytes.data() + 10);
  if (time_base >= kTimeBases.size())
    throw bad_bytes(name, 10, "unknown time base")
        .found(std::to_string(time_base))
        .allowed("0 unknown, 1 utc, 2 gps, 3 boot");
  for (std::size_t i = 11; i < 16; ++i)
    if (bytes[i] != std::byte{0}) throw bad_bytes(name, i, "reserved byte is not zero");
  count = load_le<std::uint64_t>(bytes.data() + 16);
  return kTimeBases[time_base];
}

}  // namespace

std::uint32_t packet_checksum(std::span<const std::byte> bytes) {
  static constexpr auto kTable = checksum_table();
  std::uint32_t c = 0xFFFFFFFFU;
  for (const std::byte b : bytes) c = kTable[(c ^ std::to_integer<std::uint32_t>(b)) & 0xFFU] ^ (c >> 8);
  return c ^ 0xFFFFFFFFU;
}

PacketLog read_packet_log(const std::filesystem::path& path) {
  const FileBytes file(path);
  const Bytes bytes = file.bytes();
  PacketLog log;
  std::uint64_t count = 0, records = 0;
  log.time_base = read_header(bytes, file.name(), count);
  std::size_t at = kHeaderBytes;
  while (at < bytes.size()) {
    const std::string record = "packet " + std::to_string(records) + " at byte " + std::to_string(at);
    const auto reject = [&](const char* reason, const std::string& message) {
      log.rejects.push_back({record, reason, record + ": " + message});
    };
    const std::size_t left = bytes.size() - at;
    const std::uint64_t length = left < kRecordHeadBytes ? 0 : load_le<std::uint32_t>(bytes.data() + at + 8);
    if (left < kRecordHeadBytes || length + kChecksumBytes > left - kRecordHeadBytes) {
      reject("truncated", "the recording ends inside it (" + std::to_string(left) + " bytes left" +
                              (left < kRecordHeadBytes ? ")" : ", its length is " + std::to_string(length) + ")"));
      break;
    }
    const auto whole = bytes.subspan(at, kRecordHeadBytes + static_cast<std::size_t>(length));
    at += whole.size() + kChecksumBytes;
    ++records;
    if (load_le<std::uint32_t>(whole.data() + whole.size()) != packet_checksum(whole)) {
      reject("bad_record_checksum", "the record's checksum is not that of its bytes");
      continue;
    }
    auto decoded = try_decode(whole.subspan(kRecordHeadBytes), record);
    if (auto* packet = std::get_if<survey::Packet>(&decoded))
      log.packets.push_back({load_le<std::int64_t>(whole.data()), std::move(*packet)});
    else log.rejects.push_back(std::get<base::Reject>(std::move(decoded)));
  }
  if (records != count)
    log.rejects.push_back({"header", "wrong_count",
                           "the header says " + std::to_string(count) + " packets, the file has " +
                               std::to_string(records) + " whole records"});
  return log;
}

std::vector<survey::ReceivedPacket> read_packets(const std::filesystem::path& path) {
  auto log = read_packet_log(path);
  if (!log.rejects.empty())
    throw base::Error(base::ErrorCode::invalid_input, log.rejects.front().message)
        .file(path.string())
        .record(log.rejects.front().record)
        .found(log.rejects.front().reason)
        .hint("Record again, or let 'cairn vehicle' use the packets that are whole");
  return std::move(log.packets);
}

void write_packets(const std::filesystem::path& path, std::span<const survey::ReceivedPacket> packets,
                   base::TimeBase time_base) {
  OutputFile file(path);
  file.write(std::string_view(kMagic.data(), kMagic.size()));
  file.put(static_cast<std::uint16_t>(kPacketVersion));
  std::uint8_t code = 0;
  while (kTimeBases[code] != time_base) ++code;
  file.put(code);
  file.put_zeros(5);
  file.put(static_cast<std::uint64_t>(packets.size()));
  std::vector<std::byte> record;
  for (const auto& received : packets) {
    const auto packet = encode(received.packet);
    record.clear();
    append_le(record, received.arrival_time_ns);
    append_le(record, static_cast<std::uint32_t>(packet.size()));
    record.insert(record.end(), packet.begin(), packet.end());
    append_le(record, packet_checksum(record));
    file.write(record);
  }
  file.close();
}

}  // namespace cairn::io
