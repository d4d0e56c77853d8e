// The architecture guide says where each Program, equation and section of the paper is.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

namespace fs = std::filesystem;

namespace {

const fs::path root = fs::path(CCVT_TEST_DATA) / ".." / "..";

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  REQUIRE_MESSAGE(stream, file.string());
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

TEST_SUITE_BEGIN("paper");

TEST_CASE("each Program and equation is where the guide says, and tagged there or in its header") {
  const std::string guide = text_of(root / "include/ccvt/README.md");
  const std::regex row(R"(\| ([^|\n]+) \| `([^`]+)` \| `([A-Za-z_0-9]+)` \|)");
  std::set<std::string> found;
  for (std::sregex_iterator match(guide.begin(), guide.end(), row), end; match != end; ++match) {
    const std::string what = (*match)[1];
    const fs::path file = root / (*match)[2].str();
    const std::string name = (*match)[3];
    CAPTURE(what);
    std::string code = text_of(file);
    CHECK_MESSAGE(std::regex_search(code, std::regex("\\b" + name + "\\(|(class|struct) " + name)),
                  name);
    // The tag may stand at the declaration, or with the option that chooses it.
    if (fs::path header = file; fs::exists(header.replace_extension(".h"))) code += text_of(header);
    code += text_of(root / "src/relax/swap.h") + text_of(root / "include/ccvt/presets.h");
    const std::regex term(R"(Program \d|eq\. \d)");
    for (std::sregex_iterator t(what.begin(), what.end(), term); t != end; ++t) {
      CHECK_MESSAGE(code.find(t->str()) != std::string::npos, t->str());
      found.insert(t->str());
    }
  }
  const std::set<std::string> expected{"Program 1", "Program 2", "Program 3", "Program 4",
                                       "Program 5", "Program 6", "eq. 2",     "eq. 3",
                                       "eq. 6",     "eq. 7",     "eq. 8"};
  CHECK(found == expected);
}

TEST_SUITE_END();
