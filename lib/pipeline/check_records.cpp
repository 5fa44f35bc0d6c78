#include "pipeline/check_records.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "adjustment/robust.hpp"
#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "io/image.hpp"
#include "io/survey_folder.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::to_fixed;
using io::Json;

std::string frames_file(const fs::path& folder) {
  return (folder / "frames.csv").string();
}

void check_manifest(const CheckedSurvey& checked, const fs::path& folder, Findings& findings) {
  const auto& manifest = checked.survey.manifest;
  const std::string file = (folder / "survey.json").string();
  if (checked.has_origin && manifest.origin.height_type == survey::HeightType::unknown)
    findings.add({"origin_height_unknown", Severity::warning, file, "origin",
                  "it is not known what the survey's heights are measured from (found height_type unknown; allowed "
                  "ellipsoidal, orthometric, relative_takeoff)",
                  "Import again with --height-type, or with --takeoff-height and --takeoff-datum"});
  for (const auto& source : manifest.sources)
    if (source.confidence == survey::Confidence::assumed)
      findings.add({"convention_assumed", Severity::warning, file, "source '" + source.kind + "'",
                    "a convention was assumed, not declared: " + source.convention,
                    "See whether the evidence below supports it, or declare it at import"});
  for (const auto& c : manifest.cameras) {
    const std::string record = "camera " + std::to_string(c.id.value);
    const double width = static_cast<double>(c.width_px), height = static_cast<double>(c.height_px);
    const double view_deg = 2.0 * base::rad_to_deg(std::atan2(0.5 * width, c.fx_px));
    constexpr double kLeastDeg = 2.0, kMostDeg = 150.0, kAspect = 0.05;
    if (c.model != survey::CameraModel::fisheye && (view_deg < kLeastDeg || view_deg > kMostDeg))
      findings.add({"camera_implausible", Severity::warning, file, record,
                    told("the angle of view is implausible", to_fixed(view_deg, 1) + " degrees",
                         "2 to 150 degrees for this camera model"),
                    "Give the focal length in pixels of the images as stored"});
    if (c.cx_px < 0.0 || c.cx_px > width || c.cy_px < 0.0 || c.cy_px > height)
      findings.add(
          {"camera_implausible", Severity::warning, file, record,
           told("the principal point lies outside the image", to_fixed(c.cx_px, 1) + ", " + to_fixed(c.cy_px, 1),
                "0 to " + std::to_string(c.width_px) + ", 0 to " + std::to_string(c.height_px)),
           "Give the principal point in pixels from the image's corner"});
    if (std::abs(c.fx_px / c.fy_px - 1.0) > kAspect)
      findings.add({"camera_implausible", Severity::warning, file, record,
                    told("the two focal lengths differ", to_fixed(c.fx_px, 1) + " and " + to_fixed(c.fy_px, 1) + " px",
                         "within 5 %"),
                    "Check fx_px and fy_px"});
  }
}

void check_times(const CheckedSurvey& checked, const fs::path& folder, Findings& findings) {
  const auto& frames = checked.survey.frames;
  const survey::Frame* before = nullptr;
  std::map<std::pair<std::int64_t, std::int64_t>, const survey::Frame*> seen;
  for (const auto& frame : frames) {
    if (frame.time_ns == 0) continue;
    const auto [it, fresh] = seen.emplace(std::pair(frame.camera.value, frame.time_ns), &frame);
    if (!fresh)
      findings.add({"duplicate_time", Severity::warning, frames_file(folder), checked.frame_records.at(frame.id),
                    told("two frames of one camera have the same time",
                         std::to_string(frame.time_ns) + " ns, as frame " + std::to_string(it->second->id.value), ""),
                    "Remove the frame that is there twice, or give the true times"});
    if (before != nullptr && frame.time_ns < before->time_ns)
      findings.add({"time_not_ascending", Severity::warning, frames_file(folder), checked.frame_records.at(frame.id),
                    told("the time is earlier than that of the frame before",
                         to_fixed(static_cast<double>(before->time_ns - frame.time_ns) * 1e-9, 3) + " s before frame " +
                             std::to_string(before->id.value),
                         "ascending times"),
                    "Number the frames in the order of their exposure"});
    before = &frame;
  }
}

void check_duplicates(const CheckedSurvey& checked, const fs::path& folder, Findings& findings) {
  std::map<std::string, survey::FrameId> images;
  std::map<std::tuple<double, double, double>, survey::FrameId> places;
  for (const auto& frame : checked.survey.frames) {
    const std::string& record = checked.frame_records.at(frame.id);
    if (!frame.image.empty()) {
      const auto [it, fresh] = images.emplace(frame.image, frame.id);
      if (!fresh)
        findings.add({"duplicate_image", Severity::error, frames_file(folder), record,
                      told("two frames use the same image",
                           frame.image + ", as frame " + std::to_string(it->second.value), "one frame an image"),
                      "Remove the frame that is there twice"});
    }
    const auto& p = frame.T_world_camera.translation;
    const auto [it, fresh] = places.emplace(std::tuple(p.x(), p.y(), p.z()), frame.id);
    if (!fresh)
      findings.add({"duplicate_pose", Severity::warning, frames_file(folder), record,
                    "the position is exactly that of frame " + std::to_string(it->second.value),
                    "Check that the positions were not repeated, for example by a GPS that did not move on"});
  }
}

void check_detections(const CheckedSurvey& checked, const fs::path& folder, const CheckOptions& options,
                      Findings& findings, Json& evidence) {
  const std::string file = (folder / "detections.csv").string();
  std::map<std::string, std::size_t> classes;
  using Key = std::tuple<std::int64_t, std::string, double, double, double, double>;
  std::map<Key, survey::DetectionId> seen;
  for (const auto& d : checked.survey.detections) {
    ++classes[d.object_class];
    const std::string& record = checked.detection_records.at(d.id);
    const auto [it, fresh] =
        seen.emplace(Key(d.frame.value, d.object_class, d.box.xmin, d.box.ymin, d.box.xmax, d.box.ymax), d.id);
    if (!fresh)
      findings.add({"duplicate_detection", Severity::warning, file, record,
                    "the same box of the same class stands in detection " + std::to_string(it->second.value),
                    "Remove the double"});
    if (!(d.box.area() > 0.0))
      findings.add({"box_empty", Severity::warning, file, record, "the box has no area", "Remove the row"});
    const auto* frame = checked.survey.frame(d.frame);
    const auto* camera = frame == nullptr ? nullptr : checked.survey.camera(frame->camera);
    if (camera == nullptr) continue;
    const double width = static_cast<double>(camera->width_px), height = static_cast<double>(camera->height_px);
    const double over = std::max({-d.box.xmin, -d.box.ymin, d.box.xmax - width, d.box.ymax - height});
    if (over > options.box_tolerance_px)
      findings.add({"box_outside_image", Severity::error, file, record,
                    told("the box passes the image's border by " + to_fixed(over, 1) + " px",
                         to_fixed(d.box.xmin, 1) + "," + to_fixed(d.box.ymin, 1) + "," + to_fixed(d.box.xmax, 1) + "," +
                             to_fixed(d.box.ymax, 1),
                         "0,0," + std::to_string(camera->width_px) + "," + std::to_string(camera->height_px)),
                    "Give boxes in pixels of the raw image of the declared size (--scale-images at import scales "
                    "them)"});
  }
  Json counts = Json::object();
  for (const auto& [name, count] : classes) counts.set(name, count);
  evidence.set("detection_classes", std::move(counts));
}

}  // namespace

void check_records(const CheckedSurvey& checked, const fs::path& folder, const CheckOptions& options,
                   Findings& findings, Json& evidence) {
  const auto& survey = checked.survey;
  evidence.set("cameras", survey.manifest.cameras.size());
  evidence.set("frames", survey.frames.size());
  evidence.set("frame_rows", checked.frame_rows);
  evidence.set("detections", survey.detections.size());
  evidence.set("detection_rows", checked.detection_rows);
  evidence.set("tie_points", survey.ties.size());
  if (survey.manifest.cameras.empty() && !findings.has("camera_invalid") && !findings.has("survey_json"))
    findings.add({"no_cameras", Severity::error, (folder / "survey.json").string(), "cameras",
                  "the survey has no camera (found 0; allowed at least 1)", "Import the survey again"});
  if (checked.frame_rows == 0 && !findings.has("table_missing") && !findings.has("table_malformed"))
    findings.add({"no_frames", Severity::error, frames_file(folder), "",
                  "the survey has no frames (found 0 rows; "
                  "allowed at least 1)",
                  "Import the survey again"});
  check_manifest(checked, folder, findings);
  check_times(checked, folder, findings);
  check_duplicates(checked, folder, findings);
  check_detections(checked, folder, options, findings, evidence);
}

std::map<survey::FrameId, fs::path> check_images(const CheckedSurvey& checked, const fs::path& folder,
                                                 Findings& findings, Json& evidence) {
  std::map<survey::FrameId, fs::path> usable;
  std::size_t without = 0;
  for (const auto& frame : checked.survey.frames) {
    if (frame.image.empty()) {
      ++without;
      continue;
    }
    const fs::path path = io::resolve_reference(frame.image, folder);
    const std::string& record = checked.frame_records.at(frame.id);
    std::error_code code;
    if (!fs::exists(path, code)) {
      findings.add({"image_missing", Severity::error, path.string(), "frames.csv, " + record,
                    told("the image of a frame is missing", "no file", "a JPEG or PNG file"),
                    "Put the image back, or import again with the folder that holds it"});
      continue;
    }
    try {
      const auto header = io::read_image_header(path);
      const auto* camera = checked.survey.camera(frame.camera);
      if (header.width_px != camera->width_px || header.height_px != camera->height_px) {
        const std::string found = std::to_string(header.width_px) + " x " + std::to_string(header.height_px);
        const std::string allowed = std::to_string(camera->width_px) + " x " + std::to_string(camera->height_px) +
                                    " of camera " + std::to_string(camera->id.value);
        const bool turned = header.width_px == camera->height_px && header.height_px == camera->width_px;
        const double scale = static_cast<double>(header.width_px) / static_cast<double>(camera->width_px);
        findings.add({"image_size_mismatch", Severity::error, path.string(), "frames.csv, " + record,
                      told("the image is not of the size the camera is declared for", found, allowed),
                      turned ? "The image was turned by 90 degrees: store it as it was exposed"
                             : "Import again with --scale-images " + to_fixed(scale, 4) +
                                   ", or use the images the camera was calibrated with"});
        continue;
      }
      usable.emplace(frame.id, path);
    } catch (base::Error& error) {
      error.default_file(path.string());
      findings.add("image_unreadable", error, "frames.csv, " + record);
    }
  }
  evidence.set("images_usable", usable.size());
  if (without > 0 && without == checked.survey.frames.size())
    findings.add({"no_image", Severity::info, frames_file(folder), "",
                  "no frame names an image: nothing could be "
                  "compared with pixels",
                  "Import with --images to have the poses proved by pixels"});
  return usable;
}

void check_heights(const CheckedSurvey& checked, const fs::path& folder,
                   const std::map<survey::FrameId, double>& ground, const std::string& ground_by,
                   const CheckOptions& options, Findings& findings, Json& evidence) {
  if (ground.empty()) return;
  std::vector<double> heights;
  std::size_t missing = 0;
  for (const auto& frame : checked.survey.frames) {
    const auto it = ground.find(frame.id);
    if (it == ground.end()) continue;
    const double height = frame.T_world_camera.translation.z() - it->second;
    heights.push_back(height);
    if (!(height >= options.min_height_m && height <= options.max_height_m))
      findings.add({"height_above_ground", Severity::error, frames_file(folder), checked.frame_records.at(frame.id),
                    told("the camera is at an impossible height above the ground",
                         to_fixed(height, 1) + " m (ground by " + ground_by + ")",
                         to_fixed(options.min_height_m, 0) + " to " + to_fixed(options.max_height_m, 0) + " m"),
                    "Check the poses' height and datum, and that poses were not read inverted"});
    const double down = -frame.T_world_camera.rotation(2, 2);  // drop per metre along the optical axis
    if (!(down > 0.0 && height > 0.0 && height / down <= options.max_range_m)) ++missing;
  }
  const double share = 1.0 - static_cast<double>(missing) / static_cast<double>(heights.size());
  evidence.set("height_above_ground", Json::object({{"by", ground_by},
                                                    {"frames", heights.size()},
                                                    {"least_m", *std::min_element(heights.begin(), heights.end())},
                                                    {"median_m", adjustment::median(heights)},
                                                    {"largest_m", *std::max_element(heights.begin(), heights.end())},
                                                    {"axis_hits_share", share}}));
  if (share < options.min_axis_hits)
    findings.add({"axis_misses_ground", Severity::error, frames_file(folder),
                  std::to_string(missing) + " of " + std::to_string(heights.size()) + " frames",
                  told("the optical axis does not meet the ground", to_fixed(100.0 * share, 0) + " % of the frames",
                       "at least " + to_fixed(100.0 * options.min_axis_hits, 0) + " %, within " +
                           to_fixed(options.max_range_m, 0) + " m"),
                  "Check the convention of the poses: direction, quaternion order, camera axes (x right, y down, z "
                  "forward)"});
}

}  // namespace cairn::pipeline
