#include "report/html_report.hpp"

#include <cmath>
#include <cstdint>
#include <string_view>

#include "base/digest.hpp"
#include "base/error.hpp"
#include "report/base64.hpp"
#include "report/mesh_pack.hpp"
#include "report/raster_image.hpp"
#include "report/sections.hpp"
#include "report/web_bundle.hpp"

namespace cairn::report {
namespace {

constexpr std::size_t kReadoutPx = 500;  // longer side of the grids read out under the cursor

void check(const ReportData& data) {
  const auto fail = [](std::string_view what, std::size_t found, std::size_t allowed) {
    throw base::Error(base::ErrorCode::failed_precondition, "the data of the report contradict themselves")
        .record(what)
        .found(std::to_string(found) + " values")
        .allowed(std::to_string(allowed));
  };
  for (const RasterView& r : data.rasters)
    if (r.grid.values.size() != r.grid.geometry.cells() || r.grid.values.empty())
      fail("raster", r.grid.values.size(), r.grid.geometry.cells());
  if (data.colours && (data.colours->colours.size() != data.colours->geometry.cells() ||
                       data.colours->mask.size() != data.colours->geometry.cells() || data.colours->mask.empty()))
    fail("colour raster", data.colours->colours.size(), data.colours->geometry.cells());
  for (const RockView& r : data.rocks) {
    const auto& polar = r.rock.tipping.a_qs_g_by_azimuth;
    if (!polar.empty() && polar.size() != 360) fail("rock " + std::to_string(r.rock.target.value), polar.size(), 360);
    if (!r.mesh) continue;
    for (const geometry::Triangle& t : r.mesh->triangles)
      for (const std::uint32_t i : t)
        if (i >= r.mesh->vertices.size())
          fail("rock " + std::to_string(r.rock.target.value) + ", triangle", i, r.mesh->vertices.size());
  }
}

// SHA-256 in the form of a content security policy.
std::string csp_hash(std::string_view content) {
  const std::string hex = base::sha256_of(content);
  std::string bytes;
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(digit(hex[i]) * 16 + digit(hex[i + 1]));
  return "'sha256-" + base64(bytes) + "'";
}

io::Json grid_json(const RasterView& view, std::string_view name) {
  const PackedGrid grid =
      packed(view.grid, kReadoutPx, view.role == RasterRole::costmap ? Merge::maximum : Merge::mean);
  return io::Json::object({{"name", name},
                           {"unit", clean_utf8(view.unit)},
                           {"west", grid.geometry.west},
                           {"north", grid.geometry.north},
                           {"cell", grid.geometry.cell},
                           {"columns", grid.geometry.columns},
                           {"rows", grid.geometry.rows},
                           {"offset", grid.offset},
                           {"step", grid.step},
                           {"data", grid.base64}});
}

std::string page_data(const PageContext& page) {
  const geometry::Geodetic& o = page.data.manifest.origin.position;
  io::Json json = io::Json::object();
  json.set("name", clean_utf8(page.title));
  json.set("origin", std::vector<double>{o.latitude_deg, o.longitude_deg, o.height_m});
  io::Json grids = io::Json::array();
  if (const RasterView* r = page.raster(RasterRole::surface)) grids.push(grid_json(*r, "height"));
  if (const RasterView* r = page.raster(RasterRole::views)) grids.push(grid_json(*r, "views"));
  if (const RasterView* r = page.raster(RasterRole::costmap)) grids.push(grid_json(*r, "cost"));
  json.set("grids", grids);
  io::Json rocks = io::Json::array();
  for (const RockView& r : page.data.rocks)
    if (!r.rock.rejected) rocks.push(packed_rock(r, static_cast<std::size_t>(page.options.max_mesh_triangles)));
  json.set("rocks", rocks);
  io::Json polar = io::Json::object();
  for (const RockView& r : page.data.rocks) {
    const survey::Tipping& t = r.rock.tipping;
    if (r.rock.rejected || t.grade == survey::Grade::not_measurable || t.a_qs_g_by_azimuth.empty()) continue;
    std::vector<double> rounded;
    for (const double v : t.a_qs_g_by_azimuth) rounded.push_back(std::round(v * 1e5) / 1e5);
    polar.set(std::to_string(r.rock.target.value), rounded);
  }
  json.set("polar", polar);
  return script_safe(json.dump(0));
}

Html navigation(const PageContext& page, bool site, bool coverage, bool ground) {
  Html h;
  h.raw("<nav class=\"contents\" aria-label=\"Sections\"><a class=\"brand\" href=\"#top\">")
      .text(page.title)
      .raw("</a>");
  h.raw("<a href=\"#explore\">Map</a>");
  if (!page.data.targets.empty()) h.raw("<a href=\"#objects\">Objects</a>");
  if (site) h.raw("<a href=\"#site\">Rocks</a>");
  if (coverage) h.raw("<a href=\"#coverage\">Coverage</a>");
  if (ground) h.raw("<a href=\"#ground\">Route</a>");
  h.raw("<a href=\"#provenance\">Provenance</a><a href=\"#reading\">How to read</a></nav>");
  return h;
}

// Runs before the page is drawn, so that nothing jumps.
constexpr std::string_view kEarlyScript = "document.documentElement.classList.add('js')";

}  // namespace

std::string render_report(const ReportData& data, const ReportOptions& options) {
  ReportOptions checked = options;
  base::validate(base::bind_options(checked), "report");
  check(data);
  const PageContext page(data, checked);
  const Html site = site_section(page), coverage = coverage_section(page), ground = ground_section(page);

  Html h;
  h.raw(
      "<!doctype html>\n<html lang=\"en\" id=\"top\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "http-equiv=\"Content-Security-Policy\"");
  h.attr("content", "default-src 'none'; img-src data:; font-src data:; style-src 'unsafe-inline'; script-src " +
                        csp_hash(kEarlyScript) + " " + csp_hash(bundle_script()) +
                        "; base-uri 'none'; form-action 'none'");
  h.raw(">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"generator\"");
  h.attr("content", "cairn " + data.provenance.version)
      .raw(">\n<meta name=\"referrer\" content=\"no-referrer\">\n<title>");
  h.text(page.title)
      .raw(" – survey report</title>\n<style>")
      .made(bundle_style())
      .raw("</style>\n<script>")
      .made(kEarlyScript)
      .raw("</script>\n</head>\n<body>\n");
  h.add(navigation(page, !site.empty(), !coverage.empty(), !ground.empty()))
      .raw("\n<main>\n")
      .add(header_section(page))
      .raw("\n")
      .add(summary_section(page));
  h.raw(
      "\n<section class=\"explore\" id=\"explore\"><h2 class=\"sr\">Map and selected object</h2><div "
      "class=\"workspace\">");
  h.add(map_figure(page)).add(object_panel(page)).raw("</div></section>\n");
  h.add(table_section(page))
      .raw("\n")
      .add(site)
      .raw("\n")
      .add(coverage)
      .raw("\n")
      .add(ground)
      .raw("\n")
      .add(provenance_section(page))
      .raw("\n")
      .add(reading_section());
  h.raw("\n</main>\n<footer class=\"foot\"><p>Made by cairn ").text(data.provenance.version);
  h.raw(". This page holds everything it shows and loads nothing from the network.</p></footer>\n");
  h.raw("<script type=\"application/json\" id=\"cairn-data\">")
      .made(page_data(page))
      .raw("</script>\n<script>")
      .made(bundle_script());
  h.raw("</script>\n</body>\n</html>\n");
  return std::move(h).str();
}

}  // namespace cairn::report
