#include "roomwise/live/routes/trial_routes.h"

#include "roomwise/base/calendar_time.h"
#include "roomwise/live/device/trial_question.h"
#include "roomwise/live/routes/home_json.h"
#include "roomwise/service/protocol/json_members.h"

namespace roomwise::live {
namespace {

constexpr double kFarthestPlace_m = 10'000;  // what is farther is a fault

Expected<TrialQuestion> read_trial(const service::OrderedJson& json) {
  service::Members members(json);
  TrialQuestion trial;
  trial.text = members.text("text", service::kMaxWordsBytes);
  if (members.has("language")) trial.settings.language = members.text("language", 35);
  if (members.has("distances")) {
    const std::string distances = members.text("distances");
    if (distances != "metres" && distances != "steps") {
      return fail("'distances' must be \"metres\" or \"steps\"");
    }
    trial.settings.distances =
        distances == "steps" ? service::Distances::kSteps : service::Distances::kMetres;
  }
  if (members.has("place")) {
    const auto at = members.numbers("place", 2, -kFarthestPlace_m, kFarthestPlace_m);
    if (!members.error()) trial.place = {at[0], at[1]};
  }
  if (members.has("heading_degrees")) {
    trial.heading_degrees = members.number("heading_degrees", -360, 360);
  }
  trial.today = calendar_time(unix_now_ns());
  trial.now_s = unix_now_ns() / 1'000'000'000;
  return members.finish(std::move(trial));
}

Json point_json(const Eigen::Vector2d& point) {
  return {point.x(), point.y()};
}

service::HttpAnswer ask_on_trial(LiveHome& home, const service::HttpRequest& request) {
  const auto parsed = service::json_of(request);
  if (!parsed) return service::error_answer(400, parsed.error().message);
  const auto trial = read_trial(*parsed);
  if (!trial) return service::error_answer(400, trial.error().message);
  const TrialAnswer answered = try_question(*trial, home.view_for(*request.who));
  Json said = Json::array(), along = Json::array(), way = Json::array();
  for (const guide::Prompt& prompt : answered.prompts) said.push_back(prompt.text);
  for (const guide::Prompt& prompt : answered.along_way) along.push_back(prompt.text);
  for (const Eigen::Vector2d& corner : answered.way) way.push_back(point_json(corner));
  return service::json_answer(
      {{"said", std::move(said)},
       {"along", std::move(along)},
       {"way", std::move(way)},
       {"goal", answered.goal ? point_json(*answered.goal) : Json(nullptr)}});
}

}  // namespace

std::vector<HomeRoute> trial_routes() {
  return {{"POST", "/api/ask", service::Role::kHelper,
           [](LiveHome& home, const service::HttpRequest& request, const auto&) {
             return ask_on_trial(home, request);
           }}};
}

}  // namespace roomwise::live
