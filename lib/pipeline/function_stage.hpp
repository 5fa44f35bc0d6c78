// A recipe's stage made of a stage function and its options.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/stage.hpp"

namespace cairn::pipeline {

template <typename Options>
struct StageDescription {
  std::string name;
  std::vector<std::string> needs;
  std::vector<std::string> uses;
  std::function<Estimate(const StageInputs&, const Options&)> estimate;
  std::function<Outcome(const StageInputs&, const std::filesystem::path& out, const Options&, base::RunContext&)> run;
  std::function<std::string(const StageInputs&)> missing = {};  // as Stage::missing; empty = nothing ever is
};

template <typename Options>
class FunctionStage final : public Stage {
 public:
  explicit FunctionStage(StageDescription<Options> description) : description_(std::move(description)) {}

  [[nodiscard]] std::string_view name() const override { return description_.name; }
  [[nodiscard]] std::vector<std::string> needs() const override { return description_.needs; }
  [[nodiscard]] std::vector<std::string> uses() const override { return description_.uses; }
  [[nodiscard]] std::string missing(const StageInputs& in) const override {
    return description_.missing ? description_.missing(in) : std::string();
  }
  [[nodiscard]] base::VisitOptions options() override { return base::bind_options(options_); }
  [[nodiscard]] Estimate estimate(const StageInputs& in) const override { return description_.estimate(in, options_); }
  Outcome run(const StageInputs& in, const std::filesystem::path& out, base::RunContext& ctx) override {
    return description_.run(in, out, options_, ctx);
  }

 private:
  StageDescription<Options> description_;
  Options options_;
};

template <typename Options>
[[nodiscard]] std::unique_ptr<Stage> make_function_stage(StageDescription<Options> description) {
  return std::make_unique<FunctionStage<Options>>(std::move(description));
}

// The product of an earlier stage, or "" where the recipe does not have that stage.
[[nodiscard]] inline std::filesystem::path product(const StageInputs& in, std::string_view stage, const char* name) {
  for (const auto& ran : in.available)
    if (ran == stage) return in.products / name;
  return {};
}

}  // namespace cairn::pipeline
