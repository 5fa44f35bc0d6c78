// Figures over all rocks of a site: contact sheet, histogram by grade, counts of rejects, map. Static SVG that needs no
// style sheet, so that it can stand alone or in a page.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/vec.hpp"
#include "report/html_text.hpp"
#include "report/rock_picture.hpp"
#include "survey/rock.hpp"

namespace cairn::report {

struct SiteRock {
  std::string label;  // its number or id
  std::string href;   // of more about it; "" = none
  survey::Grade grade = survey::Grade::not_measurable;
  bool rejected = false;
  std::vector<std::string> reasons;                       // of a rejection
  std::optional<double> alpha_deg, toward_deg;            // empty where the grade allows none
  std::optional<std::pair<double, double>> alpha_90_deg;  // 5 % and 95 % of the draws
  std::string judgement, review;                          // as in the inventory
  double height_m = 0.0, width_m = 0.0;
  std::optional<geometry::Vec2> place;  // local east, north [m]; for the map
  std::optional<RockPicture> picture;
  std::optional<geometry::Vec3> centre_of_mass;  // same frame as the picture's mesh
  std::vector<geometry::Vec3> contact;
};

// The side view of a rock for the contact sheet: it falls to the right. Rocks without a figure are seen towards north.
[[nodiscard]] RockPicture sheet_picture(const geometry::TriangleMesh& mesh, const std::vector<std::uint8_t>& facet_seen,
                                        std::optional<double> toward_deg);

// Order of the sheet: by grade (best known first), then by alpha (most fragile first), then as given. Rejected rocks
// are left out.
[[nodiscard]] std::vector<std::size_t> sheet_order(const std::vector<SiteRock>& rocks);

// One cell a rock with its side view, centre of mass, rocking points, number, grade and alpha. 200 rocks of 20 000
// triangles take about a second and 1 to 2 MB.
[[nodiscard]] Html contact_sheet(const std::vector<SiteRock>& rocks);

// Rocks by least tipping angle, stacked by grade; those without a figure stand in a bar of their own.
[[nodiscard]] Html grade_histogram(const std::vector<SiteRock>& rocks);

// Rejected rocks by reason; empty where none was rejected.
[[nodiscard]] Html reject_chart(const std::vector<SiteRock>& rocks);

// Where the rocks stand, coloured by grade, with the direction of toppling; north up. Empty without two places.
[[nodiscard]] Html site_map(const std::vector<SiteRock>& rocks);

// A whole page with all of them. notes: sentences under the title.
[[nodiscard]] std::string site_page(const std::string& title, const std::vector<std::string>& notes,
                                    const std::vector<SiteRock>& rocks, bool with_map);

// "#0072b2"
[[nodiscard]] std::string_view grade_colour(survey::Grade grade);

}  // namespace cairn::report
