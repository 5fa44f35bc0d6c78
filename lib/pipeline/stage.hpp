// One step of a recipe: files in, files out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

// Where a stage finds what earlier stages made.
struct StageInputs {
  std::filesystem::path survey;        // the survey folder
  std::filesystem::path products;      // OUT: products of earlier stages under their final names
  std::vector<std::string> available;  // names of the stages that ran before
};

// What a stage will need at most, for --dry-run.
struct Estimate {
  std::uint64_t memory_bytes = 0;
  std::uint64_t disk_bytes = 0;
};

class Stage {
 public:
  virtual ~Stage() = default;
  [[nodiscard]] virtual std::string_view name() const = 0;
  // Stages whose products this one reads. Those of `needs` must stand before it in the recipe;
  // those of `uses` are read where the recipe has them.
  [[nodiscard]] virtual std::vector<std::string> needs() const { return {}; }
  [[nodiscard]] virtual std::vector<std::string> uses() const { return {}; }
  // What the survey lacks for this stage, "" where nothing. A recipe's optional stages are left out then.
  [[nodiscard]] virtual std::string missing(const StageInputs& /*in*/) const { return {}; }
  [[nodiscard]] virtual base::VisitOptions options() = 0;
  [[nodiscard]] virtual Estimate estimate(const StageInputs& in) const = 0;
  // Writes into `out`, an empty staged folder, under the products' final relative names.
  virtual Outcome run(const StageInputs& in, const std::filesystem::path& out, base::RunContext& ctx) = 0;
};

}  // namespace cairn::pipeline
