#include "pipeline/track_stage.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "io/survey_folder.hpp"
#include "io/tracks_csv.hpp"
#include "tracking/sort.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using base::Reject;
using tracking::BoxFault;
using tracking::BoxObservation;

struct Counts {
  std::int64_t frames = 0, boxes = 0, used = 0, rows = 0, coasted = 0, started = 0, emitted = 0, non_finite = 0;

  void add(const Counts& o) {
    frames += o.frames;
    boxes += o.boxes;
    used += o.used;
    rows += o.rows;
    coasted += o.coasted;
    started += o.started;
    emitted += o.emitted;
    non_finite += o.non_finite;
  }
  void add(const tracking::SortTracker& tracker) {
    started += tracker.tracks_started();
    emitted += tracker.tracks_emitted();
    non_finite += tracker.non_finite_tracks();
  }
};

// Classes as numbers, in the order they are met.
class Classes {
 public:
  int number(const std::string& name) {
    if (last_ != numbers_.end() && last_->first == name) return last_->second;
    last_ = numbers_.emplace(name, static_cast<int>(names_.size())).first;
    if (static_cast<std::size_t>(last_->second) == names_.size()) names_.push_back(name);
    return last_->second;
  }
  [[nodiscard]] const std::string& name(int number) const { return names_[static_cast<std::size_t>(number)]; }

 private:
  std::map<std::string, int> numbers_;
  std::map<std::string, int>::iterator last_ = numbers_.end();
  std::vector<std::string> names_;
};

// The boxes of one frame that can be used; `source` tells where each comes from.
class FrameBoxes {
 public:
  FrameBoxes(const tracking::SortOptions& options) : options_(options) {}

  void clear() {
    candidates_.clear();
    candidate_source_.clear();
  }
  void add(const BoxObservation& o, std::size_t from) {
    candidates_.push_back(o);
    candidate_source_.push_back(from);
  }
  // record_of(source) names a box in its reject.
  template <typename RecordOf>
  void screen(std::vector<Reject>& rejects, RecordOf&& record_of) {
    boxes.clear();
    source.clear();
    const auto faults = tracking::screen_boxes(candidates_, options_.min_score, options_.keep_duplicates);
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (faults[i] == BoxFault::none) {
        boxes.push_back(candidates_[i]);
        source.push_back(candidate_source_[i]);
      } else {
        rejects.push_back({record_of(candidate_source_[i]), name_of(faults[i]), describe(faults[i], candidates_[i])});
      }
    }
  }

  std::vector<BoxObservation> boxes;
  std::vector<std::size_t> source;

 private:
  const tracking::SortOptions& options_;
  std::vector<BoxObservation> candidates_;
  std::vector<std::size_t> candidate_source_;
};

void check(TrackStageOptions options) {
  base::validate(base::bind_options(options), "track");
}

geometry::PixelBox box_to_write(const tracking::TrackedObservation& o, std::span<const BoxObservation> boxes,
                                bool detected) {
  return detected && !o.coasted() ? boxes[o.observation].box : o.box;
}

struct FileResult {
  Counts counts;
  std::vector<io::MotRow> rows;
  std::vector<Reject> rejects, notices;
};

// Indices of the boxes by image, in the file's order within each. The boxes of image i are begin[i]..begin[i + 1].
struct ByImage {
  std::vector<std::size_t> order, begin;

  explicit ByImage(const io::BoxFile& file) : order(file.boxes.size()), begin(file.images.size() + 1, 0) {
    for (const auto& box : file.boxes) ++begin[box.image + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t i = 0; i < file.boxes.size(); ++i) order[next[file.boxes[i].image]++] = i;
  }
};

FileResult track_file(const fs::path& path, const TrackFileInputs& in, const TrackStageOptions& options,
                      const base::RunContext& ctx) {
  auto reading = in.reading;
  reading.as_in_file = true;
  const auto format = in.format == "auto" ? io::recognise_boxes(path) : io::box_format_from(in.format);
  const io::BoxFile file = io::read_boxes(path, format, reading);
  const bool mot = file.format == io::BoxFormat::mot;
  const bool detected = options.boxes == "detected";
  FileResult result;
  if (file.unsorted)
    result.notices.push_back({path.string(), "unsorted_frames", "frame numbers do not ascend; taken in their order"});
  tracking::SortTracker tracker(options.sort);
  const tracking::SortOptions resolved = tracking::resolved(options.sort);
  FrameBoxes frame(resolved);
  Classes classes;
  const ByImage by_image(file);
  const auto record_of = [&](std::size_t i) { return path.string() + ", line " + std::to_string(file.boxes[i].line); };
  const auto step = [&](std::int64_t number) {
    const auto tracked = tracker.step(frame.boxes);
    ++result.counts.frames;
    for (const auto& o : tracked) {
      result.rows.push_back({number, o.id, box_to_write(o, frame.boxes, detected), options.scores ? o.score : 1.0});
      result.counts.coasted += o.coasted() ? 1 : 0;
    }
  };
  std::int64_t next = 1;
  for (std::size_t i = 0; i < file.images.size(); ++i) {
    ctx.check_stop();
    const std::int64_t number = mot ? file.images[i].number : static_cast<std::int64_t>(i) + 1;
    frame.clear();
    for (std::size_t k = by_image.begin[i]; k < by_image.begin[i + 1]; ++k) {
      const auto& box = file.boxes[by_image.order[k]];
      if (number < 0) {
        result.rejects.push_back({record_of(by_image.order[k]), "frame_out_of_range",
                                  "frame " + std::to_string(number) + ": frames count from 1 or from 0"});
        continue;
      }
      frame.add({box.box, classes.number(box.object_class), box.score}, by_image.order[k]);
    }
    if (number < 0) continue;
    if (number == 0) next = 0;
    // Frames in between without a box.
    frame.boxes.clear();
    for (; next < number && !tracker.idle(); ++next) step(next);
    if (next < number) {
      tracker.skip_frames(number - next);
      result.counts.frames += number - next;
      next = number;
    }
    frame.screen(result.rejects, record_of);
    result.counts.used += static_cast<std::int64_t>(frame.boxes.size());
    step(next++);
  }
  result.counts.boxes = static_cast<std::int64_t>(file.boxes.size());
  result.counts.rows = static_cast<std::int64_t>(result.rows.size());
  result.counts.add(tracker);
  return result;
}

io::Json summary_of(const Counts& c, const std::vector<Reject>& rejects, const std::vector<Reject>& notices) {
  return io::Json::object({{"frames", c.frames},
                           {"boxes", c.boxes},
                           {"used", c.used},
                           {"rejected", rejects.size()},
                           {"tracks", c.emitted},
                           {"tracks_started", c.started},
                           {"rows", c.rows},
                           {"coasted_rows", c.coasted},
                           {"non_finite_tracks", c.non_finite},
                           {"rejects_by_reason", count_by_reason(rejects)},
                           {"notices_by_reason", count_by_reason(notices)}});
}

void tell(const std::vector<Reject>& rejects, const std::vector<Reject>& notices, base::RunContext& ctx) {
  constexpr std::size_t kMost = 20;
  for (std::size_t i = 0; i < std::min(notices.size(), kMost); ++i)
    ctx.warn(notices[i].record + ": " + notices[i].reason + ": " + notices[i].message);
  std::map<std::string, std::pair<std::size_t, const Reject*>> first;
  for (const auto& r : rejects) {
    auto& [count, example] = first[r.reason];
    if (count++ == 0) example = &r;
  }
  for (const auto& [reason, found] : first)
    ctx.warn(std::to_string(found.first) + " boxes not used: " + reason + " (first: " + found.second->record + ": " +
             found.second->message + ")");
}

}  // namespace

void TrackStageOptions::visit(base::OptionVisitor& visitor) {
  sort.visit(visitor);
  visitor.flag("real-time", order.real_time, "survey: predict over the time between frames, in nominal periods");
  visitor.real("clock-jump", order.clock_jump, 1.5, 1e9,
               "survey: a step of more nominal periods than this ends all tracks");
  visitor.choice(
      "boxes", boxes, {"auto", "filtered", "detected"},
      "what is written of a detected box: the filter's estimate or the detector's own; auto = detected for a "
      "survey, filtered for files");
  visitor.flag("scores", scores, "write the detector's scores; otherwise 1");
}

Outcome track_files(const std::vector<TrackFile>& files, const TrackFileInputs& in, const TrackStageOptions& options,
                    base::RunContext& ctx) {
  check(options);
  std::vector<FileResult> results(files.size());
  base::parallel_for(files.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      results[i] = track_file(files[i].in, in, options, ctx);
      io::write_mot(files[i].out, results[i].rows);
      results[i].rows = {};
    }
  });
  Counts total;
  std::vector<Reject> rejects, notices;
  io::Json list = io::Json::array();
  for (std::size_t i = 0; i < files.size(); ++i) {
    auto& r = results[i];
    total.add(r.counts);
    io::Json one = io::Json::object({{"file", files[i].in.string()}});
    const io::Json counted = summary_of(r.counts, r.rejects, r.notices);
    for (const auto& [key, value] : counted.as_object()) one.set(key, value);
    list.push(std::move(one));
    rejects.insert(rejects.end(), r.rejects.begin(), r.rejects.end());
    notices.insert(notices.end(), r.notices.begin(), r.notices.end());
  }
  tell(rejects, notices, ctx);
  io::Json summary = summary_of(total, rejects, notices);
  summary.set("files", std::move(list));
  return {std::move(summary), std::move(rejects)};
}

Outcome track_survey(const fs::path& folder, const fs::path& out, const TrackStageOptions& options,
                     base::RunContext& ctx) {
  check(options);
  const survey::Survey survey = io::read_survey(folder);
  if (survey.detections.empty())
    throw Error(ErrorCode::failed_precondition, "the survey has no detections")
        .file((folder / "detections.csv").string())
        .hint("Attach a detector's boxes with 'cairn import ... --detections FILE', or make them with 'cairn detect'");
  const auto order = tracking::order_frames(survey.frames, options.order);
  std::map<survey::FrameId, std::vector<std::size_t>> by_frame;
  for (std::size_t i = 0; i < survey.detections.size(); ++i) by_frame[survey.detections[i].frame].push_back(i);

  const bool detected = options.boxes != "filtered";
  const tracking::SortOptions resolved = tracking::resolved(options.sort);
  FrameBoxes frame(resolved);
  Classes classes;
  Counts counts;
  std::vector<Reject> rejects;
  std::vector<survey::TrackedBox> rows;
  std::optional<tracking::SortTracker> tracker;
  std::int64_t ids_before = 0;  // identities given in stretches that are over
  for (const auto& next : order.steps) {
    ctx.check_stop();
    if (next.starts) {
      if (tracker) {
        counts.add(*tracker);
        ids_before += resolved.ids == "all" ? tracker->tracks_started() : tracker->tracks_emitted();
      }
      tracker.emplace(options.sort);
    }
    const auto& image = survey.frames[next.frame];
    frame.clear();
    if (const auto found = by_frame.find(image.id); found != by_frame.end())
      for (const std::size_t i : found->second) {
        const auto& d = survey.detections[i];
        frame.add({d.box, classes.number(d.object_class), d.score}, i);
      }
    frame.screen(rejects, [&](std::size_t i) { return "detection " + std::to_string(survey.detections[i].id.value); });
    counts.used += static_cast<std::int64_t>(frame.boxes.size());
    ++counts.frames;
    const std::size_t first = rows.size();
    for (const auto& o : tracker->step(frame.boxes, next.dt)) {
      survey::TrackedBox row;
      row.track = survey::TrackId(ids_before + o.id);
      row.state = o.coasted() ? survey::TrackState::coasted : survey::TrackState::detected;
      if (!o.coasted()) row.box.id = survey.detections[frame.source[o.observation]].id;
      row.box.frame = image.id;
      row.box.object_class = classes.name(o.object_class);
      row.box.score = options.scores ? o.score : 1.0;
      row.box.box = box_to_write(o, frame.boxes, detected);
      counts.coasted += o.coasted() ? 1 : 0;
      rows.push_back(std::move(row));
    }
    std::sort(rows.begin() + static_cast<std::ptrdiff_t>(first), rows.end(),
              [](const auto& a, const auto& b) { return a.track < b.track; });
  }
  if (tracker) counts.add(*tracker);
  counts.boxes = static_cast<std::int64_t>(survey.detections.size());
  counts.rows = static_cast<std::int64_t>(rows.size());
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.box.frame < b.box.frame; });
  io::write_tracks(out, rows);
  tell(rejects, order.notices, ctx);
  return {summary_of(counts, rejects, order.notices), std::move(rejects)};
}

std::vector<TrackFile> results_in_folder(const std::vector<fs::path>& inputs, const fs::path& folder) {
  std::vector<TrackFile> files;
  std::map<std::string, fs::path> taken;
  for (const auto& in : inputs) {
    fs::path path = fs::absolute(in).lexically_normal();
    if (path.filename().empty()) path = path.parent_path();
    std::string name = path.stem().string();
    if (name == "det" || name == "gt") {
      path = path.parent_path();
      if (path.filename() == "det" || path.filename() == "gt") path = path.parent_path();
      if (!path.filename().empty()) name = path.filename().string();
    }
    const auto [other, fresh] = taken.emplace(name, in);
    if (!fresh)
      throw Error(ErrorCode::invalid_argument, "two inputs would make one result")
          .found(other->second.string() + " and " + in.string() + " -> " + name + ".txt")
          .hint("Track them into two folders, or rename one");
    files.push_back({in, folder / (name + ".txt")});
  }
  return files;
}

}  // namespace cairn::pipeline
