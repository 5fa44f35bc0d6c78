// cairn import dji|colmap|opensfm|csv INPUT -o SURVEY
#include <cmath>
#include <limits>

#include "io/detections.hpp"
#include "pipeline/import_colmap.hpp"
#include "pipeline/import_csv.hpp"
#include "pipeline/import_dji.hpp"
#include "pipeline/import_opensfm.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

std::optional<double> given(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

survey::HeightType height_type(const std::string& name) {
  return survey::height_type_from(name).value_or(survey::HeightType::unknown);
}

const std::vector<std::string>& height_types() {
  static const std::vector<std::string> names{"ellipsoidal", "orthometric", "relative_takeoff", "unknown"};
  return names;
}

class ImportCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.word("format", format_, {"dji", "colmap", "opensfm", "csv"}, "What is imported");
    arguments.input("input", input_,
                    "Folder of images (dji), model folder (colmap), reconstruction or project folder (opensfm), table "
                    "of frames (csv)");
    arguments.output(out_, "Survey folder to make");
    arguments.option("images", images_, "Folder of the images (colmap, opensfm, csv)");
    arguments.option("origin", origin_, "LAT,LON,HEIGHT of the local frame, degrees and metres");
    arguments.choice("height-type", height_type_, height_types(), "What the origin's height is measured from");
    arguments.option("name", in_.name, "Name of the survey; the folder's name where it is not given");
    arguments.option(
        "detections", in_.detections,
        "Boxes to attach: CSV (image,class,xmin_px,ymin_px,xmax_px,ymax_px,score), COCO, YOLO, Pascal VOC, "
        "CVAT, darknet, MOT");
    std::vector<std::string> box_formats{"auto"};
    box_formats.insert(box_formats.end(), io::box_format_names().begin(), io::box_format_names().end());
    arguments.choice("detections-format", in_.detections_format, box_formats, "Format of the boxes");
    arguments.option("detections-names", in_.detections_names, "Class names of boxes that number them, one a line");
    arguments.option("detections-scale", detections_scale_,
                     "Box pixels times this are image file pixels; default: the scale of the images");
    arguments.option("cloud", in_.cloud, "Point cloud to attach (LAS)");
    arguments.option("cloud-crs", in_.cloud_crs, "CRS of the cloud (EPSG:n, WKT, or local), over what it declares");
    arguments.choice("cloud-height-type", cloud_height_type_, height_types(),
                     "What the cloud's heights are measured from");
    arguments.option("similarity", in_.similarity, "Similarity between the poses' frame and the cloud's (JSON)");
    arguments.flag("copy-images", in_.copy_images, "Copy the images into the survey instead of naming them");
    arguments.flag("strict", in_.strict, "An assumed convention or a frame without pose is an error");
    arguments.option("takeoff-height", takeoff_height_, "dji: height of the take-off point, m");
    arguments.choice("takeoff-datum", dji_.takeoff_datum, {"ellipsoidal", "egm96"}, "dji: what it is measured from");
    arguments.option("rotate", dji_.rotate,
                     "dji: images whose pixels were turned by 180 degrees (DJI_0024-DJI_0029,...)");
    arguments.option("tracks", tracks_, "opensfm: tracks.csv; default: the one beside the reconstruction");
    arguments.option("scale-images", scale_images_, "colmap: image file pixels per model pixel (0.4)");
    arguments.option("camera", csv_.camera, "csv, dji: MODEL,WIDTH,HEIGHT,PARAMETERS as in COLMAP");
    arguments.choice("pose", csv_.pose, {"camera-to-world", "world-to-camera"}, "csv: direction of the quaternions");
    arguments.choice("angles", csv_.angles, {"gimbal", "nadir-body"}, "csv: what yaw, pitch and roll are of");
    arguments.choice("time-base", csv_.time_base, {"utc", "gps", "boot", "unknown"}, "csv: base of time_ns");
    arguments.example("cairn import dji photos -o survey --takeoff-height 158 --takeoff-datum ellipsoidal");
    arguments.example(
        "cairn import colmap sparse/0 --images photos --origin 46.8426,-91.9940,158.0 --height-type ellipsoidal "
        "--detections boxes.csv -o survey");
    arguments.example("cairn import opensfm project/reconstruction.json --images project/images -o survey");
    arguments.example(
        "cairn import csv frames.csv --images photos --camera PINHOLE,1600,900,914,914,800,450 "
        "--pose camera-to-world --origin 46.84,-91.99,158 --height-type ellipsoidal -o survey");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    pipeline::check_output_folder(out_, arguments.common.overwrite);
    resolve();
    if (arguments.common.dry_run)
      return {io::Json::object({{"would_write", out_.string()}}), "Would write " + out_.string() + "\n"};
    pipeline::RunRecord record{"import", arguments.resolved(false), ctx.seed, digests(), {}, {}, {}, {}};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, std::move(record),
        [&](const std::filesystem::path& staged) { return import(staged, ctx); }, ctx);
    const auto count = [&](const char* name) { return std::to_string(outcome.summary.at(name).as_integer()); };
    std::string text = "Survey " + out_.string() + ": " + count("frames") + " frames, " + count("detections") +
                       " detections, " + count("tie_points") + " tie points\n";
    if (!outcome.rejects.empty()) text += std::to_string(outcome.rejects.size()) + " images left out, see run.json\n";
    return {outcome.summary, text, outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

 private:
  void resolve() {
    in_.survey_folder = out_;
    if (!origin_.empty()) in_.origin = pipeline::parse_origin(origin_);
    if (!height_type_.empty()) in_.height_type = height_type(height_type_);
    in_.cloud_height_type = height_type(cloud_height_type_);
    in_.detections_scale = given(detections_scale_);
    const bool needs_cloud = !in_.similarity.empty() || !in_.cloud_crs.empty();
    if (needs_cloud && in_.cloud.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "--similarity and --cloud-crs are about a cloud")
          .hint("Add --cloud");
    if (format_ == "colmap" && images_.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "the images of the model are needed").hint("Add --images");
  }

  // The model's and the images' files by content; the images of a table are those it names.
  [[nodiscard]] std::vector<pipeline::InputDigest> digests() const {
    std::vector<std::filesystem::path> inputs{input_};
    for (const auto* path : {&in_.detections, &in_.cloud, &in_.similarity, &tracks_})
      if (!path->empty()) inputs.push_back(*path);
    return pipeline::digest_inputs(inputs);
  }

  pipeline::Outcome import(const std::filesystem::path& staged, base::RunContext& ctx) {
    if (format_ == "dji") {
      dji_.common = in_;
      dji_.images = input_;
      dji_.camera = csv_.camera;
      dji_.takeoff_height_m = given(takeoff_height_);
      return pipeline::import_dji(dji_, staged, ctx);
    }
    if (format_ == "colmap") return pipeline::import_colmap({in_, input_, images_, given(scale_images_)}, staged, ctx);
    if (format_ == "opensfm") return pipeline::import_opensfm({in_, input_, tracks_, images_}, staged, ctx);
    csv_.common = in_;
    csv_.table = input_;
    csv_.images = images_;
    return pipeline::import_csv(csv_, staged, ctx);
  }

  std::string format_, origin_, height_type_, cloud_height_type_ = "unknown";
  std::filesystem::path input_, out_, images_, tracks_;
  double detections_scale_ = kNotGiven, takeoff_height_ = kNotGiven, scale_images_ = kNotGiven;
  pipeline::ImportInputs in_;
  pipeline::ImportDjiInputs dji_;
  pipeline::ImportCsvInputs csv_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::ImportCommand)
