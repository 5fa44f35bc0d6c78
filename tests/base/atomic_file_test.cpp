#include "base/atomic_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::base {
namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  return names;
}

ErrorCode code_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.code();
  }
  ADD_FAILURE() << "nothing was thrown";
  return ErrorCode::internal;
}

TEST(StagedFile, AppearsOnlyOnCommit) {
  const cairn::testing::TempFolder folder;
  StagedFile staged(folder / "a.txt");
  write_file(staged.path(), "content");
  EXPECT_FALSE(fs::exists(folder / "a.txt"));
  staged.commit();
  EXPECT_EQ(read_file(folder / "a.txt"), "content");
  EXPECT_THAT(names_in(folder.path()), UnorderedElementsAre("a.txt"));
}

TEST(StagedFile, LeavesNothingWithoutCommit) {
  const cairn::testing::TempFolder folder;
  {
    const StagedFile staged(folder / "a.txt");
    write_file(staged.path(), "half");
  }
  EXPECT_THAT(names_in(folder.path()), IsEmpty());
}

TEST(StagedFile, RefusesAnExistingFileUnlessTold) {
  const cairn::testing::TempFolder folder;
  write_file(folder / "a.txt", "old");
  EXPECT_EQ(code_of([&] { StagedFile(folder / "a.txt", false); }), ErrorCode::already_exists);
  write_file_atomic(folder / "a.txt", "new", true);
  EXPECT_EQ(read_file(folder / "a.txt"), "new");
}

TEST(StagedFolder, ReplacesWholeFolders) {
  const cairn::testing::TempFolder folder;
  fs::create_directory(folder / "out");
  write_file(folder / "out" / fs::path("stale"), "x");
  EXPECT_EQ(code_of([&] { StagedFolder(folder / "out", false); }), ErrorCode::already_exists);
  StagedFolder staged(folder / "out", true);
  write_file(staged.path() / "fresh", "y");
  staged.commit();
  EXPECT_THAT(names_in(folder / "out"), UnorderedElementsAre("fresh"));
  EXPECT_THAT(names_in(folder.path()), UnorderedElementsAre("out"));
}

TEST(WriteFile, SaysWhenTheDiskIsFull) {
  // /dev/full takes the open and fails every write.
  EXPECT_EQ(code_of([] { write_file("/dev/full", "x"); }), ErrorCode::resource_exhausted);
}

TEST(ReadFile, RefusesMissingAndTooLarge) {
  const cairn::testing::TempFolder folder;
  EXPECT_EQ(code_of([&] { (void)read_file(folder / "none"); }), ErrorCode::not_found);
  write_file(folder / "a", "12345");
  EXPECT_EQ(code_of([&] { (void)read_file(folder / "a", 4); }), ErrorCode::invalid_input);
}

}  // namespace
}  // namespace cairn::base
