#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/box_readers.hpp"
#include "io/bytes.hpp"

namespace cairn::io {
namespace boxes {
namespace {

constexpr std::size_t kMaxColumns = 16;
constexpr std::array<const char*, 7> kColumns{"frame", "id", "left", "top", "width", "height", "score"};
constexpr std::int64_t kMaxFrame = std::int64_t{1} << 53;

// Frame numbers of a file are few and mostly ascend: index of each, kept sorted.
class Frames {
 public:
  explicit Frames(BoxFile& file) : file_(file) {}
  std::size_t index(std::int64_t number) {
    if (last_ < file_.images.size() && file_.images[last_].number == number) return last_;
    const auto known =
        std::lower_bound(sorted_.begin(), sorted_.end(), std::pair<std::int64_t, std::size_t>{number, 0});
    if (known != sorted_.end() && known->first == number) return last_ = known->second;
    last_ = file_.images.size();
    sorted_.insert(known, {number, last_});
    file_.images.push_back({number, "", 0, 0});
    return last_;
  }

 private:
  BoxFile& file_;
  std::vector<std::pair<std::int64_t, std::size_t>> sorted_;
  std::size_t last_ = 0;
};

// Lines one after another, LF or CR LF; the number of the last one given is for messages.
class Lines {
 public:
  explicit Lines(const FileBytes& file) : text_(file.text()), file_(file.name()) {}

  bool next(std::string_view& line) {
    if (text_.empty()) return false;
    const auto end = std::min(text_.find('\n'), text_.size());
    line = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    ++number_;
    return true;
  }
  [[nodiscard]] std::uint64_t number() const { return number_; }
  [[nodiscard]] base::Error error(std::string message) const { return bad_line(file_, number_, std::move(message)); }

 private:
  std::string_view text_, file_;
  std::uint64_t number_ = 0;
};

// The numbers of a row; separated by commas or blanks. Count 0 for a blank line or a comment.
std::size_t numbers_of(std::string_view line, const Lines& reader, std::array<double, kMaxColumns>& values) {
  std::size_t count = 0;
  const bool commas = line.find(',') != std::string_view::npos;
  std::string_view rest = base::trim(line);
  if (rest.empty() || rest.front() == '#') return 0;
  while (true) {
    std::string_view word;
    if (commas) {
      const auto end = std::min(rest.find(','), rest.size());
      word = base::trim(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
      if (word.empty() && rest.empty()) break;  // a comma at the end of the row
    } else {
      word = take_word(rest);
      if (word.empty()) break;
    }
    const auto value = parse_number(word);
    if (count == kMaxColumns) throw reader.error("too many columns").allowed("at most " + std::to_string(kMaxColumns));
    if (!value)
      throw reader.error("not a number")
          .found("'" + std::string(word.substr(0, 60)) + "' in column " +
                 (count < kColumns.size() ? kColumns[count] : std::to_string(count + 1).c_str()))
          .allowed("frame,id,left,top,width,height,score,...");
    values[count++] = *value;
    if (commas && rest.empty()) break;
  }
  return count;
}

std::int64_t whole(double value, const char* column, const Lines& reader) {
  if (!(std::abs(value) <= static_cast<double>(kMaxFrame)) || value != std::floor(value))
    throw reader.error("not a whole number")
        .found(base::to_text(value) + " in column " + column)
        .allowed("a whole number; frames count from 1");
  return static_cast<std::int64_t>(value);
}

}  // namespace

BoxFile read_mot(const std::filesystem::path& path, const ReadBoxesOptions& options) {
  const FileBytes bytes(path);
  BoxFile file;
  file.format = BoxFormat::mot;
  file.convention = options.as_in_file
                        ? "Left, top, width and height as they stand in the MOTChallenge file."
                        : "MOTChallenge left, top, width, height; the first pixel is (1, 1): 1 was taken off.";
  Lines reader(bytes);
  constexpr std::size_t kBytesPerRow = 48;  // about
  file.boxes.reserve(bytes.text().size() / kBytesPerRow);
  Frames frames(file);
  std::array<double, kMaxColumns> v{};
  std::int64_t last_frame = std::numeric_limits<std::int64_t>::min();
  const double shift = options.as_in_file ? 0.0 : -1.0;
  std::string_view line;
  while (reader.next(line)) {
    const std::size_t count = numbers_of(line, reader, v);
    if (count == 0) continue;
    if (count < 6)
      throw reader.error("too few columns")
          .found(std::to_string(count))
          .allowed("frame,id,left,top,width,height,score");
    ImageBox box;
    const std::int64_t frame = whole(v[0], "frame", reader);
    file.unsorted = file.unsorted || frame < last_frame;
    last_frame = frame;
    box.image = frames.index(frame);
    box.track = whole(v[1], "id", reader);
    if (box.track < 0) box.track = -1;
    box.box.xmin = v[2] + shift;
    box.box.ymin = v[3] + shift;
    box.box.xmax = v[4] + box.box.xmin;
    box.box.ymax = v[5] + box.box.ymin;
    if (count > 6) box.score = v[6];
    // Ground truth: frame,id,box,flag,class,visibility. The flag tells whether the box counts.
    if (count == 9) {
      box.ignored = v[6] == 0.0;
      box.score = 1.0;
      box.object_class = std::to_string(whole(v[7], "class", reader));
    }
    box.line = reader.number();
    file.boxes.push_back(std::move(box));
  }
  order_images(file);
  return file;
}

}  // namespace boxes

namespace {

template <typename... Format>
void append(std::string& text, Format... value) {
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value...);
  text.append(buffer.data(), end.ptr);
}

}  // namespace

void write_mot(const std::filesystem::path& path, std::span<const MotRow> rows) {
  constexpr double kFixedBelow = 1e15;  // px; a longer number takes the short form
  OutputFile out(path);
  std::string line;
  for (const MotRow& row : rows) {
    line.clear();
    append(line, row.frame);
    line += ',';
    append(line, row.track);
    for (const double side : {row.box.xmin, row.box.ymin, row.box.width(), row.box.height()}) {
      if (!std::isfinite(side)) throw base::Error(base::ErrorCode::internal, "box of a track is not finite");
      line += ',';
      if (std::abs(side) < kFixedBelow) append(line, side, std::chars_format::fixed, 2);
      else append(line, side);
    }
    if (!std::isfinite(row.score)) throw base::Error(base::ErrorCode::internal, "score of a track is not finite");
    line += ',';
    append(line, row.score);
    line += ",-1,-1,-1\n";
    out.write(line);
  }
  out.close();
}

}  // namespace cairn::io
