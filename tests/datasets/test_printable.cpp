// What is UTF-8, and what a message shows of what is not.
#include <gtest/gtest.h>

#include "datasets/text/printable.h"

namespace slammot {
namespace {

TEST(Printable, OneLineWhateverStandsInIt) {
  EXPECT_EQ(printable("caf\xc3\xa9: 'x'"), "caf\xc3\xa9: 'x'");
  EXPECT_EQ(printable("a\nb\x1b[2J\x7f"), "a\\x0ab\\x1b[2J\\x7f");
  EXPECT_EQ(printable("caf\xe9"), "caf\\xe9");
  EXPECT_LT(printable(std::string(1 << 20, 'x')).size(), 3000u);
}

TEST(Utf8, IsWhatRfc3629Says) {
  constexpr auto kNone = std::string_view::npos;
  for (const std::string_view good : {"", "abc", "\xc3\xa9", "\xe2\x82\xac", "\xed\x9f\xbf",
                                      "\xf0\x9f\x98\x80", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_EQ(invalid_utf8(good), kNone) << good;
  }
  for (const std::string_view bad :
       {"a\x80", "a\xc3", "a\xc0\xaf", "a\xe0\x80\xaf", "a\xed\xa0\x80", "a\xf4\x90\x80\x80",
        "a\xff", "a\xf0\x9f\x98"}) {
    EXPECT_EQ(invalid_utf8(bad), 1u) << printable(bad);
  }
}

TEST(FolderName, HasNoSlash) {
  EXPECT_EQ(folder_name_fault("circle, 1"), "");
  for (const char* bad : {"", ".", "..", "a/b", "/", "a\nb"}) EXPECT_NE(folder_name_fault(bad), "");
  EXPECT_NE(folder_name_fault(std::string(300, 'x')), "");
}

}  // namespace
}  // namespace slammot
