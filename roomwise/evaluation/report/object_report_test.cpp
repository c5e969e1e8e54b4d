#include "roomwise/evaluation/report/object_report.h"

#include <gmock/gmock.h>

#include "roomwise/evaluation/testing/test_markup.h"

namespace roomwise::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

ObjectReportContent bed_home() {
  ObjectReportContent content;
  content.title = "my <home>";
  content.notes = {"A thing counts as found within a metre."};
  ObjectReportContent::Way way{"joined from regions", {}, 2};
  way.errors.all = {.matched = 6, .beyond = 1, .missed = 2, .duplicates = 1, .wrong = 2};
  way.errors.by_kind["bed"] = {.matched = 6, .beyond = 1, .missed = 2, .duplicates = 1, .wrong = 2};
  way.errors.matches = {{0, 0, 0, 0.25}};
  content.ways = {way, {"the paper's rules", {}, 0}};
  content.shown_way = "joined from regions";
  content.reliability = reliability_curve(std::vector<Forecast>{{0.7, true}, {0.7, false}});
  content.wrong = {{image::ColorImage(8, 6), "Key-frame 3, with a frame about the bed", "bed",
                    "the nearest thing is a table"}};
  return content;
}

TEST(ObjectReport, SaysWhatWasFoundMissedAndFalse) {
  const std::string page = render_object_report(bed_home());
  EXPECT_THAT(page, HasSubstr("Things of my &lt;home&gt;"));
  EXPECT_THAT(page, Not(HasSubstr("my <home>")));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">joined from regions</th>"
                              "<td class=\"number\">75.0 %</td>"
                              "<td class=\"number\">10.0 %</td>"
                              "<td class=\"number\">20.0 %</td>"
                              "<td class=\"number\">0.25 m</td>"))
      << "6 of 8 to be found; 1 and 2 of 10 that were found";
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">–</td>")) << "no way without a match is near";
  EXPECT_THAT(page, HasSubstr("<caption>Things, the paper"));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">60.0 % to 80.0 %</th>"
                              "<td class=\"number\">2</td>"
                              "<td class=\"number\">70.0 %</td>"
                              "<td class=\"number\">50.0 %</td>"));
}

TEST(ObjectReport, ShowsThePicturesOfEachKind) {
  const std::string page = render_object_report(bed_home());
  EXPECT_THAT(page, HasSubstr("<h2>Not there, joined from regions: 1</h2>"));
  EXPECT_THAT(page, HasSubstr("alt=\"Key-frame 3, with a frame about the bed\""));
  EXPECT_EQ(count_of(page, "<p>None.</p>"), 3U) << "none twice, missed or found";
  EXPECT_EQ(count_of(page, "<img "), 1U);
  EXPECT_THAT(page, Not(HasSubstr("<script")));
}

}  // namespace
}  // namespace roomwise::evaluation
