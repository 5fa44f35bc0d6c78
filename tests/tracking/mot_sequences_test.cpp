// Published sequences with the reference implementation's results. The folder of the sequences (each with det.txt and
// sort_reference.txt) is named by the environment variable CAIRN_MOT_DATA: their terms forbid a copy here.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <vector>

#include "io/detections.hpp"
#include "pipeline/track_stage.hpp"
#include "support/data.hpp"

namespace {

namespace fs = std::filesystem;
using namespace cairn;

constexpr double kBoxTolerancePx = 0.0101;  // one step of the two decimals written

std::vector<fs::path> sequences() {
  std::vector<fs::path> found;
  if (const char* folder = std::getenv("CAIRN_MOT_DATA"); folder != nullptr && fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (fs::exists(entry.path() / "sort_reference.txt")) found.push_back(entry.path());
  return found;
}

std::map<std::int64_t, std::vector<io::ImageBox>> by_frame(const io::BoxFile& file) {
  std::map<std::int64_t, std::vector<io::ImageBox>> result;
  for (const auto& box : file.boxes) result[file.images[box.image].number].push_back(box);
  return result;
}

TEST(MotSequences, EqualTheReference) {
  const auto folders = sequences();
  if (folders.empty()) GTEST_SKIP() << "CAIRN_MOT_DATA does not name a folder of sequences with sort_reference.txt";
  for (const auto& folder : folders) {
    SCOPED_TRACE(folder.filename());
    const cairn::testing::TempFolder temp;
    base::RunContext ctx;
    static_cast<void>(
        pipeline::track_files({{folder / "det.txt", temp / "out.txt"}}, {.format = "mot", .reading = {}}, {}, ctx));
    const io::ReadBoxesOptions raw{.class_names = {}, .images = {}, .as_in_file = true};
    const auto ours = by_frame(io::read_boxes(temp / "out.txt", io::BoxFormat::mot, raw));
    const auto theirs = by_frame(io::read_boxes(folder / "sort_reference.txt", io::BoxFormat::mot, raw));
    ASSERT_EQ(ours.size(), theirs.size());
    std::map<std::int64_t, std::int64_t> name, back;
    for (const auto& [frame, boxes] : theirs) {
      ASSERT_TRUE(ours.contains(frame)) << frame;
      const auto& mine = ours.at(frame);
      ASSERT_EQ(mine.size(), boxes.size()) << frame;
      for (const auto& b : boxes) {
        bool matched = false;
        for (const auto& m : mine) {
          const double worst =
              std::max({std::abs(m.box.xmin - b.box.xmin), std::abs(m.box.ymin - b.box.ymin),
                        std::abs(m.box.width() - b.box.width()), std::abs(m.box.height() - b.box.height())});
          if (worst > kBoxTolerancePx) continue;
          matched = name.emplace(b.track, m.track).first->second == m.track &&
                    back.emplace(m.track, b.track).first->second == b.track;
        }
        EXPECT_TRUE(matched) << "frame " << frame << " track " << b.track;
      }
    }
    // Identities without gaps.
    EXPECT_EQ(back.rbegin()->first, static_cast<std::int64_t>(back.size()));
  }
}

}  // namespace
