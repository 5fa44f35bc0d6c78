// All rocks together: tipping angles by grade, rejects by reason, contact sheet.
#include "base/angle.hpp"
#include "report/sections.hpp"
#include "report/site_figures.hpp"

namespace cairn::report {

Html site_section(const PageContext& page) {
  std::vector<SiteRock> rocks;
  std::size_t counted = 0;
  for (const RockView& view : page.data.rocks) {
    const survey::Rock& rock = view.rock;
    SiteRock site;
    site.label = std::to_string(rock.target.value);
    site.href = "#object-" + site.label;
    if (!rock.name.empty()) site.label += " " + rock.name;
    site.grade = rock.tipping.grade;
    site.rejected = rock.rejected;
    site.reasons = rock.reasons;
    site.review = rock.review;
    site.height_m = rock.size_m.z();
    site.width_m = rock.size_m.y();
    if (rock.mass) site.centre_of_mass = rock.mass->centre_of_mass;
    site.contact = rock.tipping.contact;
    if (rock.tipping.grade != survey::Grade::not_measurable && rock.tipping.critical) {
      site.alpha_deg = base::rad_to_deg(rock.tipping.critical->alpha_rad);
      site.toward_deg = rock.tipping.critical->azimuth_deg;
      if (rock.tipping.uncertainty)
        if (const auto* q = rock.tipping.uncertainty->find("alpha_min_deg")) site.alpha_90_deg = {q->p05, q->p95};
    }
    if (!rock.rejected) {
      ++counted;
      if (view.mesh) site.picture = sheet_picture(*view.mesh, view.facet_seen, site.toward_deg);
    }
    rocks.push_back(std::move(site));
  }
  Html h;
  if (counted < 2) return h;
  h.raw(
       "<section id=\"site\"><h2>All rocks</h2><div class=\"figures-two\"><figure><figcaption>Least tipping angle, by "
       "grade</figcaption>")
      .add(grade_histogram(rocks))
      .raw("</figure>");
  if (const Html rejects = reject_chart(rocks); !rejects.empty())
    h.raw("<figure><figcaption>Rejected rocks, by reason</figcaption>").add(rejects).raw("</figure>");
  h.raw(
       "</div><figure><figcaption>Contact sheet: by grade, then by least tipping angle. Each rock is seen from the "
       "side, "
       "so that it falls to the right; white: centre of mass; black: contact; red: to the rocking point; in brackets "
       "the 5 % and 95 % quantiles. Scales differ: see the bars.</figcaption>")
      .add(contact_sheet(rocks))
      .raw("</figure></section>");
  return h;
}

}  // namespace cairn::report
