#include "base/error.hpp"

#include <utility>

namespace cairn::base {

ExitCode exit_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument: return ExitCode::usage;
    case ErrorCode::invalid_input:
    case ErrorCode::not_found:
    case ErrorCode::failed_precondition: return ExitCode::invalid_input;
    case ErrorCode::already_exists: return ExitCode::output_exists;
    case ErrorCode::resource_exhausted: return ExitCode::resource_limit;
    case ErrorCode::crs_mismatch: return ExitCode::crs_or_grid;
    case ErrorCode::quality_gate: return ExitCode::gate_failed;
    case ErrorCode::cancelled: return ExitCode::interrupted;
    case ErrorCode::internal: return ExitCode::processing_error;
  }
  return ExitCode::processing_error;
}

std::string_view name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument: return "invalid_argument";
    case ErrorCode::invalid_input: return "invalid_input";
    case ErrorCode::not_found: return "not_found";
    case ErrorCode::already_exists: return "already_exists";
    case ErrorCode::resource_exhausted: return "resource_exhausted";
    case ErrorCode::crs_mismatch: return "crs_mismatch";
    case ErrorCode::failed_precondition: return "failed_precondition";
    case ErrorCode::quality_gate: return "quality_gate";
    case ErrorCode::cancelled: return "cancelled";
    case ErrorCode::internal: return "internal";
  }
  return "internal";
}

Error::Error(ErrorCode code, std::string message) : code_(code), message_(std::move(message)) {
  compose();
}

Error&& Error::file(std::string_view path) && {
  file_ = path;
  compose();
  return std::move(*this);
}

Error&& Error::record(std::string_view record) && {
  record_ = record;
  compose();
  return std::move(*this);
}

Error&& Error::found(std::string_view value) && {
  found_ = value;
  compose();
  return std::move(*this);
}

Error&& Error::allowed(std::string_view values) && {
  allowed_ = values;
  compose();
  return std::move(*this);
}

Error&& Error::hint(std::string_view remedy) && {
  hint_ = remedy;
  compose();
  return std::move(*this);
}

void Error::in(std::string_view context) {
  context_.emplace_back(context);
  compose();
}

void Error::default_file(std::string_view path) {
  if (file_.empty()) {
    file_ = path;
    compose();
  }
}

void Error::compose() {
  text_.clear();
  if (!file_.empty()) text_ += file_;
  if (!record_.empty()) text_ += (text_.empty() ? "" : ", ") + record_;
  if (!text_.empty()) text_ += ": ";
  text_ += message_;
  if (!found_.empty() || !allowed_.empty()) {
    text_ += " (";
    if (!found_.empty()) text_ += "found " + found_;
    if (!allowed_.empty()) text_ += std::string(found_.empty() ? "" : "; ") + "allowed " + allowed_;
    text_ += ")";
  }
  if (!hint_.empty()) text_ += ". " + hint_;
  for (const auto& context : context_) text_ += " [" + context + "]";
}

}  // namespace cairn::base
