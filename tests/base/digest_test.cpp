#include "base/digest.hpp"

#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "support/data.hpp"

namespace cairn::base {
namespace {

// FIPS 180-4 examples.
TEST(Digest, MatchesThePublishedValues) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Digest, FileEqualsText) {
  const cairn::testing::TempFolder folder;
  const std::string content(3'000'000, 'x');
  write_file(folder / "f", content);
  EXPECT_EQ(sha256_of_file(folder / "f"), sha256_of(content));
}

TEST(Digest, FieldsDoNotRunTogether) {
  EXPECT_NE(std::move(Digest().add_field("ab").add_field("c")).hex(),
            std::move(Digest().add_field("a").add_field("bc")).hex());
}

}  // namespace
}  // namespace cairn::base
