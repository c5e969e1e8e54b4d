#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/guide/message_catalogue.h"
#include "roomwise/guide/prompt.h"
#include "roomwise/live/eye.h"
#include "roomwise/service/messages.h"

namespace roomwise::live {

// What an answer may rest on.
struct Situation {
  const HomeView& home;
  const Glance* glance;  // null: there is no picture that is new enough
  const service::SpeakingSettings& settings;
  double now_t_ms;  // by the device's clock
};

// A glance that is older than this at the time of a question says nothing of it any more, ms: a
// person walks two steps meanwhile.
constexpr double kFresh_ms = 2000;

// What is said to a question, the most important first; never nothing. The room of kNameRoom has
// been named already; kRepeat is asked here only where nothing was asked before.
[[nodiscard]] std::vector<guide::Prompt> answer(const service::Ask& ask,
                                                const Situation& situation);

// The answer where a picture is needed and there is none.
[[nodiscard]] guide::Prompt no_picture(const service::SpeakingSettings& settings, double now_t_ms);

// Decides what is called out while a person walks and asks nothing: a room that was entered, what
// stands ahead.
class Caller {
 public:
  // After each glance, whether or not it is spoken.
  [[nodiscard]] std::vector<guide::Prompt> after(const Situation& situation);

 private:
  std::string room_now_;     // by the last glance; empty: not sure
  std::string room_called_;  // the last that was called out
  bool obstacle_ahead_ = false;
};

}  // namespace roomwise::live
