#include "roomwise/evaluation/report/recognition_report.h"

#include <gmock/gmock.h>

namespace roomwise::evaluation {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

RecognitionReportContent content() {
  RecognitionReportContent content;
  content.title = "my <home>";
  content.notes = {"Intervals resample visits."};
  RecognitionReportContent::DecisionRule rule;
  rule.name = "two pictures";
  rule.decisions = 10;
  rule.named_correct = {7, 8};
  rule.precision_interval = {0.5, 1};
  rule.top1_correct = {8, 10};
  rule.top1_interval = {0.6, 0.95};
  rule.median_ms = 12.34;
  rule.confusion.add("kitchen", "kitchen", 7);
  rule.confusion.add("kitchen", "hall", 1);
  rule.confusion.add("hall", "not sure", 2);
  rule.curve = {{0.9, 0.5, 1}, {0.5, 1, 0.8}};
  content.rules = {rule};
  content.mistakes = {{image::ColorImage(8, 6), "walk: frame 12", "two pictures", "kitchen", "hall",
                       "looks like it"}};
  return content;
}

TEST(RecognitionReport, SaysHowOftenAndHowSurely) {
  const std::string page = render_recognition_report(content());
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">80.0 %</td>")) << "8 of 10 were named";
  EXPECT_THAT(page, HasSubstr("87.5 % (50.0 % to 100.0 %)"));
  EXPECT_THAT(page, HasSubstr("80.0 % (60.0 % to 95.0 %)"));
  EXPECT_THAT(page, HasSubstr("12.3 ms"));
  EXPECT_THAT(page, HasSubstr("said not sure"));
  EXPECT_THAT(page, HasSubstr("Rooms of my &lt;home&gt;"));
  EXPECT_THAT(page, Not(HasSubstr("my <home>")));
}

TEST(RecognitionReport, ShowsWhatWasWrongAndWhy) {
  const std::string page = render_recognition_report(content());
  EXPECT_THAT(page, HasSubstr("alt=\"A picture of kitchen that was taken for hall\""));
  EXPECT_THAT(page, HasSubstr("It is kitchen; two pictures said hall: looks like it"));
  RecognitionReportContent right = content();
  right.mistakes.clear();
  EXPECT_THAT(render_recognition_report(right), HasSubstr("No room was named wrongly."));
}

TEST(RecognitionReport, CanBeReadByEverybody) {
  const std::string page = render_recognition_report(content());
  EXPECT_THAT(page, HasSubstr("<html lang=\"en\">"));
  EXPECT_THAT(page, HasSubstr("<caption>two pictures: a row for each true room</caption>"));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">kitchen</th>"));
  EXPECT_THAT(page, HasSubstr("prefers-color-scheme: dark"));
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_THAT(page, Not(ContainsRegex("fill=\"none\"[^>]*fill=")))
      << "an attribute twice is no XML";
}

}  // namespace
}  // namespace roomwise::evaluation
