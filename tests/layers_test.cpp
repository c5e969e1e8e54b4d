// The house stands on its lower floors: which folder may include which.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise {
namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;

// One #include of a file of ours: both paths from the root of the checkout.
struct Arrow {
  std::string from, to;
};

std::vector<Arrow> arrows_of(const fs::path& root) {
  std::vector<Arrow> arrows;
  const std::regex include(R"(#include \"((?:roomwise|laboratory|python)/[^\"]+)\")");
  for (const char* top : {"roomwise", "laboratory", "apps", "python"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      const std::string text = read_text_file(entry.path()).value();
      for (std::sregex_iterator match(text.begin(), text.end(), include), end; match != end;
           ++match)
        arrows.push_back({entry.path().lexically_relative(root), (*match)[1]});
    }
  }
  return arrows;
}

// The modules of a folder in the order of its CMakeLists.txt, the lowest first.
std::map<std::string, std::size_t> floors_of(const fs::path& folder) {
  const std::string text = read_text_file(folder / "CMakeLists.txt").value();
  const std::regex module(R"(add_subdirectory\((\w+)\))");
  std::map<std::string, std::size_t> floors;
  for (std::sregex_iterator match(text.begin(), text.end(), module), end; match != end; ++match)
    floors.emplace((*match)[1], floors.size());
  return floors;
}

// "roomwise/mapping/graph/pose_graph.h": top roomwise, module mapping, part graph (empty where the
// file lies in the module's own folder).
struct Place {
  explicit Place(const std::string& file) {
    std::vector<std::string> names;
    for (const fs::path& name : fs::path(file)) names.push_back(name);
    top = names.at(0);
    module = names.at(1);
    for (std::size_t i = 2; i + 1 < names.size(); ++i) part += (i > 2 ? "/" : "") + names[i];
  }
  std::string top, module, part;
};

bool is_test(const std::string& file) {
  return file.ends_with("_test.cpp") || file.find("/testing/") != std::string::npos;
}

using Parts = std::map<std::string, std::set<std::string>>;  // part -> parts that it includes

bool reaches(const Parts& parts, const std::string& from, const std::string& to,
             std::set<std::string>& seen) {
  const auto found = parts.find(from);
  if (found == parts.end() || !seen.insert(from).second) return false;
  return std::ranges::any_of(found->second, [&](const std::string& next) {
    return next == to || reaches(parts, next, to, seen);
  });
}

class LayersTest : public ::testing::Test {
 protected:
  const fs::path root_ = ROOMWISE_SOURCES;
  const std::vector<Arrow> arrows_ = arrows_of(root_);
};

TEST_F(LayersTest, NoModuleIncludesOneAboveIt) {
  std::vector<std::string> climbing;
  for (const std::string top : {"roomwise", "laboratory"}) {
    const auto floors = floors_of(root_ / top);
    ASSERT_GT(floors.size(), 2U) << top;
    for (const Arrow& arrow : arrows_) {
      const Place from(arrow.from), to(arrow.to);
      if (from.top != top || to.top != top) continue;
      if (floors.at(to.module) > floors.at(from.module))
        climbing.push_back(arrow.from + " -> " + arrow.to);
    }
  }
  EXPECT_THAT(climbing, IsEmpty());
}

TEST_F(LayersTest, TheProductKnowsNothingOfTheLaboratory) {
  std::vector<std::string> climbing;
  for (const Arrow& arrow : arrows_) {
    const bool is_laboratory =
        arrow.from.starts_with("laboratory/") || arrow.from.starts_with("apps/roomwise-lab/");
    if (!is_laboratory && arrow.to.starts_with("laboratory/"))
      climbing.push_back(arrow.from + " -> " + arrow.to);
  }
  EXPECT_THAT(climbing, IsEmpty());
}

TEST_F(LayersTest, NothingIncludesThePythonPackage) {
  std::vector<std::string> climbing;
  for (const Arrow& arrow : arrows_) {
    if (arrow.to.starts_with("python/") && !arrow.from.starts_with("python/"))
      climbing.push_back(arrow.from + " -> " + arrow.to);
  }
  EXPECT_THAT(climbing, IsEmpty());
}

TEST_F(LayersTest, NoCircleOfFoldersWithinAModule) {
  std::map<std::string, Parts> modules;
  for (const Arrow& arrow : arrows_) {
    const Place from(arrow.from), to(arrow.to);
    if (is_test(arrow.from) || from.top != to.top || from.module != to.module) continue;
    if (from.part != to.part) modules[from.top + "/" + from.module][from.part].insert(to.part);
  }
  std::vector<std::string> circles;
  for (const auto& [module, parts] : modules) {
    for (const auto& [part, unused] : parts) {
      std::set<std::string> seen;
      if (reaches(parts, part, part, seen)) circles.push_back(module + "/" + part);
    }
  }
  EXPECT_THAT(circles, IsEmpty());
}

TEST_F(LayersTest, OnlyTestsIncludeScaffoldsOfTests) {
  std::vector<std::string> wrong;
  for (const Arrow& arrow : arrows_) {
    if (!is_test(arrow.from) && is_test(arrow.to)) wrong.push_back(arrow.from + " -> " + arrow.to);
  }
  EXPECT_THAT(wrong, IsEmpty());
}

}  // namespace
}  // namespace roomwise
