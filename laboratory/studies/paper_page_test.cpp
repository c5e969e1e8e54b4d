#include "laboratory/studies/paper_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roomwise::studies {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

MappingTrial trial(double ate_m) {
  MappingTrial one;
  one.frames = 10;
  one.placed = 9;
  one.ate_m = ate_m;
  one.rpe_m = 0.25;
  one.features_ms = 4;
  one.all_ms = 20.5;
  return one;
}

PaperResults results_of(PaperPart part) {
  PaperResults results;
  results.parts = {part};
  return results;
}

TEST(PaperPage, SaysErrorsOfPathsBesideWhatOthersPublished) {
  PaperResults results = results_of(PaperPart::kMapping);
  results.seeds = 3;
  results.mapping = {
      {{"fr1/desk", false}, "paper", "sift", {trial(0.03), trial(0.01), trial(0.02)}}};
  const std::string page = paper_page(results);
  EXPECT_THAT(
      page,
      HasSubstr("<th scope=\"row\">fr1/desk</th><td>measured here, real</td><td>the paper&#39;s"));
  EXPECT_THAT(page, AllOf(HasSubstr("<td>SIFT</td>"), HasSubstr("9 of 10"),
                          HasSubstr("0.0200 (0.0100 to 0.0300)"), HasSubstr("0.2500")));
  EXPECT_THAT(page, HasSubstr("published: the paper [1]"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">0.064</td>"));
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">fr1/xyz</th><td>not measured here</td>"));
}

TEST(PaperPage, TellsWhatIsSimulatedFromWhatIsReal) {
  PaperResults results = results_of(PaperPart::kObjects);
  results.objects = {{{"fr1/rpy", false}, "the paper's rules", 1, 2, 3, 4, 5, 0.125},
                     {{"reference flat", true}, "the paper's rules", 0, 7, 0, 0, 1, {}}};
  results.ruled_objects = {{{"fr1/rpy", false}, "a <desk>", 0.75, 4, true}};
  const std::string page = paper_page(results);
  EXPECT_THAT(page,
              HasSubstr("<th scope=\"row\">reference flat</th><td>measured here, simulated</td>"));
  EXPECT_THAT(page, AllOf(HasSubstr("1 of 3"), HasSubstr("0 of 7"), HasSubstr("0.12"),
                          HasSubstr("a &lt;desk&gt;")));
}

TEST(PaperPage, SaysHowOftenRoomsAreRightAndHowSureThatIs) {
  PaperResults results = results_of(PaperPart::kRooms);
  results.rooms = {{"light",
                    {"reference flat", true},
                    "the paper's way, two pictures",
                    20,
                    {15, 20},
                    {0.5, 0.875},
                    12},
                   {"light", {"reference flat", true}, "two pictures", 20, {0, 0}, {0, 0}, 12}};
  const std::string page = paper_page(results);
  EXPECT_THAT(page, HasSubstr("0.7500 (0.500 to 0.875)"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">0</td><td class=\"number\">–</td>"))
      << "of none named none is right or wrong";
  EXPECT_THAT(page, AllOf(HasSubstr("0.9660"), HasSubstr("0.9864"), HasSubstr("18.3")));
}

TEST(PaperPage, ShowsTheTrainingCurve) {
  PaperResults results = results_of(PaperPart::kTraining);
  EXPECT_THAT(paper_page(results), Not(HasSubstr("<svg")));
  results.training.emplace();
  results.training->points = {{10, 1.5, 1.25, 0.5}, {20, 0.5, 1, 0.75}};
  EXPECT_THAT(paper_page(results), AllOf(HasSubstr("<svg"), HasSubstr("0.7500")));
}

TEST(PaperPage, NamesWhatIsMissingWithALinkToWhereItIs) {
  PaperResults results = results_of(PaperPart::kMapping);
  results.missing[PaperPart::kMapping] = {"a < b; somebody keeps it at https://a.org/x."};
  results.missing[PaperPart::kRooms] = {"of a part that nobody asked for"};
  const std::string page = paper_page(results);
  EXPECT_THAT(page, HasSubstr("<li>a &lt; b; somebody keeps it at <a "
                              "href=\"https://a.org/x\">https://a.org/x</a>.</li>"));
  EXPECT_THAT(page, Not(HasSubstr("nobody asked for")));
}

TEST(PaperPage, IsForEverybodyAndNeedsNothingElse) {
  PaperResults results;
  for (const auto& [part, name] : kPaperParts) results.parts.push_back(part);
  const std::string page = paper_page(results);
  EXPECT_THAT(page, AllOf(HasSubstr("<html lang=\"en\">"), HasSubstr("<caption>"),
                          HasSubstr("<th scope=\"col\"")));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<script")), Not(HasSubstr("src=\"http")),
                          Not(HasSubstr("<link"))));
}

}  // namespace
}  // namespace roomwise::studies
