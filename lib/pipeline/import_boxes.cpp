// Boxes of foreign formats, joined to a survey's frames.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/detections.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/import_survey.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

// A frame of each image, by its whole name, its last part, or that part without extension; -1 = not unique.
using Index = std::map<std::string, std::ptrdiff_t, std::less<>>;

Index index_of(const std::vector<std::string>& names) {
  Index whole, last, stem;
  const auto add = [](Index& index, const std::string& key, std::size_t i) {
    const auto [at, fresh] = index.emplace(key, static_cast<std::ptrdiff_t>(i));
    if (!fresh && at->second != static_cast<std::ptrdiff_t>(i)) at->second = -1;
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    const fs::path path(names[i]);
    add(whole, names[i], i);
    add(last, path.filename().string(), i);
    add(stem, path.stem().string(), i);
  }
  // What is said more fully counts before.
  for (const auto* more : {&last, &stem})
    for (const auto& [name, frame] : *more) whole.emplace(name, frame);
  return whole;
}

class Join {
 public:
  Join(const Imported& imported, const io::BoxFile& file, const fs::path& path)
      : imported_(imported), file_(file), path_(path), by_name_(index_of(imported.image_names)) {}

  survey::FrameId frame_of(const io::ImageBox& box) const {
    const auto& image = file_.images[box.image];
    return image.name.empty() ? by_number(image.number, box) : by_name(image.name, box);
  }

  Error error(const io::ImageBox& box, const std::string& message) const {
    return Error(ErrorCode::invalid_input, message).file(path_.string()).record("box " + std::to_string(box.line));
  }

 private:
  survey::FrameId by_name(const std::string& name, const io::ImageBox& box) const {
    for (const auto& key : {name, fs::path(name).filename().string(), fs::path(name).stem().string()}) {
      const auto at = by_name_.find(key);
      if (at == by_name_.end()) continue;
      if (at->second < 0)
        throw error(box, "several frames have an image of this name")
            .found("'" + name + "'")
            .hint("Name the image with its folder");
      return imported_.survey.frames[static_cast<std::size_t>(at->second)].id;
    }
    throw error(box, "detection of an unknown frame")
        .found("'" + name + "'")
        .allowed("the image name of one of the " + std::to_string(imported_.image_names.size()) + " frames")
        .hint("Remove the box, or import the image with its pose");
  }

  // mot counts frames from 1, cvat's videos from 0; other numbers are frame ids.
  survey::FrameId by_number(std::int64_t number, const io::ImageBox& box) const {
    const auto& frames = imported_.survey.frames;
    if (file_.format == io::BoxFormat::mot || file_.format == io::BoxFormat::cvat) {
      const std::int64_t first = file_.format == io::BoxFormat::mot ? 1 : 0;
      if (number >= first && number - first < static_cast<std::int64_t>(frames.size()))
        return frames[static_cast<std::size_t>(number - first)].id;
      throw error(box, "detection of an unknown frame")
          .found("frame " + std::to_string(number))
          .allowed(std::to_string(first) + " to " +
                   std::to_string(first + static_cast<std::int64_t>(frames.size()) - 1) +
                   ", in the order of the frame ids");
    }
    if (imported_.survey.frame(survey::FrameId(number)) == nullptr)
      throw error(box, "detection of an unknown frame")
          .found("image " + std::to_string(number))
          .allowed("a frame id of the survey")
          .hint("Give a file that names the images");
    return survey::FrameId(number);
  }

  const Imported& imported_;
  const io::BoxFile& file_;
  const fs::path& path_;
  Index by_name_;
};

void check(const io::ImageBox& box, const Join& join) {
  const auto& b = box.box;
  for (const double value : {b.xmin, b.ymin, b.xmax, b.ymax, box.score})
    if (!std::isfinite(value)) throw join.error(box, "number is not finite").found(base::to_text(value));
  if (box.score < 0.0 || box.score > 1.0)
    throw join.error(box, "score out of range").found(base::to_text(box.score)).allowed("0 to 1");
  if (b.xmax < b.xmin || b.ymax < b.ymin)
    throw join.error(box, "box ends before it begins")
        .found(base::to_text(b.width()) + " x " + base::to_text(b.height()) + " px")
        .allowed("0 or more");
}

std::string order_sentence(io::BoxFormat format) {
  if (format == io::BoxFormat::mot) return " Frame 1 is the first of the survey's frames by id.";
  if (format == io::BoxFormat::cvat)
    return " Frames without a name: frame 0 is the first of the survey's frames by id.";
  return "";
}

}  // namespace

void attach_boxes(Imported& imported, const ImportInputs& in, double scale) {
  if (!(scale > 0.0) || !std::isfinite(scale))
    throw Error(ErrorCode::invalid_argument, "scale of the detections is not positive")
        .found(base::to_text(scale))
        .allowed("more than 0");
  const fs::path& path = in.detections;
  const auto format =
      in.detections_format == "auto" ? io::recognise_boxes(path) : io::box_format_from(in.detections_format);
  io::ReadBoxesOptions options;
  if (!in.detections_names.empty()) options.class_names = io::read_class_names(in.detections_names);
  for (const auto& image : imported.image_files)
    if (options.images.empty() && !image.empty()) options.images = image.parent_path();
  const io::BoxFile file = io::read_boxes(path, format, options);
  const Join join(imported, file, path);
  std::size_t ignored = 0;
  for (const auto& box : file.boxes) {
    if (box.ignored) {
      ++ignored;
      continue;
    }
    check(box, join);
    survey::Detection d;
    d.id = survey::DetectionId(static_cast<std::int64_t>(imported.survey.detections.size()) + 1);
    d.frame = join.frame_of(box);
    d.object_class = box.object_class.empty() ? "object" : box.object_class;
    d.score = box.score;
    d.box = {box.box.xmin * scale, box.box.ymin * scale, box.box.xmax * scale, box.box.ymax * scale};
    imported.survey.detections.push_back(std::move(d));
  }
  survey::Source source;
  source.kind = "detections";
  source.path = io::file_reference(path, in.survey_folder);
  source.convention = file.convention + order_sentence(file.format) + " Multiplied by " + base::to_text(scale) +
                      " to the pixels of the image files.";
  source.confidence = survey::Confidence::inferred;
  imported.survey.manifest.sources.push_back(std::move(source));
  if (ignored > 0)
    imported.survey.manifest.notes.push_back(std::to_string(ignored) + " boxes that " + path.filename().string() +
                                             " marks as not counting (difficult, crowd) were left out.");
}

}  // namespace cairn::pipeline
