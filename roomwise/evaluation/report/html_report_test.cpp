#include "roomwise/evaluation/report/html_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/evaluation/testing/test_markup.h"

namespace roomwise::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Everything that a report can hold. `text` stands wherever a user's or a network's words do.
ReportContent full_content(const std::string& text) {
  ReportContent content;
  content.home = text;
  content.warnings = {text};
  content.summary = {{text, text}};
  TopView view;
  view.picture = image::ColorImage(300, 200, {128, 128, 128});
  view.pixels_per_metre = 50;
  view.pixel_from_world_linear << 50, 0, 0, 0, -50, 0;
  view.pixel_from_world_offset = {0, 200};
  content.map = view;
  content.key_frames = {{{1, 1, 0}, text}, {{2, 1, 0}, text}, {{3, 1, 0}, ""}};
  content.rooms = {{text, text, 2, text}, {"hall", "", 1, ""}};
  ReportContent::Object object;
  object.object = {text, {1, 2, 3}};
  object.score = 0.875;
  object.observations = 4;
  object.room = text;
  object.picture = image::ColorImage(640, 480, {10, 20, 30});
  content.objects = {object};
  ReportContent::Recognition recognition;
  recognition.rule = text;
  recognition.top1_correct = {990, 1000};
  recognition.top1_interval = {0.95, 1};
  recognition.named_correct = {795, 800};
  recognition.named_interval = {0.9, 1};
  recognition.resampled = "visits";
  recognition.ms = 8.25;
  recognition.confusion.add(text, text);
  recognition.confusion.add(text, "hall");
  content.recognition = {recognition};
  AbsoluteTrajectoryError error;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector3d place(std::cos(0.3 * i), std::sin(0.3 * i), 0);
    error.pairs.push_back({i, place, 1.1 * place});
  }
  error.error_m.rmse = 0.1234;
  content.trajectory_error = error;
  content.stages = {{text, 10, 2.5, 2}};
  return content;
}

// What is wrong with the nesting of a page's elements; empty: nothing. Every element of the pages
// is closed, as XML asks for.
std::string nesting_fault(std::string_view page) {
  std::vector<std::string> open;
  for (std::size_t i = page.find('<'); i != std::string_view::npos; i = page.find('<', i + 1)) {
    const std::size_t end = page.find('>', i);
    if (end == std::string_view::npos) return "a tag without an end";
    const std::string_view tag = page.substr(i + 1, end - i - 1);
    if (tag.starts_with('!') || tag.ends_with('/')) continue;
    if (tag.find('<') != std::string_view::npos) return "a tag within a tag: " + std::string(tag);
    const std::string name(tag.substr(tag.starts_with('/') ? 1 : 0, tag.find(' ')));
    if (!tag.starts_with('/')) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> closes " + (open.empty() ? "nothing" : open.back());
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : open.back() + " is not closed";
}

std::vector<std::string> values_of(const std::string& page, const std::string& attribute) {
  std::vector<std::string> values;
  const std::string begin = " " + attribute + "=\"";
  for (std::size_t i = page.find(begin); i != std::string::npos; i = page.find(begin, i + 1)) {
    const std::size_t start = i + begin.size();
    values.push_back(page.substr(start, page.find('"', start) - start));
  }
  return values;
}

TEST(HtmlReport, IsWellFormed) {
  EXPECT_EQ(nesting_fault(render_report(full_content("living room"))), "");
  EXPECT_EQ(nesting_fault(render_report(ReportContent())), "");
}

TEST(HtmlReport, ShowsTextAsText) {
  const std::string page = render_report(full_content("<script>alert('1' + \"2\")</script> & co"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(
      page, HasSubstr("&lt;script&gt;alert(&#39;1&#39; + &quot;2&quot;)&lt;/script&gt; &amp; co"));
  EXPECT_EQ(nesting_fault(page), "");
}

TEST(HtmlReport, AsksNothingOfTheNetwork) {
  const std::string page = render_report(full_content("kitchen"));
  const auto pictures = values_of(page, "src");
  EXPECT_EQ(pictures.size(), 1);
  for (const auto& attribute : {"src", "href"}) {
    for (const std::string& value : values_of(page, attribute)) {
      EXPECT_TRUE(value.starts_with("data:image/jpeg;base64,")) << value.substr(0, 80);
    }
  }
  EXPECT_THAT(page, Not(HasSubstr("<link")));
  EXPECT_THAT(page, Not(HasSubstr("@import")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
}

TEST(HtmlReport, IsMadeForEverybody) {
  const std::string page = render_report(full_content("kitchen"));
  EXPECT_THAT(page, HasSubstr("<html lang=\"en\">"));
  EXPECT_THAT(page, HasSubstr("<title>kitchen"));
  EXPECT_THAT(page, HasSubstr("name=\"viewport\""));
  EXPECT_THAT(page, HasSubstr("prefers-color-scheme: dark"));
  EXPECT_EQ(count_of(page, "<h1>"), 1);
  EXPECT_EQ(count_of(page, "<table>"), count_of(page, "<caption>"));
  EXPECT_EQ(count_of(page, "<th "), count_of(page, "<th scope="));
  EXPECT_EQ(count_of(page, "<img "), values_of(page, "alt").size());
  // No level of heading is left out.
  int level = 0;
  for (std::size_t i = page.find("<h"); i != std::string::npos; i = page.find("<h", i + 1)) {
    if (page[i + 2] < '1' || page[i + 2] > '6') continue;
    const int next = page[i + 2] - '0';
    EXPECT_LE(next, level + 1) << page.substr(i, 60);
    level = next;
  }
}

TEST(HtmlReport, HoldsTheFigures) {
  const std::string page = render_report(full_content("kitchen"));
  EXPECT_THAT(page, HasSubstr("99.0 %"));
  EXPECT_THAT(page, HasSubstr("95.0 % to 100.0 %"));
  EXPECT_THAT(page, HasSubstr("80.0 %")) << "800 of 1,000 were named";
  EXPECT_THAT(page, HasSubstr("99.4 %"));
  EXPECT_THAT(page, HasSubstr("90.0 % to 100.0 %"));
  EXPECT_THAT(page, HasSubstr("Intervals resample visits, not single pictures."));
  EXPECT_THAT(page, HasSubstr("8.2 ms"));  // per answer
  EXPECT_THAT(page, HasSubstr("50.0 %"));  // the confusion's recall
  EXPECT_THAT(page, HasSubstr("ATE 0.1234 m RMSE over 10 poses"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">200.00 ms</td>"));  // 2 s in 10 calls
  EXPECT_THAT(page, HasSubstr("<h3>1. kitchen</h3>"));
  EXPECT_THAT(page, HasSubstr("0.88"));
  EXPECT_THAT(page, HasSubstr("1.00, 2.00, 3.00"));
  EXPECT_THAT(page, HasSubstr("width=\"320\" height=\"240\""));
}

TEST(HtmlReport, LeavesOutWhatIsNotThereOrSaysSo) {
  ReportContent content;
  content.home = "Flat";
  const std::string page = render_report(content);
  EXPECT_THAT(page, HasSubstr("<h1>Flat</h1>"));
  EXPECT_THAT(page, HasSubstr("No rooms were named."));
  EXPECT_THAT(page, HasSubstr("No objects were found."));
  for (const char* heading : {"<h2>Map", "<h2>Summary", "<h2>Recognition", "<h2>Trajectory",
                              "<h2>Time", "Please note", "<svg", "<table"}) {
    EXPECT_THAT(page, Not(HasSubstr(heading)));
  }
}

TEST(HtmlReport, AnObjectWithoutAPictureHasNone) {
  ReportContent content = full_content("lamp");
  content.objects[0].picture = {};
  content.objects[0].room.clear();
  const std::string page = render_report(content);
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_THAT(page, HasSubstr("<dd>not known</dd>"));
}

TEST(HtmlReport, AThingIsInTheRoomThatItStandsInOrWasSeenFromOne) {
  ReportContent content = full_content("home");
  content.objects[0].room = "kitchen";
  content.objects[0].seen_from = "hall";
  EXPECT_THAT(render_report(content), HasSubstr("<dt>Room</dt><dd>kitchen</dd>"));
  content.objects[0].room.clear();
  EXPECT_THAT(render_report(content), HasSubstr("<dt>Seen from</dt><dd>hall</dd>"));
}

}  // namespace
}  // namespace roomwise::evaluation
