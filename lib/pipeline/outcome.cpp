#include "pipeline/outcome.hpp"

#include <cstdint>
#include <map>

namespace cairn::pipeline {

io::Json count_by_reason(const std::vector<base::Reject>& rejects) {
  std::map<std::string, std::int64_t> counts;
  for (const auto& reject : rejects) ++counts[reject.reason];
  io::Json json = io::Json::object();
  for (const auto& [reason, count] : counts) json.set(reason, count);
  return json;
}

io::Json to_json(const std::vector<base::Reject>& rejects) {
  io::Json list = io::Json::array();
  for (const auto& reject : rejects)
    list.push(io::Json::object({{"record", reject.record}, {"reason", reject.reason}, {"message", reject.message}}));
  return list;
}

}  // namespace cairn::pipeline
