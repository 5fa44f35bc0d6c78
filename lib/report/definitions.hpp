// The words of the report: what a grade, a reason code or a column means, in one sentence each.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "survey/rock.hpp"
#include "survey/target.hpp"

namespace cairn::report {

struct Term {
  std::string_view symbol;      // "a_qs"
  std::string_view name;        // "quasi-static tipping acceleration"
  std::string_view unit;        // "g"; "" = none
  std::string_view definition;  // one or two sentences
};

[[nodiscard]] std::string_view grade_label(survey::Grade grade);
[[nodiscard]] std::string_view grade_meaning(survey::Grade grade);
[[nodiscard]] std::string_view state_meaning(survey::TargetState state);
[[nodiscard]] std::string_view cap_meaning(survey::CapModel cap);

// A sentence for a known reason code, else the code with blanks for underscores.
[[nodiscard]] std::string reason_sentence(std::string_view code);

// The same for verdicts and gaps of the coverage, whose codes mean other things than those of rocks.
[[nodiscard]] std::string coverage_sentence(std::string_view code);

// All terms, in the order of the reading guide.
[[nodiscard]] std::span<const Term> terms();

}  // namespace cairn::report
