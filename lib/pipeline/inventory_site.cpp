#include "pipeline/inventory_site.hpp"

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/ply.hpp"
#include "report/site_figures.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

report::SiteRock site_rock(const report::InventoryRock& entry, const std::string& label) {
  report::SiteRock site;
  site.label = label;
  site.href = "rocks/" + entry.id + ".json";
  const auto& rock = entry.rock;
  site.grade = rock.tipping.grade;
  site.rejected = rock.rejected;
  site.reasons = rock.reasons;
  site.judgement = entry.judgement;
  site.review = rock.review;
  site.height_m = rock.size_m.z();
  site.width_m = rock.size_m.y();
  if (rock.mass) site.centre_of_mass = rock.mass->centre_of_mass;
  site.contact = rock.tipping.contact;
  if (rock.tipping.grade == survey::Grade::not_measurable || !rock.tipping.critical) return site;
  site.alpha_deg = base::rad_to_deg(rock.tipping.critical->alpha_rad);
  site.toward_deg = rock.tipping.critical->azimuth_deg;
  if (rock.tipping.uncertainty)
    if (const auto* q = rock.tipping.uncertainty->find("alpha_min_deg")) site.alpha_90_deg = {q->p05, q->p95};
  return site;
}

}  // namespace

void write_site(const report::Inventory& inventory, const std::vector<fs::path>& meshes, const fs::path& out,
                const InventoryOptions& options, base::RunContext& ctx) {
  // All places in the first survey's frame, so that several surveys share a map.
  std::vector<std::optional<geodesy::LocalFrame>> frames;
  std::optional<geodesy::LocalFrame> map_frame;
  for (const auto& survey : inventory.surveys) {
    frames.push_back(survey.origin ? std::optional(geodesy::LocalFrame(survey.origin->position)) : std::nullopt);
    if (!map_frame && frames.back()) map_frame = frames.back();
  }
  const bool with_map = !inventory.protection.on;
  const bool one = inventory.surveys.size() == 1;
  std::vector<report::SiteRock> rocks;
  for (std::size_t i = 0; i < inventory.rocks.size(); ++i) {
    ctx.check_stop();
    ctx.progress("pictures", i + 1, inventory.rocks.size());
    const auto& entry = inventory.rocks[i];
    auto site = site_rock(entry, one ? std::to_string(entry.rock.target.value) : entry.id);
    if (options.pictures && !meshes[i].empty() && !site.rejected)
      site.picture = report::sheet_picture(io::read_ply_mesh(meshes[i]).mesh, {}, site.toward_deg);
    const auto place = report::place_of(entry.rock, entry.target);
    const auto& frame = frames[entry.survey];
    if (with_map && place && frame) site.place = map_frame->to_local(frame->to_geodetic(*place)).head<2>();
    else if (with_map && place && one) site.place = place->head<2>();
    rocks.push_back(std::move(site));
  }
  const auto write = [&](const char* name, const report::Html& svg) {
    if (!svg.empty()) base::write_file(out / name, svg.str() + "\n");
  };
  write("contact_sheet.svg", report::contact_sheet(rocks));
  write("grades.svg", report::grade_histogram(rocks));
  write("rejects.svg", report::reject_chart(rocks));
  if (with_map) write("map.svg", report::site_map(rocks));

  std::string title = "Rock inventory";
  for (std::size_t s = 0; s < inventory.surveys.size() && s < 3; ++s)
    title += (s == 0 ? ": " : ", ") + report::protected_text(inventory.surveys[s].name, inventory.protection);
  if (inventory.surveys.size() > 3) title += " and " + std::to_string(inventory.surveys.size() - 3) + " more";
  std::vector<std::string> notes;
  if (inventory.protection.on) notes.push_back(report::protection_text(inventory.protection) + ".");
  notes.emplace_back(
      "Figures, units and definitions: inventory.gpkg (tables inventory and cairn_columns), inventory.csv with "
      "columns.csv, rocks/<id>.json.");
  base::write_file(out / "index.html", report::site_page(title, notes, rocks, with_map));
}

}  // namespace cairn::pipeline
