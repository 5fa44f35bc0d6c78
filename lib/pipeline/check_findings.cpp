#include "pipeline/check_findings.hpp"

#include <algorithm>

namespace cairn::pipeline {

std::string_view name_of(Severity severity) {
  switch (severity) {
    case Severity::error: return "error";
    case Severity::warning: return "warning";
    default: return "info";
  }
}

std::string told(std::string_view message, std::string_view found, std::string_view allowed) {
  std::string text(message);
  if (found.empty() && allowed.empty()) return text;
  text += " (";
  if (!found.empty()) text += "found " + std::string(found);
  if (!found.empty() && !allowed.empty()) text += "; ";
  if (!allowed.empty()) text += "allowed " + std::string(allowed);
  return text + ")";
}

void Findings::add(Finding finding) {
  severities_[finding.code] = finding.severity;
  if (++counts_[finding.code] <= per_code_) findings_.push_back(std::move(finding));
}

void Findings::add(std::string code, const base::Error& error, std::string_view record, Severity severity) {
  std::string where = error.record();
  if (where.empty()) where = record;
  else if (!record.empty()) where += " (" + std::string(record) + ")";
  add({std::move(code), severity, error.file(), std::move(where), told(error.message(), error.found(), error.allowed()),
       error.hint()});
}

std::size_t Findings::count(Severity severity) const {
  std::size_t sum = 0;
  for (const auto& [code, count] : counts_)
    if (severities_.at(code) == severity) sum += count;
  return sum;
}

std::vector<Finding> Findings::list() const {
  std::vector<Finding> all = findings_;
  for (const auto& [code, count] : counts_)
    if (count > per_code_)
      all.push_back(
          {code, severities_.at(code), "", std::to_string(count - per_code_) + " more records",
           "the same was found " + std::to_string(count) + " times; " + std::to_string(per_code_) + " are listed", ""});
  std::stable_sort(all.begin(), all.end(), [](const Finding& a, const Finding& b) {
    return static_cast<int>(a.severity) > static_cast<int>(b.severity);
  });
  return all;
}

io::Json to_json(const std::vector<Finding>& findings) {
  io::Json list = io::Json::array();
  for (const auto& f : findings)
    list.push(io::Json::object({{"code", f.code},
                                {"severity", name_of(f.severity)},
                                {"file", f.file},
                                {"record", f.record},
                                {"message", f.message},
                                {"hint", f.hint}}));
  return list;
}

}  // namespace cairn::pipeline
