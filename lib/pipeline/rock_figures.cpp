#include "pipeline/rock_figures.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "io/image.hpp"
#include "io/image_crop.hpp"
#include "io/json.hpp"
#include "io/survey_folder.hpp"
#include "report/rock_figures.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kLineStep_m = 0.02;  // long pieces of the line follow the lens's distortion

// The line that `surface` wrote for the rock, else the support polygon.
survey::Contact contact_of(const RockResult& result, const fs::path& input) {
  survey::Contact contact;
  const fs::path file = input / (result.stem + ".json");
  if (fs::is_directory(input) && fs::exists(file)) {
    const auto json = io::read_json(file);
    const auto* block = json.find("contact");
    const auto* line = block == nullptr ? nullptr : block->find("line");
    if (line != nullptr)
      for (const auto& row : line->as_array()) {
        survey::ContactVertex v;
        v.pad = row.at("pad").as_integer();
        v.order = row.at("order").as_integer();
        v.position = row.at("position_m").as_vec3();
        v.observed = row.at("status").as_string() == "observed";
        v.closed = row.at("closed").as_bool();
        contact.push_back(v);
      }
  }
  if (contact.empty())
    for (const auto& p : result.rock.tipping.contact) {
      survey::ContactVertex v;
      v.order = static_cast<std::int64_t>(contact.size());
      v.position = p;
      v.observed = !result.rock.tipping.contact_assumed;
      contact.push_back(v);
    }
  return contact;
}

// Pieces between neighbours of each pad, in the pixels of the part.
std::vector<report::PhotoLine> photo_lines(const survey::Contact& contact, const RockPhoto& photo,
                                           const survey::Frame& frame, const survey::Camera& camera,
                                           const io::ImagePart& part, double raster_scale) {
  std::vector<report::PhotoLine> lines;
  const auto piece = [&](std::size_t i, std::size_t j) {
    report::PhotoLine line;
    line.observed = contact[i].observed && contact[j].observed;
    line.visible = photo.hidden[i] == 0 && photo.hidden[j] == 0;
    const Vec3 &a = contact[i].position, &b = contact[j].position;
    const auto steps = static_cast<int>(std::clamp((b - a).norm() / kLineStep_m, 1.0, 200.0));
    for (int k = 0; k <= steps; ++k) {
      const double f = static_cast<double>(k) / steps;
      const auto pixel = camera::project_world(camera, frame.T_world_camera, (1.0 - f) * a + f * b);
      if (pixel) line.points.emplace_back((*pixel * raster_scale - Vec2(part.x_px, part.y_px)) * part.scale);
    }
    lines.push_back(std::move(line));
  };
  for (std::size_t begin = 0; begin < contact.size();) {
    std::size_t end = begin;
    while (end < contact.size() && contact[end].pad == contact[begin].pad) ++end;
    for (std::size_t i = begin; i + 1 < end; ++i) piece(i, i + 1);
    if (end - begin > 2 && contact[end - 1].closed) piece(end - 1, begin);
    begin = end;
  }
  return lines;
}

class Writer {
 public:
  Writer(const survey::Survey* survey, fs::path survey_folder, fs::path out, const FigureOptions& options,
         base::RunContext& ctx)
      : survey_(survey), survey_folder_(std::move(survey_folder)), out_(std::move(out)), options_(options), ctx_(ctx) {}

  void drawings(const RockResult& r) {
    const std::string title = (r.rock.object_class.empty() ? "rock" : r.rock.object_class) + " " + r.stem;
    if (r.rock.tipping.critical && r.rock.tipping.contact.size() >= 3) {
      write(r.stem + "_sections.svg", "sections",
            report::sections_svg(r.rock, r.mesh, title + ": sections through the centre of mass"));
      write(r.stem + "_views.svg", "views",
            report::side_views_svg(r.rock, r.mesh, title + ": side views", static_cast<std::size_t>(options_.view_px)));
    }
    const auto shares = report::uncertainty_svg(r.rock, title + ": what dominates the uncertainty");
    if (!shares.empty()) write(r.stem + "_uncertainty.svg", "uncertainty", shares);
  }

  void photographs(const RockResult& r, const survey::Contact& contact) {
    if (survey_ == nullptr) return;
    std::size_t n = 0;
    for (const auto& photo : rock_photos(r.mesh, contact, *survey_, static_cast<std::size_t>(options_.photos))) {
      try {
        write(r.stem + "_photo_" + std::to_string(n + 1) + ".svg", "photographs", photograph(r, contact, photo));
        ++n;
      } catch (const base::Error& error) {
        if (error.code() == base::ErrorCode::resource_exhausted) throw;
        ctx_.warn(std::string("no part of a photograph: ") + error.what());
      }
    }
  }

  [[nodiscard]] io::Json counts() const {
    io::Json json = io::Json::object();
    for (const auto& [kind, count] : counts_) json.set(kind, count);
    return json;
  }

 private:
  void write(const std::string& name, const char* kind, const std::string& text) {
    base::write_file(out_ / name, text);
    ++counts_[kind];
  }

  [[nodiscard]] std::string photograph(const RockResult& r, const survey::Contact& contact,
                                       const RockPhoto& photo) const {
    const auto& frame = *survey_->frame(photo.frame);
    const auto& camera = *survey_->camera(frame.camera);
    const auto file = io::resolve_reference(frame.image, survey_folder_);
    // Boxes are in the camera's pixels; the file may have been resized since.
    const double scale =
        static_cast<double>(io::read_image_header(file).width_px) / static_cast<double>(camera.width_px);
    io::ImageCropOptions crop;
    crop.margin = options_.photo_margin;
    crop.max_side_px = options_.photo_px;
    crop.outline = false;
    const geometry::PixelBox box{photo.box.xmin * scale, photo.box.ymin * scale, photo.box.xmax * scale,
                                 photo.box.ymax * scale};
    auto part = io::crop_parts(file, {box}, crop).front();
    if (part.jpeg.empty())
      throw base::Error(base::ErrorCode::invalid_input, "the rock lies outside").file(file.string());
    const auto lines = photo_lines(contact, photo, frame, camera, part, scale);
    const double shown = std::max(part.side_px, static_cast<double>(options_.photo_px));
    std::vector<report::PhotoLine> enlarged = lines;
    for (auto& line : enlarged)
      for (auto& p : line.points) p *= shown / part.side_px;
    return report::photo_svg(part.jpeg, shown, shown, enlarged,
                             r.rock.object_class + " " + r.stem + ", " + file.filename().string() +
                                 ", looking towards " + base::to_fixed(photo.azimuth_deg, 0) + "\u00b0");
  }

  const survey::Survey* survey_;
  fs::path survey_folder_, out_;
  const FigureOptions& options_;
  base::RunContext& ctx_;
  std::map<std::string, std::int64_t> counts_;
};

std::string shares_csv(const std::vector<RockResult>& results) {
  std::string text = "rock_id,name,source,variance_share_of_alpha\n";
  for (const auto& r : results) {
    if (!r.rock.tipping.uncertainty) continue;
    for (const auto& share : r.rock.tipping.uncertainty->variance_shares)
      text += std::to_string(r.rock.target.value) + "," + r.stem + "," + share.name + "," + base::to_text(share.value) +
              "\n";
  }
  return text;
}

}  // namespace

void FigureOptions::visit(base::OptionVisitor& visitor) {
  visitor.integer("figure-photos", photos, 0, 20, "figures: photographs of each rock");
  visitor.integer("figure-photo-px", photo_px, 64, 4000, "figures: side of a photograph's part");
  visitor.integer("figure-view-px", view_px, 64, 2000, "figures: longer side of a shaded view");
  visitor.real("figure-photo-margin", photo_margin, 0.0, 5.0, "figures: around the rock, in its longer side");
}

Outcome figure_files(const std::vector<RockResult>& results, const fs::path& input, const fs::path& survey_folder,
                     const fs::path& out, const FigureOptions& options, base::RunContext& ctx) {
  FigureOptions checked = options;
  base::validate(base::bind_options(checked), "figures");
  std::optional<survey::Survey> survey;
  if (!survey_folder.empty()) survey = io::read_survey(survey_folder);
  Writer writer(survey ? &*survey : nullptr, survey_folder, out, options, ctx);
  std::uint64_t done = 0;
  for (const auto& result : results) {
    ctx.check_stop();
    ctx.progress("figures", ++done, results.size());
    if (result.mesh.triangles.empty()) continue;
    writer.drawings(result);
    writer.photographs(result, contact_of(result, input));
  }
  base::write_file(out / "uncertainty.csv", shares_csv(results));
  Outcome outcome;
  outcome.summary = io::Json::object({{"figures", writer.counts()}});
  return outcome;
}

}  // namespace cairn::pipeline
