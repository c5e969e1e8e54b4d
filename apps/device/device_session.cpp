#include "device_session.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <string_view>
#include <thread>
#include <utility>

#include "roomwise/service/protocol/prompt_message.h"

namespace roomwise::app {
namespace {

constexpr int kTick_ms = 20;
// After the last frame of a recording, so long without a word from the computer ends the session.
constexpr double kLastWord_s = 2;
// Who is to be led on after the computer was away waits so long for a picture that tells where they
// are: without one they would be told to turn.
constexpr double kPlaced_s = 4;

bool asks_to_be_led(service::Question question) {
  return question == service::Question::kTakeMeTo || question == service::Question::kTakeMeBack;
}

// Of a question in words: what it asked for was to be led. "How far" is answered by the guide, too.
bool begins_guidance(std::string_view message) {
  return message == "guide.begin" || message.starts_with("route.");
}

// After these nobody is led any more.
bool ends_guidance(std::string_view message) {
  return message.starts_with("guide.there") || message == "guide.near_end" ||
         message.starts_with("guide.ended") || message == "guide.not_running";
}

// What one can be led to, as it is asked for: what there is few of first.
std::vector<service::Ask> goals_of(const service::Welcome& home) {
  std::vector<service::Ask> goals;
  for (const std::string& room : home.rooms) {
    goals.emplace_back().subject = room;
    goals.back().is_room = true;
  }
  for (const std::string& spot : home.spots) goals.emplace_back().subject = spot;
  goals.emplace_back().is_way_out = true;
  for (const std::string& thing : home.things) {
    const auto several =
        std::ranges::find(home.things_in_rooms, thing, &service::ThingInRooms::thing);
    if (several == home.things_in_rooms.end()) {
      goals.emplace_back().subject = thing;
      continue;
    }
    for (const std::string& room : several->rooms) {
      goals.emplace_back().subject = thing;
      goals.back().in_room = room;
    }
  }
  return goals;
}

double steady_s(TimestampNs now_ns) {
  return static_cast<double>(now_ns) * kSecondsPerNs;
}

}  // namespace

Expected<void> DeviceSession::run(const Interruption& interruption) {
  while (!interrupted() && !interruption.interrupted()) {
    const TimestampNs now_ns = steady_now_ns();
    connect(now_ns);
    receive(now_ns);
    send_frames(now_ns);
    if (parts_.keys) {
      for (const KeyRequest& request : parts_.keys->wait(kTick_ms, now_ns)) act(request, now_ns);
      watch_buttons(now_ns);
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(kTick_ms));
    }
    ROOMWISE_RETURN_IF_ERROR(parts_.voice->step(steady_now_ns()));
    if (is_over(now_ns)) break;
  }
  if (connection_) connection_->close();
  if (parts_.camera && parts_.camera->failure()) return fail("{}", *parts_.camera->failure());
  return {};
}

// Connecting may take seconds, in which keys and speech go on.
void DeviceSession::connect(TimestampNs now_ns) {
  if (link_.begin_try(steady_s(now_ns))) {
    service::ClientWait wait = parts_.wait;
    wait.interruption = this;
    trying_ = std::async(std::launch::async, [this, wait] {
      return service::ServerConnection::open(parts_.server, parts_.credentials, wait);
    });
  }
  if (trying_.valid() && trying_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    take_connection(now_ns);
  }
}

void DeviceSession::take_connection(TimestampNs now_ns) {
  auto opened = trying_.get();
  if (!opened) {
    tell_of_failure(opened.error(), now_ns);
    (void)link_.failed(steady_s(now_ns));
    return;
  }
  last_failure_.clear();
  removal_said_ = false;
  connection_ = *std::move(opened);
  heard_ns_ = now_ns;
  send(parts_.hello, now_ns);
  if (quiet_) send(service::Quiet{true}, now_ns);
  if (!parts_.camera) lead_again(now_ns);  // no picture will come
}

// Who hears that it is ready presses a button at once: only now the home is known.
void DeviceSession::take_first_welcome(TimestampNs now_ns) {
  no_connection_said_ = true;
  const bool is_back = link_.connected() == service::DeviceLink::News::kBack;
  parts_.voice->notice(is_back ? "device.connection_back" : "device.ready", guide::Sound::kBack,
                       now_ns);
}

// Said once, and not with every try; after a connection that was lost nothing more is to be said.
void DeviceSession::tell_of_failure(const Error& error, TimestampNs now_ns) {
  if (error.message != last_failure_) {
    last_failure_ = error.message;
    std::cerr << last_failure_ << '\n';
  }
  if (error.code == ErrorCode::kRefused) {
    if (std::exchange(removal_said_, true)) return;
    parts_.voice->notice("device.removed", guide::Sound::kAlert, now_ns);
  } else {
    say_no_connection(now_ns);
  }
}

void DeviceSession::say_no_connection(TimestampNs now_ns) {
  if (std::exchange(no_connection_said_, true)) return;
  parts_.voice->notice("device.no_connection", guide::Sound::kAlert, now_ns);
}

void DeviceSession::lose(const std::string& why, TimestampNs now_ns) {
  if (!connection_) return;
  std::cerr << why << '\n';
  connection_.reset();
  can_localize_ = false;
  if (led_.by && asked_.contains(led_.by->id)) led_.is_unanswered = true;
  asked_.clear();        // no answers will come
  is_teaching_ = false;  // the computer forgets what was shown
  if (link_.failed(steady_s(now_ns)) != service::DeviceLink::News::kLost) {
    // It was not welcomed, and who was to be led on then is still to be.
    if (led_.by) led_.again_from_ns = now_ns;
    if (led_before_.by) led_before_.again_from_ns = now_ns;
    return say_no_connection(now_ns);
  }
  if (!led_.by) {
    return parts_.voice->notice("device.connection_lost", guide::Sound::kLost, now_ns);
  }
  // Who walks by the words of a computer that is gone hears it at once, over them.
  led_.again_from_ns = now_ns;
  if (led_before_.by) led_before_.again_from_ns = now_ns;
  parts_.voice->withdraw_answers(now_ns);
  parts_.voice->notice("device.connection_lost_led", guide::Sound::kLost, now_ns);
}

void DeviceSession::receive(TimestampNs now_ns) {
  while (connection_) {
    const auto message = connection_->receive(std::chrono::milliseconds(0));
    if (!message) return lose(message.error().message, now_ns);
    if (!*message) return;
    heard_ns_ = now_ns;
    const Bytes& bytes = (*message)->bytes;
    const auto read =
        service::read_home_message({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (read) {
      take(*read, now_ns);
    } else {
      std::cerr << "the computer says what this device does not understand: "
                << read.error().message << '\n';
    }
  }
}

void DeviceSession::take(const service::HomeMessage& message, TimestampNs now_ns) {
  if (const auto* welcome = std::get_if<service::Welcome>(&message)) {
    goals_ = goals_of(*welcome);
    role_ = welcome->role;
    // From now on, if it did not before: a computer that has just begun makes its map ready.
    const bool begins_to_see = welcome->can_localize && !std::exchange(can_localize_, true);
    can_localize_ = welcome->can_localize;
    if (link_.state() == service::DeviceLink::State::kConnecting) take_first_welcome(now_ns);
    if (begins_to_see && led_.again_from_ns) led_.again_from_ns = now_ns;
  } else if (const auto* arrived = std::get_if<service::FrameArrived>(&message)) {
    link_.acknowledged(arrived->t_ms, steady_s(now_ns));
  } else if (const auto* error = std::get_if<service::ErrorMessage>(&message)) {
    take_error(*error, now_ns);
  } else if (const auto* recording = std::get_if<service::RecordingState>(&message)) {
    take_recording(*recording, now_ns);
  } else if (const auto* said = std::get_if<service::PromptMessage>(&message)) {
    take_prompt(*said, now_ns);
  } else if (const auto* seen = std::get_if<service::Seen>(&message)) {
    lead_on(*seen, now_ns);
  }
}

void DeviceSession::take_prompt(const service::PromptMessage& message, TimestampNs now_ns) {
  if (message.answer_to) {
    // Who has heard the answer to a newer question does not want the older one any more.
    if (*message.answer_to < newest_answered_) return;
    if (*message.answer_to > newest_answered_) parts_.voice->withdraw_answers(now_ns);
    newest_answered_ = *message.answer_to;
  }
  watch_guide(message);
  if (message.answer_to) asked_.erase(*message.answer_to);
  watch_teaching(message.message_id);
  auto prompt = service::prompt_of(message);
  if (!prompt) {
    std::cerr << prompt.error().message << '\n';
    return;
  }
  ++prompts_;
  // Nobody waits for an answer that the device itself asked for: what is said on the way follows.
  const bool is_asked_for = message.answer_to && message.answer_to != asked_by_device_;
  parts_.voice->say(*std::move(prompt), now_ns, is_asked_for);
}

// Whether a thing is shown, or was and waits for its name.
void DeviceSession::watch_teaching(const std::string& message) {
  if (message == "teach.begin") is_teaching_ = true;
  for (const char* const end : {"teach.learning", "teach.stopped", "teach.no_camera"}) {
    if (message == end) is_teaching_ = false;
  }
}

// What somebody is led by: a question that the guide itself answers.
void DeviceSession::watch_guide(const service::PromptMessage& message) {
  const bool is_of_guide = message.replace_key == "guide";
  const auto asked = message.answer_to ? asked_.find(*message.answer_to) : asked_.end();
  if (asked != asked_.end() && asked->second.question != service::Question::kGuide) {
    const bool asks = asks_to_be_led(asked->second.question);
    if (is_of_guide && (asks || begins_guidance(message.message_id))) {
      led_ = {.by = asked->second};
    } else if (asks) {
      lead_as_before(asked->second);
    }
  }
  if (message.message_id == "guide.paused") led_.is_paused = true;
  if (message.message_id == "guide.resumed") led_.is_paused = false;
  // A computer that came back says so of whom it has forgotten: they are still to be led on.
  const bool has_forgotten = led_.again_from_ns && message.message_id == "guide.not_running";
  if (ends_guidance(message.message_id) && !has_forgotten) led_.by.reset();
  if (!led_.by) led_ = {};
}

// What was asked for is not known.
void DeviceSession::lead_as_before(const service::Ask& asked) {
  if (led_.by && led_.by->id == asked.id) led_ = std::exchange(led_before_, {});
}

void DeviceSession::lead_on(const service::Seen& seen, TimestampNs now_ns) {
  const bool has_waited = led_.again_from_ns && can_localize_ &&
                          seconds_between(*led_.again_from_ns, now_ns) > kPlaced_s;
  if (seen.position || has_waited) lead_again(now_ns);
}

// The computer that came back knows nothing of who was led: the device asks in their place.
void DeviceSession::lead_again(TimestampNs now_ns) {
  if (!led_.by || !led_.again_from_ns || led_.is_paused) return;
  // They may have asked for something else meanwhile: its answer comes first.
  const bool waits_for_words = std::ranges::any_of(asked_, [](const auto& asked) {
    return asked.second.question == service::Question::kInWords;
  });
  if (waits_for_words) return;
  const Led again = std::exchange(led_, {});
  Led before = again.is_unanswered ? std::exchange(led_before_, {}) : Led{};
  ask(*again.by, now_ns);
  asked_by_device_ = questions_;
  led_before_ = std::move(before);
}

void DeviceSession::take_recording(const service::RecordingState& recording, TimestampNs now_ns) {
  if (role_ != "device") return;  // helpers are told of all devices
  // It comes again with every frame.
  const service::RecordingState before = std::exchange(recording_, recording);
  if (before.state == recording.state) return;
  // It may have ended while the connection was lost.
  const bool has_ended = before.state == "recording" && recording.state == "none";
  if (recording.state == "recording") {
    parts_.voice->notice("device.recording", guide::Sound::kAnswer, now_ns);
  } else if (recording.state == "failed") {
    std::cerr << "the recording failed: " << recording.text << '\n';
    parts_.voice->notice("device.recording_failed", guide::Sound::kAlert, now_ns);
  } else if (recording.state == "empty" || (has_ended && before.frames == 0)) {
    parts_.voice->notice("device.recording_empty", guide::Sound::kAlert, now_ns);
  } else if (recording.state == "saved" || has_ended) {
    parts_.voice->notice("device.recording_saved", guide::Sound::kAnswer, now_ns);
  }
}

void DeviceSession::take_error(const service::ErrorMessage& error, TimestampNs now_ns) {
  std::cerr << "the computer: " << error.text << '\n';
  if (error.t_ms) link_.acknowledged(*error.t_ms, steady_s(now_ns));  // the next may be sent
  if (!error.answer_to) return;
  const auto asked = asked_.find(*error.answer_to);
  if (asked == asked_.end()) return;
  if (asks_to_be_led(asked->second.question)) lead_as_before(asked->second);
  const bool names_a_thing = asked->second.question == service::Question::kWhereIs ||
                             asked->second.question == service::Question::kWayTo ||
                             asked->second.question == service::Question::kTakeMeTo;
  asked_.erase(asked);
  parts_.voice->answer(names_a_thing ? "device.not_understood" : "device.failed",
                       guide::Sound::kUnsure, now_ns);
}

// Without a word, somebody would go on with answers that rest on nothing new.
void DeviceSession::watch_camera(TimestampNs now_ns) {
  const auto failure = parts_.camera->failure();
  if (failure.has_value() == camera_failed_) return;
  camera_failed_ = failure.has_value();
  if (failure) std::cerr << *failure << '\n';
  parts_.voice->notice(failure ? "device.camera_failed" : "device.camera_back",
                       failure ? guide::Sound::kAlert : guide::Sound::kBack, now_ns);
}

void DeviceSession::watch_buttons(TimestampNs now_ns) {
  const bool lost = parts_.keys->has_lost_buttons();
  if (std::exchange(buttons_lost_, lost) == lost) return;
  parts_.voice->notice(lost ? "device.buttons_lost" : "device.buttons_back",
                       lost ? guide::Sound::kAlert : guide::Sound::kBack, now_ns);
}

void DeviceSession::send_frames(TimestampNs now_ns) {
  if (!parts_.camera) return;
  watch_camera(now_ns);
  if (link_.take_became_slow()) {
    parts_.voice->notice("device.connection_slow", guide::Sound::kAlert, now_ns);
  }
  // What is recorded must be whole, however long it takes.
  parts_.camera->send_small(link_.is_slow() && recording_.state != "recording");
  if (auto frame = parts_.camera->take()) link_.offer(frame->t_ms, std::move(frame->message));
  if (!connection_) return;
  if (auto bytes = link_.next_frame(steady_s(now_ns))) {
    if (const auto sent = connection_->send_binary(*std::move(bytes)); !sent) {
      lose(sent.error().message, now_ns);
    }
  }
}

void DeviceSession::act(const KeyRequest& request, TimestampNs now_ns) {
  using Kind = KeyRequest::Kind;
  switch (request.kind) {
    case Kind::kWhere:
      return ask(service::Question::kWhereAmI, "", now_ns);
    case Kind::kAround:
      return ask(service::Question::kAroundMe, "", now_ns);
    case Kind::kFind:
      return ask(service::Question::kWhereIs, request.name, now_ns);
    case Kind::kTake:
      return ask(service::Question::kTakeMeTo, request.name, now_ns);
    case Kind::kWay:
      return ask(service::Question::kWayTo, request.name, now_ns);
    case Kind::kPause:
      return tell_guide(service::GuideWish::kPause, now_ns);
    case Kind::kGoOn:
      return tell_guide(service::GuideWish::kResume, now_ns);
    case Kind::kHowFar:
      return tell_guide(service::GuideWish::kHowFar, now_ns);
    case Kind::kNext:
      return tell_guide(service::GuideWish::kNext, now_ns);
    case Kind::kBlocked:
      return tell_guide(service::GuideWish::kBlocked, now_ns);
    case Kind::kEnd:
      return tell_guide(service::GuideWish::kEnd, now_ns);
    case Kind::kPauseOrGoOn:
      return tell_guide(led_.is_paused ? service::GuideWish::kResume : service::GuideWish::kPause,
                        now_ns);
    case Kind::kFindNext:
      return find_next(now_ns);
    case Kind::kTakeFound:
      return take_to_found(now_ns);
    case Kind::kNameRoom:
      return ask(service::Question::kNameRoom, request.name, now_ns);
    case Kind::kInWords:
      return ask(service::Question::kInWords, request.name, now_ns);
    case Kind::kMark:
      return ask(service::Question::kMarkSpot, request.name, now_ns);
    case Kind::kBack:
      return ask(service::Question::kTakeMeBack, "", now_ns);
    case Kind::kSpots:
      return ask(service::Question::kWhichSpots, "", now_ns);
    case Kind::kTeach:
      return ask(is_teaching_ ? service::Question::kStopTeaching : service::Question::kTeachThing,
                 "", now_ns);
    case Kind::kNameThing:
      return ask(service::Question::kNameThing, request.name, now_ns);
    case Kind::kWhichName:
      return parts_.voice->notice("device.which_name", guide::Sound::kNone, now_ns);
    case Kind::kWhichSpot:
      return parts_.voice->notice("device.which_spot", guide::Sound::kNone, now_ns);
    case Kind::kWhichQuestion:
      return parts_.voice->notice("device.which_question", guide::Sound::kNone, now_ns);
    case Kind::kWhichThing:
      return parts_.voice->notice("device.which_thing", guide::Sound::kNone, now_ns);
    case Kind::kWhichRoom:
      return parts_.voice->notice("device.which_room", guide::Sound::kNone, now_ns);
    case Kind::kNoName:
      return parts_.voice->notice("device.which_none", guide::Sound::kNone, now_ns);
    case Kind::kRepeat:
      return parts_.voice->repeat(now_ns);
    case Kind::kQuiet:
      quiet_ = parts_.voice->toggle_quiet(now_ns);
      return send(service::Quiet{quiet_}, now_ns);
    case Kind::kExit:
      over_ = true;
  }
}

// Where it is, so that its name is heard before somebody is led there.
void DeviceSession::find_next(TimestampNs now_ns) {
  if (goals_.empty()) {
    return parts_.voice->notice("device.connection_lost", guide::Sound::kLost, now_ns);
  }
  found_ = goals_[next_goal_++ % goals_.size()];
  found_->question = service::Question::kWhereIs;
  ask(*found_, now_ns);
}

void DeviceSession::take_to_found(TimestampNs now_ns) {
  if (!found_) return find_next(now_ns);
  service::Ask goal = *found_;
  goal.question = service::Question::kTakeMeTo;
  ask(std::move(goal), now_ns);
}

void DeviceSession::ask(service::Question question, const std::string& subject,
                        TimestampNs now_ns) {
  service::Ask ask;
  ask.question = question;
  ask.subject = subject;
  this->ask(std::move(ask), now_ns);
}

void DeviceSession::tell_guide(service::GuideWish wish, TimestampNs now_ns) {
  using service::GuideWish;
  if (wish == GuideWish::kEnd) led_.by.reset();
  if (wish == GuideWish::kPause) led_.is_paused = true;
  if (wish == GuideWish::kResume) {
    led_.is_paused = false;
    const bool can_be_led = connection_ && (can_localize_ || !parts_.camera);
    if (can_be_led && led_.by && led_.again_from_ns) return lead_again(now_ns);
  }
  service::Ask ask;
  ask.question = service::Question::kGuide;
  ask.wish = wish;
  this->ask(std::move(ask), now_ns);
}

void DeviceSession::ask(service::Ask ask, TimestampNs now_ns) {
  // They would outlast the time for which the new answer holds.
  parts_.voice->withdraw_answers(now_ns);
  if (!connection_) {
    return parts_.voice->notice("device.connection_lost", guide::Sound::kLost, now_ns);
  }
  ask.id = ++questions_;
  ask.t_ms = static_cast<double>(now_ns) * 1e-6;
  asked_[ask.id] = ask;
  if (asks_to_be_led(ask.question)) {
    const bool waits = led_.by && asked_.contains(led_.by->id);
    if (!waits) led_before_ = std::move(led_);
    led_ = {.by = ask};  // until the answer says otherwise
  }
  heard_ns_ = now_ns;  // the answer is waited for
  send(ask, now_ns);
}

void DeviceSession::send(const service::DeviceMessage& message, TimestampNs now_ns) {
  if (!connection_) return;
  if (const auto sent = connection_->send_text(service::write(message)); !sent) {
    lose(sent.error().message, now_ns);
  }
}

bool DeviceSession::is_over(TimestampNs now_ns) const {
  return parts_.camera && parts_.camera->ended() && connection_ &&
         seconds_between(heard_ns_, now_ns) > kLastWord_s && parts_.voice->is_silent(now_ns);
}

}  // namespace roomwise::app
