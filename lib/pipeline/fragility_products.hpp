// What `cairn fragility` writes of one rock.
#pragma once

#include <filesystem>

#include "fragility/assessment.hpp"
#include "io/json.hpp"
#include "survey/rock.hpp"

namespace cairn::pipeline {

// The row of the summary: scalars, the interval of alpha, quantiles under "quantiles" by the scalar's own name. No
// angle where the grade is not_measurable. rock.tipping filled.
[[nodiscard]] io::Json rock_summary(const survey::Rock& rock, const std::string& name, const std::string& north);

// <stem>_tipping.json: every edge, the tables by azimuth, variants, views.
[[nodiscard]] io::Json tipping_detail(const survey::Rock& rock, const fragility::Assessment& assessment);

// Joint draws, a row each: draw, standing, the columns of fragility/draw_summary.hpp, alpha_bearing_deg, bearing_inset.
// Cells without a value are empty. Seven significant digits. Written straight to `path`; throws resource_exhausted
// where a write fails.
void write_draws(const std::filesystem::path& path, const std::vector<fragility::TippingDraw>& draws);

}  // namespace cairn::pipeline
