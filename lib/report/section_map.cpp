// The map: underlays as pictures, overlays as vectors, in metres of the local frame.
#include <algorithm>
#include <cmath>

#include "base/angle.hpp"
#include "report/base64.hpp"
#include "report/charts.hpp"
#include "report/raster_image.hpp"
#include "report/sections.hpp"

namespace cairn::report {
namespace {

constexpr double kNominalWidthPx = 860.0;  // of the map, for symbol sizes before the script runs
constexpr int kManyViews = 9;

std::string m(double metres) {
  return Html::short_number(metres, 3);
}
std::string point(const geometry::Vec2& p) {
  return m(p.x()) + "," + m(-p.y());
}

std::string ring_path(const geometry::Ring& ring) {
  std::string d;
  for (std::size_t i = 0; i < ring.size(); ++i) d += (i == 0 ? "M" : "L") + point(ring[i]);
  return d.empty() ? d : d + "Z";
}

std::string heading_of(const survey::Frame& frame) {
  // The image's top on the ground: camera -y, or its forward axis where it looks near the horizon.
  const geometry::Mat3& r = frame.T_world_camera.rotation;
  const bool oblique = std::abs(r(2, 2)) < 0.7;
  const geometry::Vec3 direction = oblique ? geometry::Vec3(r.col(2)) : geometry::Vec3(-r.col(1));
  return m(base::azimuth_deg(direction.x(), direction.y()));
}

template <typename Image>
void picture(Html& h, const Image& image, const geometry::GridGeometry& g, bool smooth) {
  h.raw("<image preserveAspectRatio=\"none\"")
      .attr("x", g.west)
      .attr("y", -g.north)
      .attr("width", g.cell * static_cast<double>(image.width))
      .attr("height", g.cell * static_cast<double>(image.height))
      .attr("class", smooth ? "smooth" : "cells")
      .raw(" href=\"data:image/png;base64,")
      .made(base64(encode_png(image)))
      .raw("\"/>");
}

struct Underlay {
  Html option, legend;
};

void radio(Html& h, std::string_view id, std::string_view label, bool checked) {
  h.raw("<label class=\"choice\"><input type=\"radio\" name=\"underlay\"")
      .attr("id", "u-" + std::string(id))
      .attr("value", id);
  if (checked) h.raw(" checked");
  h.raw("><span>").text(label).raw("</span></label>");
}

void legend_ramp(Html& h, std::string_view id, Rgba (*ramp)(double), const std::string& lo, const std::string& hi,
                 const std::string& text) {
  std::string stops;
  for (int i = 0; i <= 8; ++i) stops += (i == 0 ? "" : ",") + css_colour(ramp(i / 8.0));
  h.raw("<div")
      .attr("class", "legend legend-" + std::string(id))
      .raw("><span class=\"lo\">")
      .text(lo)
      .raw("</span><i class=\"ramp\"");
  h.attr("style", "background:linear-gradient(90deg," + stops + ")")
      .raw("></i><span class=\"hi\">")
      .text(hi)
      .raw("</span><p>");
  h.text(text).raw("</p></div>");
}

void underlays(Html& svg, Html& choices, Html& legends, const PageContext& page) {
  const auto max_px = static_cast<std::size_t>(page.options.max_raster_px);
  const RasterView* surface = page.raster(RasterRole::surface);
  if (surface != nullptr) {
    const geometry::Grid<float> heights = shrunk(surface->grid, max_px, Merge::mean);
    svg.raw("<g class=\"underlay\" data-layer=\"relief\">");
    picture(svg, hillshade(heights, page.options.sun_azimuth_deg, page.options.sun_altitude_deg), heights.geometry,
            true);
    svg.raw("</g>");
    if (const auto range = quantile_range(heights, 0.01, 0.99)) {
      svg.raw("<g class=\"underlay tint\" data-layer=\"tint\">");
      picture(svg, height_tint(shrunk(heights, max_px / 2, Merge::mean), *range),
              shrunk(heights, max_px / 2, Merge::mean).geometry, true);
      svg.raw("</g>");
      legend_ramp(legends, "relief", height_ramp, fixed(range->lo, 1) + "\u202fm", fixed(range->hi, 1) + "\u202fm",
                  "Surface height (datum: " + words_of(survey::name_of(page.data.manifest.origin.height_type)) +
                      "), 1st to 99th percentile, shaded from the north-west. Blank: nothing was measured.");
    }
    radio(choices, "relief", "Relief", true);
  }
  if (page.data.colours) {
    svg.raw("<g class=\"underlay\" data-layer=\"colour\">");
    const RgbaImage image = colour_picture(*page.data.colours, max_px);
    const geometry::GridGeometry& g = page.data.colours->geometry;
    const double cell =
        g.cell * std::ceil(static_cast<double>(std::max(g.columns, g.rows)) / static_cast<double>(max_px));
    picture(svg, image, {g.west, g.north, cell, image.width, image.height}, true);
    svg.raw("</g>");
    radio(choices, "colour", "Colours", surface == nullptr);
    legends.raw("<div class=\"legend legend-colour\"><p>Mean colour of the cloud's points in each cell.</p></div>");
  }
  if (const RasterView* views = page.raster(RasterRole::views)) {
    const geometry::Grid<float> counts = shrunk(views->grid, max_px, Merge::mean);
    svg.raw("<g class=\"underlay over\" data-layer=\"views\">");
    picture(svg, view_counts(counts, kManyViews), counts.geometry, false);
    svg.raw("</g>");
    radio(choices, "views", "Views", false);
    legends.raw("<div class=\"legend legend-views\"><span class=\"steps\">");
    for (int i = 0; i <= kManyViews; ++i)
      legends.raw("<span><i")
          .attr("style",
                "background:" + (i == 0 ? std::string("#d55e00") : css_colour(cividis((i - 1.0) / (kManyViews - 1.0)))))
          .raw("></i>")
          .text(std::to_string(i) + (i == kManyViews ? "+" : ""))
          .raw("</span>");
    legends.raw(
        "</span><p>Photographs that see each cell without obstruction, by ray casting. 0 and 1 cannot give a "
        "3-D point.</p></div>");
  }
  if (const RasterView* cost = page.raster(RasterRole::costmap)) {
    const geometry::Grid<float> cells = shrunk(cost->grid, max_px, Merge::maximum);
    const auto range = value_range(cells);
    const double top = range ? range->hi : 1.0;
    // Byte costmaps follow ROS: 254 is lethal.
    const std::optional<double> lethal = range && top <= 255.0 && top >= 253.0 ? std::optional(253.0) : std::nullopt;
    svg.raw("<g class=\"underlay over\" data-layer=\"costmap\">");
    picture(svg, cost_picture(cells, lethal ? 252.0 : top, lethal), cells.geometry, false);
    svg.raw("</g>");
    radio(choices, "costmap", "Costmap", false);
    legend_ramp(
        legends, "costmap", cost_ramp, "0", Html::short_number(top, 2),
        "Cost of driving there: highest on obstacles, falling off with distance. Clear cells cost nothing; cells "
        "outside the map are unknown.");
  }
  radio(choices, "none", "None", surface == nullptr && !page.data.colours);
}

void place(Html& svg, const geometry::Vec2& p) {
  svg.attr("transform", "translate(" + m(p.x()) + " " + m(-p.y()) + ")");
}

void overlays(Html& svg, const PageContext& page, double unit) {
  const ReportData& d = page.data;
  svg.raw("<g data-layer=\"footprints\">");
  for (const FrameView& f : d.frames)
    if (!f.footprint.empty())
      svg.raw("<path class=\"footprint\"")
          .attr("d", ring_path(f.footprint))
          .attr("data-frame", std::to_string(f.frame.id.value))
          .raw("/>");
  svg.raw("</g><g data-layer=\"gaps\">");
  if (d.coverage) {
    for (const GapView& g : d.coverage->gaps) {
      std::string path, reasons;
      for (const geometry::Ring& ring : g.rings) path += ring_path(ring);
      for (const std::string& code : g.reasons) reasons += (reasons.empty() ? "" : ", ") + words_of(code);
      svg.raw("<path class=\"gap\"").attr("d", path).attr("data-gap", std::to_string(g.id)).raw("><title>");
      svg.text("Gap " + std::to_string(g.id) + ", " + fixed(g.area_m2, 1) + "\u202fm²: " + reasons)
          .raw("</title></path>");
    }
  }
  svg.raw("</g><g data-layer=\"obstacles\">");
  for (const survey::Obstacle& o : d.obstacles) {
    svg.raw("<g")
        .attr("class", "obstacle " + std::string(survey::name_of(o.kind)))
        .raw("><circle")
        .attr("cx", o.position.x())
        .attr("cy", -o.position.y())
        .attr("r", std::max(0.05, 0.5 * o.width_m))
        .raw("><title>");
    svg.text(words_of(survey::name_of(o.kind)) + ": " + words_of(o.object_class) + " " +
             std::to_string(o.target.value) + ", " + fixed(o.width_m, 2) + "\u202fm wide")
        .raw("</title></circle></g>");
  }
  svg.raw("</g><g data-layer=\"route\">");
  if (d.route && d.route->path.size() > 1) {
    std::string path;
    for (const geometry::Vec2& p : d.route->path) path += (path.empty() ? "M" : "L") + point(p);
    svg.raw("<path class=\"route-casing\"").attr("d", path).raw("/><path class=\"route\"").attr("d", path).raw("/>");
    svg.raw("<g");
    place(svg, d.route->path.front());
    svg.raw("><circle class=\"fix route-end\" r=\"5\"/></g><g");
    place(svg, d.route->path.back());
    svg.raw(
        "><path class=\"fix route-end\" d=\"M0-8L2-2.6L7.6-2.5L3.1 1L4.7 6.5L0 3.2L-4.7 6.5L-3.1 "
        "1L-7.6-2.5L-2-2.6Z\"/></g>");
  }
  svg.raw("</g><g data-layer=\"frames\">");
  for (const FrameView& f : d.frames) {
    svg.raw("<g class=\"frame\"");
    place(svg, f.frame.T_world_camera.translation.head<2>());
    svg.attr("data-frame", std::to_string(f.frame.id.value));
    svg.raw("><g class=\"fix\"><path d=\"M0-9L5 4L0 1.4L-5 4Z\"")
        .attr("transform", "rotate(" + heading_of(f.frame) + ")")
        .raw("/></g><title>");
    svg.text((f.frame.image.empty() ? "Frame " + std::to_string(f.frame.id.value) : f.frame.image) + ", " +
             fixed(f.frame.T_world_camera.translation.z(), 1) + "\u202fm up")
        .raw("</title></g>");
  }
  svg.raw("</g><g data-layer=\"targets\">");
  for (const TargetView& t : d.targets) {
    const survey::Target& target = t.target;
    const ClassStyle style = page.style(target.object_class);
    const std::string id = std::to_string(target.id.value);
    svg.raw("<a")
        .attr("class", target.state == survey::TargetState::deregistered ? "target given-up" : "target")
        .attr("href", "#object-" + id)
        .attr("data-id", id);
    place(svg, target.centre.head<2>());
    svg.raw("><g class=\"fix\"><circle class=\"halo\" r=\"11\"/><path")
        .attr("d", symbol_path(style.shape))
        .attr("fill", style.colour)
        .raw("/><text class=\"name\" x=\"9\" y=\"4\">")
        .text(id)
        .raw("</text></g><title>")
        .text(words_of(target.object_class) + " " + id)
        .raw("</title></a>");
  }
  svg.raw("</g>");
  // A scale for readers without the script.
  const double length = nice_ceiling(unit * 90.0);
  const double x = page.view_min.x() + 12.0 * unit, y = -page.view_min.y() - 14.0 * unit;
  svg.raw("<g class=\"static-scale\"><path").attr("d", "M" + m(x) + " " + m(y) + "h" + m(length)).raw("/><g");
  svg.attr("transform", "translate(" + m(x) + " " + m(y - 5.0 * unit) + ")").raw("><text class=\"fix\">");
  svg.text(Html::short_number(length, 2) + "\u202fm").raw("</text></g></g>");
}

void overlay_choice(Html& h, std::string_view id, std::string_view label, std::size_t count, bool checked,
                    const Html& key) {
  if (count == 0) return;
  h.raw("<label class=\"choice\"><input type=\"checkbox\"").attr("id", "o-" + std::string(id)).attr("value", id);
  if (checked) h.raw(" checked");
  h.raw("><span>").add(key).text(label).raw("<small>").text(grouped(count)).raw("</small></span></label>");
}

Html key(std::string_view css_class) {
  Html h;
  h.raw("<i").attr("class", "key " + std::string(css_class)).raw("></i>");
  return h;
}

}  // namespace

Html map_figure(const PageContext& page) {
  const ReportData& d = page.data;
  const double width = page.view_max.x() - page.view_min.x(), height = page.view_max.y() - page.view_min.y();
  const double unit = width / kNominalWidthPx;
  Html svg, choices, legends, h;
  underlays(svg, choices, legends, page);
  overlays(svg, page, unit);

  h.raw(
       "<figure class=\"map\" id=\"map\"><div class=\"map-frame\"><svg class=\"map-svg\" role=\"img\" aria-label=\"Map "
       "of the survey\"")
      .attr("viewBox", m(page.view_min.x()) + " " + m(-page.view_max.y()) + " " + m(width) + " " + m(height))
      .attr("style", "--k:" + Html::short_number(unit, 5))
      .raw("><defs><pattern id=\"hatch\" patternUnits=\"userSpaceOnUse\"")
      .attr("width", 7.0 * unit)
      .attr("height", 7.0 * unit)
      .raw(" patternTransform=\"rotate(45)\"><path class=\"hatch\"")
      .attr("d", "M0 0V" + m(7.0 * unit))
      .attr("stroke-width", 2.4 * unit)
      .raw("/></pattern></defs>")
      .add(svg)
      .raw(
          "</svg><div class=\"north\" aria-hidden=\"true\"><svg viewBox=\"-10 -14 20 28\"><path d=\"M0-12L6 8L0 4L-6 "
          "8Z\"/></svg>N</div>"
          "<div class=\"zoom\" hidden><button type=\"button\" data-zoom=\"in\" aria-label=\"Zoom in\">+</button>"
          "<button type=\"button\" data-zoom=\"out\" aria-label=\"Zoom out\">−</button>"
          "<button type=\"button\" data-zoom=\"all\" aria-label=\"Show everything\">⤢</button></div>"
          "<div class=\"scalebar\" hidden><i></i><span></span></div>"
          "<output class=\"cursor\" aria-live=\"off\"></output></div>");
  h.raw("<figcaption><fieldset class=\"underlays\"><legend>Ground</legend>")
      .add(choices)
      .raw("</fieldset><fieldset class=\"overlays\"><legend>Show</legend>");
  Html target_key;
  for (const std::string& name : page.classes) {
    bool used = false;
    for (const TargetView& t : d.targets) used = used || t.target.object_class == name;
    if (used)
      target_key.raw("<span class=\"class-key\">").add(class_symbol(page, name)).text(words_of(name)).raw("</span>");
  }
  std::size_t footprints = 0;
  for (const FrameView& f : d.frames) footprints += f.footprint.empty() ? 0U : 1U;
  overlay_choice(h, "targets", "Objects", d.targets.size(), true, key("objects"));
  overlay_choice(h, "obstacles", "Obstacles", d.obstacles.size(), true, key("obstacle"));
  overlay_choice(h, "route", "Route", d.route ? 1 : 0, true, key("route"));
  overlay_choice(h, "gaps", "Gaps", d.coverage ? d.coverage->gaps.size() : 0, false, key("gap"));
  overlay_choice(h, "frames", "Photographs", d.frames.size(), true, key("frame"));
  overlay_choice(h, "footprints", "Footprints", footprints, false, key("footprint"));
  h.raw("</fieldset><div class=\"legends\">").add(legends);
  h.raw("<div class=\"legend-classes\">").add(target_key).raw("</div>");
  const bool given_up = std::any_of(d.targets.begin(), d.targets.end(), [](const TargetView& t) {
    return t.target.state == survey::TargetState::deregistered;
  });
  if (!d.frames.empty() || given_up) {
    h.raw("<p class=\"legend-note\">");
    if (!d.frames.empty()) h.raw("Photograph arrows stand at the camera and point where the top of the image points. ");
    if (given_up) h.raw("Pale objects are candidates that were given up.");
    h.raw("</p>");
  }
  h.raw("</div></figcaption></figure>");
  return h;
}

}  // namespace cairn::report
