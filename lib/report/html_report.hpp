// The survey's report: one HTML file that holds everything it shows.
#pragma once

#include <cstdint>
#include <string>

#include "base/options.hpp"
#include "report/report_data.hpp"

namespace cairn::report {

struct ReportOptions {
  std::string title;                        // "" = the survey's name
  std::int64_t max_raster_px = 1400;        // longer side of an underlay; larger rasters are averaged down
  std::int64_t max_mesh_triangles = 12000;  // of one rock's 3-D view; larger meshes are clustered
  double sun_azimuth_deg = 315.0;           // of the hillshade, clockwise from north
  double sun_altitude_deg = 45.0;
  bool photos = true;  // embed the photo crops

  void visit(base::OptionVisitor& visitor) {
    visitor.text("title", title, "Title of the page; empty takes the survey's name");
    visitor.integer("max-raster-px", max_raster_px, 64, 8192, "Longer side of a map underlay, pixels");
    visitor.integer("max-mesh-triangles", max_mesh_triangles, 100, 1000000, "Triangles of one rock's 3-D view");
    visitor.real("sun-azimuth-deg", sun_azimuth_deg, 0.0, 360.0, "Hillshade: where the light comes from");
    visitor.real("sun-altitude-deg", sun_altitude_deg, 1.0, 90.0, "Hillshade: height of the light above the horizon");
    visitor.flag("photos", photos, "Embed the crops of the photographs");
  }
};

// The whole page, UTF-8. It loads nothing: styles, script, fonts, images and meshes are inside, and a
// content security policy forbids everything else, scripts of other content included. Summary, map, tables and
// charts are static HTML and SVG; the script adds pan and zoom, selection, sorting and the 3-D views.
// All text of the data is escaped; equal data and options give equal bytes; no time stamp but the
// data's own. A rock graded not_measurable shows no tipping figure.
// Throws invalid_argument for options out of range, failed_precondition for data that contradict
// themselves (a grid without its values, a polar table that is not 360 long).
// Cost: linear in the raster cells and triangles; about 3 s for ten rasters of a million cells.
[[nodiscard]] std::string render_report(const ReportData& data, const ReportOptions& options = {});

}  // namespace cairn::report
