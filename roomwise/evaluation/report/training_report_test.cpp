#include "roomwise/evaluation/report/training_report.h"

#include <gmock/gmock.h>

#include <limits>

namespace roomwise::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(TrainingReport, ShowsCurvesAndNumbers) {
  TrainingReportContent content;
  content.network = "rooms <new>";
  content.figures = {{"Pictures", "12"}};
  content.points = {{10, 1.5, 1.25, 0.5}, {20, 0.5, 1, 0.75}};
  content.best_step = 20;
  const std::string page = render_training_report(content);
  EXPECT_THAT(page, HasSubstr("Training of rooms &lt;new&gt;"));
  EXPECT_THAT(page, HasSubstr("<td class=\"number\">0.7500</td>"));
  EXPECT_THAT(page, HasSubstr("20 *"));
  // Half-way along the steps, and at half of the precision.
  EXPECT_THAT(plot_precision(content).element(), HasSubstr("382,242"));
}

TEST(TrainingReport, LeavesOutWhatWasNotHeldOut) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  TrainingReportContent content;
  content.network = "rooms";
  EXPECT_THAT(render_training_report(content), Not(HasSubstr("<svg")));
  content.points = {{10, 1.5, kNone, kNone}};
  const std::string page = render_training_report(content);
  EXPECT_THAT(page, Not(HasSubstr("precision against")));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace roomwise::evaluation
