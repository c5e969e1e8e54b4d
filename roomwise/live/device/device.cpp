#include "roomwise/live/device/device.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>
#include <type_traits>

#include "roomwise/base/stopwatch.h"
#include "roomwise/guide/answers/watch_prompts.h"
#include "roomwise/guide/questions/refusal_prompts.h"
#include "roomwise/guide/words/notices.h"
#include "roomwise/live/device/owner.h"
#include "roomwise/pipeline/stored/stored_edits.h"
#include "roomwise/service/protocol/prompt_message.h"

namespace roomwise::live {
namespace {

constexpr int kMaxUnread = 10;           // of messages, before the connection is closed
constexpr double kNamedFor_ms = 30'000;  // "take me there" means what was named last
constexpr std::size_t kMaxWaiting = 8;   // questions

service::Seen seen_of(const FrameResult& result) {
  service::Seen seen;
  seen.t_ms = result.t_ms;
  if (result.decision) {
    seen.room_decision = rooms::to_string(result.decision->verdict);
    seen.room = result.decision->rooms.front().room;
    seen.probability = std::clamp(result.decision->rooms.front().score, 0.0, 1.0);
    seen.why = result.decision->why;
  }
  if (result.place) {
    const Eigen::Vector3d at = result.place->position_plan();
    seen.position = service::SeenPosition{at.x(), at.y(), at.z(),
                                          result.place->heading_rad() * 180 / std::numbers::pi,
                                          result.place->sigma_m};
  }
  return seen;
}

bool is_of_own_things(service::Question question) {
  using service::Question;
  switch (question) {
    case Question::kTeachThing:
    case Question::kNameThing:
    case Question::kStopTeaching:
    case Question::kForgetThing:
    case Question::kShareThing:
    case Question::kKeepThing:
      return true;
    default:
      return false;
  }
}

// Of questions about spots those that need no picture.
bool is_of_spots(service::Question question) {
  return question == service::Question::kForgetSpot || question == service::Question::kRenameSpot ||
         question == service::Question::kWhichSpots;
}

bool is_of_watching(service::Question question) {
  return question == service::Question::kShowWalks || question == service::Question::kHideWalks;
}

bool asks_to_be_led(service::Question question) {
  return question == service::Question::kTakeMeTo || question == service::Question::kTakeMeBack;
}

// What the newest picture answers by itself: it is looked at for this alone, by whoever looks at
// frames.
bool is_of_picture(service::Question question) {
  return question == service::Question::kWhoIsHere || question == service::Question::kIsItLight;
}

// A fault on one device's picture must end neither the program nor the looking at its next ones.
template <typename Work>
std::invoke_result_t<Work> without_faults(const Work& work) {
  try {
    return work();
  } catch (const std::exception& fault) {
    return fail("internal error, please report it: {}", fault.what());
  }
}

guide::TeachingStep step_of(service::Question question) {
  using service::Question;
  switch (question) {
    case Question::kForgetThing:
      return guide::TeachingStep::kForgotten;
    case Question::kShareThing:
      return guide::TeachingStep::kShared;
    default:
      return guide::TeachingStep::kKept;
  }
}

}  // namespace

// ---- from the connection ----

void Device::on_text(std::string_view text) {
  const auto message = service::read_device_message(text);
  if (!message) return refuse_unread(message.error(), service::id_of_ask(text));
  has_read();
  take(*message);
}

void Device::has_read() {
  const std::scoped_lock lock(mutex_);
  unread_ = std::max(0, unread_ - 1);
}

void Device::take(const service::DeviceMessage& message) {
  if (const auto* const hello = std::get_if<service::Hello>(&message)) return greet(*hello);
  const auto* const ask = std::get_if<service::Ask>(&message);
  bool greeted = false;
  bool is_other_language = false;
  std::optional<bool> may_watch;
  {
    const std::scoped_lock lock(mutex_);
    greeted = greeted_;
    if (const auto* const change = std::get_if<service::SettingsChange>(&message)) {
      is_other_language = change->language && *change->language != settings_.language;
      if (change->may_watch != settings_.may_watch) may_watch = change->may_watch;
      apply(*change, settings_);
      if (led_) led_->speak_by(settings_);
    } else if (const auto* const quiet = std::get_if<service::Quiet>(&message)) {
      quiet_ = quiet->on;
    }
  }
  if (!greeted) {
    return refuse_unread(Error{"the first message must be hello"},
                         ask != nullptr ? std::optional(ask->id) : std::nullopt);
  }
  if (is_other_language) home_changed();  // things have other names now
  if (may_watch) {
    let_watch(*may_watch);
    say_whether_watched(*may_watch);
  }
  if (const auto* const watch = std::get_if<service::Watch>(&message)) {
    if (who_.role != service::Role::kHelper) return refuse(Error{"only helpers may watch"});
    if (!watches_.exchange(watch->on) && watch->on) host_.began_to_watch(*this);
  }
  if (ask != nullptr) hear({*ask});
}

void Device::greet(const service::Hello& hello) {
  if (hello.version != service::kProtocolVersion) {
    refuse(Error{fmt::format("the computer speaks version {} of the protocol, this device {}",
                             service::kProtocolVersion, hello.version)});
    out_->close("another version of the protocol");
    return;
  }
  bool is_second = false;
  {
    const std::scoped_lock lock(mutex_);
    is_second = std::exchange(greeted_, true);
    if (!is_second) {
      settings_ = hello.settings;
      camera_ = hello.camera;
      // Under the lock, so that what others tell a greeted device comes after it.
      send(welcome());
    }
  }
  if (is_second) return refuse_unread(Error{"hello was said already; connect anew to change it"});
  host_.came_anew(*this);
  record_to(host_.recorder_for(*this));
  show_walk(true, /*with_end=*/false);
}

service::Welcome Device::welcome() const {
  const auto view = host_.view_for(who_);
  service::Welcome welcome;
  welcome.home = view->name;
  welcome.role = service::to_string(who_.role);
  for (const rooms::Room& room : view->rooms) welcome.rooms.push_back(room.name);
  welcome.things = names_of_things(*view, settings_);
  welcome.things_in_rooms = things_in_rooms(*view, settings_);
  for (const ViewedSpot& spot : view->spots) {
    if (!spot.stored.name.empty()) welcome.spots.push_back(spot.stored.name);
  }
  welcome.has_room_classifier = view->recognizer != nullptr;
  welcome.can_localize = view->map != nullptr;
  return welcome;
}

void Device::on_message(Bytes bytes) {
  const auto read = service::read_frame(bytes);
  if (!read) return refuse_unread(read.error(), {}, service::time_of_frame(bytes));
  has_read();
  if (!camera()) {
    return refuse_unread(Error{"a frame came from a device whose hello told of no camera"}, {},
                         read->t_ms);
  }
  CameraFrame frame{read->t_ms,
                    {read->color.begin(), read->color.end()},
                    {read->depth.begin(), read->depth.end()},
                    read->camera,
                    read->depth_size,
                    read->pose};
  const Clock::time_point came = Clock::now();
  frame.came_s = to_ms(came) / 1000;
  store(frame);
  service::FrameArrived arrived{frame.t_ms, 0};
  {
    const std::scoped_lock lock(mutex_);
    heard_at(frame.t_ms);
    if (newest_) ++dropped_;
    newest_ = std::move(frame);
    newest_came_ = came;
    arrived.dropped = dropped_;
  }
  send(arrived);
  host_.has_work(shared_from_this());
}

void Device::on_closed() {
  watches_ = false;
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  newest_.reset();
  waiting_.clear();
}

void Device::refuse(const Error& error, std::optional<std::int64_t> answer_to,
                    std::optional<double> frame_t_ms) {
  send(service::ErrorMessage{error.message, answer_to, frame_t_ms});
}

void Device::refuse_unread(const Error& error, std::optional<std::int64_t> answer_to,
                           std::optional<double> frame_t_ms) {
  refuse(error, answer_to, frame_t_ms);
  const std::scoped_lock lock(mutex_);
  if (++unread_ == kMaxUnread) out_->close("too many messages that could not be read");
}

// ---- questions ----

void Device::hear(const Asked& asked) {
  const service::Ask& ask = asked.ask;
  {
    const std::scoped_lock lock(mutex_);
    heard_at(std::max(last_heard_t_ms_, ask.t_ms));
  }
  if (ask.question != service::Question::kInWords) {
    const std::scoped_lock lock(mutex_);
    offered_ = {};  // a "yes" after this would answer something else
  }
  if (ask.question == service::Question::kNameRoom) {
    if (const auto named = host_.name_recorded_room(*this, ask.subject); !named) {
      return refuse(named.error(), ask.id);
    }
    return hear_now(asked);
  }
  if (ask.question == service::Question::kInWords) return understand(asked);
  if (is_of_own_things(ask.question)) {
    hear_of_own_things(ask);
    return host_.answered(ask.question, seconds_since(asked.came));
  }
  if (is_of_spots(ask.question)) {
    hear_of_spots(ask);
    return host_.answered(ask.question, seconds_since(asked.came));
  }
  if (is_of_watching(ask.question)) {
    const bool may_watch = ask.question == service::Question::kShowWalks;
    const std::vector prompts{
        guide::may_watch_prompt(may_watch, wording_now(), std::llround(ask.t_ms * 1e6))};
    if (may_watch) say(prompts, ask.id, {});
    let_watch(may_watch);
    if (!may_watch) say(prompts, ask.id, {});  // once it is so
    return host_.answered(ask.question, seconds_since(asked.came));
  }
  service::Ask now = ask;
  std::vector<guide::Prompt> again;
  std::optional<std::int64_t> pushed_out;
  bool waits = false;
  {
    const std::scoped_lock lock(mutex_);
    const bool to_guide = ask.question == service::Question::kGuide ||
                          (ask.question == service::Question::kRepeat && is_led());
    const bool is_end =
        ask.question == service::Question::kGuide && ask.wish == service::GuideWish::kEnd;
    if (is_end && last_ask_ && asks_to_be_led(last_ask_->question)) last_ask_.reset();
    const bool was_mark = last_ask_ && last_ask_->question == service::Question::kMarkSpot;
    if (ask.question == service::Question::kRepeat && !to_guide && was_mark) {
      // Who has walked on would mark another place.
      again = guide::repeat_prompts(marked_, wording_of(settings_), std::llround(ask.t_ms * 1e6));
    } else if (ask.question == service::Question::kRepeat && !to_guide && last_ask_) {
      // What was true then need not be now: the question is asked anew.
      now = *last_ask_;
      now.id = ask.id;
      now.t_ms = ask.t_ms;
    }
    if (now.question != service::Question::kRepeat && !to_guide) {
      last_ask_ = now;
      if (now.question == service::Question::kMarkSpot) marked_.reset();
      // The frame in hand answers it, or whoever looks at frames does.
      waits = newest_ || looking_ || is_of_picture(now.question);
    }
    if (waits && waiting_.size() == kMaxWaiting) {
      pushed_out = waiting_.front().ask.id;
      waiting_.pop_front();
    }
    if (waits) waiting_.push_back({now, asked.came});
  }
  if (!again.empty()) {
    say(again, ask.id, {});
    return host_.answered(ask.question, seconds_since(asked.came));
  }
  if (pushed_out) refuse(Error{"too many questions at once"}, pushed_out);
  if (waits && is_of_picture(now.question)) host_.has_work(shared_from_this());
  if (!waits) hear_now({now, asked.came});
}

void Device::understand(const Asked& asked) {
  const service::Ask& in_words = asked.ask;
  static_assert(service::kMaxWordsBytes <= guide::kMaxQuestionBytes);
  const auto view = host_.view_for(who_);
  const guide::HomeNames names = names_in(*view);
  guide::Wording wording;
  guide::Dialogue dialogue;
  service::SpeakingSettings settings;
  {
    const std::scoped_lock lock(mutex_);
    settings = settings_;
    wording = wording_of(settings_);
    dialogue.is_led = is_led();
    dialogue.follows_way = dialogue.is_led && led_->follows_way();
    if (dialogue.is_led) dialogue.goal = led_->goal();
    dialogue.offer = std::exchange(offered_, {});
    if (in_words.t_ms > offered_until_t_ms_) dialogue.offer = {};
    // Who is led may take back for as long where they wanted to be led.
    const bool is_goal = dialogue.goal && !named_.names.empty() &&
                         named_.type == guide::QuestionType::kTakeMeTo &&
                         named_.names.front().name == dialogue.goal->name;
    if (is_goal || in_words.t_ms - named_t_ms_ <= kNamedFor_ms) {
      dialogue.last = named_;
      dialogue.chosen_from = chosen_from_;
    }
  }
  const guide::Understood offered = dialogue.offer;
  const bool is_led_now = dialogue.is_led;
  const guide::Understood& choice_of =
      guide::choices_of(offered).empty() ? dialogue.chosen_from : offered;
  const guide::UserLocation location = location_now(in_words.t_ms);
  dialogue.places = places_of(guide::choices_of(choice_of), in_words, *view, location, settings,
                              calendar_time(unix_now_ns()));
  guide::Understood heard =
      guide::in_dialogue(in_words.subject, wording.phrases(), names, dialogue);
  if (const auto ask = ask_of(heard, in_words)) {
    if (!heard.names.empty()) {
      const std::scoped_lock lock(mutex_);
      named_ = heard;
      named_t_ms_ = in_words.t_ms;
      chosen_from_ = guide::is_chosen_from(heard, choice_of) ? choice_of : guide::Understood{};
    }
    if (heard.is_nearest) return hear({*ask, asked.came});
    auto rooms = rooms_to_choose(*ask, *view, location, wording);
    const auto behind_doors = doors_to_choose(*ask, *view, location, wording);
    if (rooms.empty() && behind_doors.empty()) return hear({*ask, asked.came});
    heard = rooms.empty() ? guide::which_door(std::move(heard), behind_doors)
                          : guide::which_room(std::move(heard), std::move(rooms));
  }
  auto prompts = guide::refusal_prompts(heard, names, wording, std::llround(in_words.t_ms * 1e6),
                                        {location.room, is_led_now});
  {
    const std::scoped_lock lock(mutex_);
    const bool is_emergency =
        heard.outcome == guide::Understood::Outcome::kQuestion &&
        (heard.type == guide::QuestionType::kEmergency || heard.type == guide::QuestionType::kHelp);
    // A word that is not understood leaves the offer as it is.
    const bool is_lost = heard.outcome == guide::Understood::Outcome::kNotUnderstood;
    offered_ = is_lost ? offered : heard;
    if (!is_lost) offered_until_t_ms_ = static_cast<double>(prompts.front().valid_until_ns) / 1e6;
    const bool doubts_way = heard.doubts_way && is_led() && led_->follows_way();
    if ((is_emergency && is_led()) || doubts_way) {
      prompts.insert(prompts.begin(), led_->hear(service::GuideWish::kPause, in_words.t_ms));
      if (settings_.may_watch) watch_.say(prompts, Clock::now());
    }
  }
  say(prompts, in_words.id, {});
  show_walk(false);
  host_.answered(in_words.question, seconds_since(asked.came));
}

// ---- places that are marked ----

void Device::say_spot(guide::SpotStep step, const std::string& name, const service::Ask& ask,
                      const std::string& because) {
  say({guide::spot_prompt(step, name, wording_now(), std::llround(ask.t_ms * 1e6), because)},
      ask.id, {});
}

void Device::hear_of_spots(const service::Ask& ask) {
  using service::Question;
  if (ask.question == Question::kWhichSpots) {
    std::vector<std::string> names;
    const auto known = host_.view_for(who_);
    for (const ViewedSpot& one : known->spots) {
      if (!one.stored.name.empty()) names.push_back(one.stored.name);
    }
    const TimestampNs now_ns = std::llround(ask.t_ms * 1e6);
    return say(guide::spots_prompts(names, wording_now(), now_ns), ask.id, {});
  }
  const bool renames = ask.question == Question::kRenameSpot;
  const auto view = host_.view_for(who_);
  if (renames && !pipeline::validate_spoken_name(ask.name)) {
    return say_spot(guide::SpotStep::kBadName, ask.name, ask);
  }
  if (renames && means_something(ask.name, *view, wording_now())) {
    return say_spot(guide::SpotStep::kOtherName, ask.name, ask);
  }
  const auto changed =
      host_.change_spot(who_, ask.subject, renames ? std::optional(ask.name) : std::nullopt);
  if (changed) {
    say_spot(renames ? guide::SpotStep::kRenamed : guide::SpotStep::kForgotten,
             renames ? ask.name : ask.subject, ask);
    if (!renames) host_.erase_forgotten(who_, ask.subject, ask.question);
    return;
  }
  if (changed.error().code != ErrorCode::kRefused) {
    return say_spot(guide::SpotStep::kBusy, ask.subject, ask, changed.error().message);
  }
  // Of one that they may change it is the new name.
  const ViewedSpot* const spot = spot_called(ask.subject, *view);
  const bool may_change = spot != nullptr && (who_.role == service::Role::kHelper ||
                                              spot->stored.owner == owner_of(who_));
  say_spot(renames && may_change ? guide::SpotStep::kOtherName : guide::SpotStep::kNotYours,
           ask.subject, ask, changed.error().message);
}

void Device::mark_spot(const service::Ask& ask) {
  const guide::Prompt prompt = mark(ask);
  {
    const std::scoped_lock lock(mutex_);
    marked_ = guide::Said{{prompt}, std::llround(ask.t_ms * 1e6)};
  }
  say({prompt}, ask.id, {});
}

guide::Prompt Device::mark(const service::Ask& ask) {
  std::optional<Eigen::Vector3d> place;
  bool has_picture = false, had_pictures = false;
  {
    const std::scoped_lock lock(mutex_);
    had_pictures = this->had_pictures();
    has_picture = last_result_ && ask.t_ms - last_result_->t_ms <= kMaxFrameAge_ms;
    if (has_picture && last_result_->place && last_result_->place->sigma_m <= kMaxSpotSigma_m) {
      place = last_result_->place->position_plan();
    }
  }
  const auto view = host_.view_for(who_);
  const guide::Wording wording = wording_now();
  const auto step = [&](guide::SpotStep what, const std::string& because = {}) {
    return guide::spot_prompt(what, ask.subject, wording, std::llround(ask.t_ms * 1e6), because);
  };
  if (view->walks.empty()) return no_map(wording, ask.t_ms);
  if (!has_picture) return no_picture(had_pictures, wording, ask.t_ms);
  if (!place) return step(guide::SpotStep::kNotSure, "no sure place");
  if (!ask.subject.empty() && !pipeline::validate_spoken_name(ask.subject)) {
    return step(guide::SpotStep::kBadName);
  }
  if (means_something(ask.subject, *view, wording)) return step(guide::SpotStep::kOtherName);
  if (view->marked.size() >= pipeline::kMaxSpots) return step(guide::SpotStep::kTooMany);
  const auto marked = host_.mark_spot(who_, ask.subject, *place);
  if (marked) return step(guide::SpotStep::kMarked);
  const bool is_name = marked.error().code == ErrorCode::kRefused;
  return step(is_name ? guide::SpotStep::kOtherName : guide::SpotStep::kBusy,
              marked.error().message);
}

// ---- what the picture tells by itself ----

void Device::answer_by_picture(const service::Ask& ask) {
  std::shared_ptr<const FrameImages> images;
  double taken_t_ms = 0;
  bool had_pictures = false;
  {
    const std::scoped_lock lock(mutex_);
    had_pictures = this->had_pictures();
    if (last_result_ && ask.t_ms - last_result_->t_ms <= kMaxFrameAge_ms) {
      images = last_result_->images;
      taken_t_ms = last_result_->t_ms;
    }
  }
  const guide::Wording wording = wording_now();
  const TimestampNs now_ns = std::llround(std::max(ask.t_ms, taken_t_ms) * 1e6);
  if (!images) return say({no_picture(had_pictures, wording, ask.t_ms)}, ask.id, {});
  if (ask.question == service::Question::kIsItLight) {
    return say(guide::light_prompts(is_dark(images->color), wording, now_ns), ask.id, taken_t_ms);
  }
  const auto known = camera();
  const auto people = host_.people_in(*images, known ? known->calibrated : std::nullopt);
  if (!people) return say({guide::no_eyes_prompt(wording, now_ns)}, ask.id, {});
  say(guide::people_prompts(*people, wording, now_ns), ask.id, taken_t_ms);
}

// ---- things that are taught ----

guide::UserLocation Device::location_now(double t_ms) const {
  const std::scoped_lock lock(mutex_);
  const bool is_fresh = last_result_ && t_ms - last_result_->t_ms <= kMaxFrameAge_ms;
  return standing_of(is_fresh ? &*last_result_ : nullptr);
}

guide::Wording Device::wording_now() const {
  const std::scoped_lock lock(mutex_);
  return wording_of(settings_);
}

std::shared_ptr<Teaching> Device::teaching() const {
  const std::scoped_lock lock(mutex_);
  return teaching_;
}

void Device::say_step(guide::TeachingStep step, const std::string& name, double t_ms,
                      std::optional<std::int64_t> answer_to, const std::string& because) {
  guide::Wording wording;
  {
    const std::scoped_lock lock(mutex_);
    wording = wording_of(settings_);
  }
  say({guide::teaching_prompt(step, name, wording, std::llround(t_ms * 1e6), because)}, answer_to,
      {});
}

void Device::hear_of_own_things(const service::Ask& ask) {
  using service::Question;
  switch (ask.question) {
    case Question::kTeachThing:
      return begin_teaching(ask);
    case Question::kNameThing:
      return name_taught(ask);
    case Question::kStopTeaching: {
      {
        const std::scoped_lock lock(mutex_);
        teaching_.reset();
      }
      return say_step(guide::TeachingStep::kStopped, {}, ask.t_ms, ask.id);
    }
    default:
      break;
  }
  const auto changed = host_.change_own_thing(who_, ask.subject, ask.question);
  const bool is_not_own = !changed && changed.error().code == ErrorCode::kRefused;
  const guide::TeachingStep step = changed      ? step_of(ask.question)
                                   : is_not_own ? guide::TeachingStep::kNotOwn
                                                : guide::TeachingStep::kBusy;
  say_step(step, ask.subject, ask.t_ms, ask.id, changed ? "" : changed.error().message);
  if (step == guide::TeachingStep::kForgotten) {
    host_.erase_forgotten(who_, ask.subject, ask.question);
  }
}

void Device::was_not_erased(const std::string& name, service::Question what, const Error& why) {
  double t_ms = 0;
  {
    const std::scoped_lock lock(mutex_);
    t_ms = now_t_ms();
  }
  if (what == service::Question::kForgetThing) {
    return say_step(guide::TeachingStep::kNotErased, name, t_ms, {}, why.message);
  }
  say({guide::spot_prompt(guide::SpotStep::kNotErased, name, wording_now(),
                          std::llround(t_ms * 1e6), why.message)},
      {}, {});
}

void Device::begin_teaching(const service::Ask& ask) {
  const bool has_camera = camera().has_value();
  if (has_camera) {
    const std::scoped_lock lock(mutex_);
    teaching_ = std::make_shared<Teaching>();
  }
  say_step(has_camera ? guide::TeachingStep::kBegin : guide::TeachingStep::kNoCamera, {}, ask.t_ms,
           ask.id);
}

void Device::name_taught(const service::Ask& ask) {
  const std::shared_ptr<Teaching> shown = teaching();
  if (!shown || !shown->has_enough()) {
    return say_step(guide::TeachingStep::kMore, {}, ask.t_ms, ask.id);
  }
  // Once enough was shown it changes no more.
  const auto begun = host_.teach(shared_from_this(), ask.subject, ask.is_private, shown->shown());
  if (begun) {
    {
      const std::scoped_lock lock(mutex_);
      teaching_.reset();
    }
    return say_step(guide::TeachingStep::kLearning, {}, ask.t_ms, ask.id);
  }
  const bool is_name = begun.error().code == ErrorCode::kRefused;
  say_step(is_name ? guide::TeachingStep::kOtherName : guide::TeachingStep::kBusy, {}, ask.t_ms,
           ask.id, begun.error().message);
}

void Device::was_taught(const std::string& name, const Expected<bool>& taught) {
  double t_ms = 0;
  {
    const std::scoped_lock lock(mutex_);
    t_ms = now_t_ms();  // its last frame may have come long ago
  }
  const guide::TeachingStep step = !taught   ? guide::TeachingStep::kFailed
                                   : *taught ? guide::TeachingStep::kTaught
                                             : guide::TeachingStep::kTaughtNotLookedFor;
  say_step(step, name, t_ms, {}, taught ? "" : taught.error().message);
}

Expected<void> Device::teach(const CameraFrame& frame, Teaching& teaching) {
  const auto known = camera();
  if (!known) return fail("this device said in its hello that it has no camera");
  ROOMWISE_TRY(const FrameImages images, images_of(frame, *known));
  const double units = known->calibrated ? known->calibrated->depth_units_per_metre : 1000;
  const Teaching::Reply reply = teaching.take(images, units, frame.t_ms);
  guide::Wording wording;
  {
    const std::scoped_lock lock(mutex_);
    if (teaching_.get() != &teaching) return {};  // stopped, or begun anew, meanwhile
    if (reply.step == guide::TeachingStep::kStopped) teaching_.reset();
    wording = wording_of(settings_);
  }
  if (reply.step) say_step(*reply.step, {}, frame.t_ms, {});
  if (reply.fault) {
    say({guide::fault_prompt(*reply.fault, wording, std::llround(frame.t_ms * 1e6))}, {},
        frame.t_ms);
  }
  return {};
}

// Answers by the last glance, if it is new enough.
void Device::hear_now(const Asked& asked) {
  const service::Ask& ask = asked.ask;
  if (is_of_picture(ask.question)) {
    answer_by_picture(ask);
    return host_.answered(ask.question, seconds_since(asked.came));
  }
  if (ask.question == service::Question::kMarkSpot) {
    mark_spot(ask);
    return host_.answered(ask.question, seconds_since(asked.came));
  }
  std::vector<guide::Prompt> prompts;
  std::optional<double> based_on_t_ms;
  {
    const std::scoped_lock lock(mutex_);
    const bool is_fresh = last_result_ && ask.t_ms - last_result_->t_ms <= kMaxFrameAge_ms;
    if (is_fresh) based_on_t_ms = last_result_->t_ms;
    const auto view = host_.view_for(who_);
    const bool asks_way = ask.question == service::Question::kWayTo && led_;
    const Situation now{*view,
                        is_fresh ? &*last_result_ : nullptr,
                        settings_,
                        ask.t_ms,
                        calendar_time(unix_now_ns()),
                        asks_way ? led_->floor_on(*view) : nullptr,
                        had_pictures()};
    prompts = answer_now(ask, view, now);
    announcer_.answered(now, prompts);
    if (led_ && settings_.may_watch) watch_.say(prompts, Clock::now());
  }
  say(prompts, ask.id, based_on_t_ms);
  show_walk(asks_to_be_led(ask.question));
  host_.answered(ask.question, seconds_since(asked.came));
}

std::vector<guide::Prompt> Device::lead_to(const service::Ask& goal,
                                           const std::shared_ptr<const HomeView>& home,
                                           const Situation& now, bool is_way_back) {
  auto led = LedWalk::to(goal, home, now, led_.get());
  if (!led) return {};  // who is led is led on as before
  led_ = std::move(led);
  watch_ = {};
  // Who is led back keeps where they set out: it is where they go.
  const bool is_sure =
      now.result != nullptr && now.result->place && now.result->place->sigma_m <= kMaxSpotSigma_m;
  if (is_sure && !is_way_back) host_.sets_out(who_, now.result->place->position_plan());
  return {led_->begin(now)};
}

std::vector<guide::Prompt> Device::answer_now(const service::Ask& ask,
                                              const std::shared_ptr<const HomeView>& home,
                                              const Situation& now) {
  using service::Question;
  if (ask.question == Question::kTakeMeTo) {
    if (auto prompts = lead_to(ask, home, now, false); !prompts.empty()) return prompts;
  }
  if (ask.question == Question::kTakeMeBack) {
    const auto back = way_back(*home, unix_now_ns() / 1'000'000'000);
    if (back) {
      const service::Ask goal{ask.id, ask.t_ms, Question::kTakeMeTo, *back};
      if (auto prompts = lead_to(goal, home, now, true); !prompts.empty()) return prompts;
    }
  }
  if (ask.question == Question::kGuide && led_) return {led_->hear(ask.wish, ask.t_ms)};
  if (ask.question == Question::kRepeat && is_led()) return {led_->repeat(ask.t_ms)};
  return answer(ask, now);
}

void Device::answer_waiting(bool more_frames_wait) {
  std::deque<Asked> asked;
  {
    const std::scoped_lock lock(mutex_);
    // A question waits for a frame that is about as new as itself, if one is there.
    const auto may_wait = [&](const service::Ask& ask) {
      return more_frames_wait &&
             (!last_result_ || last_result_->t_ms < ask.t_ms - kMaxFrameAge_ms / 4);
    };
    std::deque<Asked> later;
    for (Asked& one : waiting_) (may_wait(one.ask) ? later : asked).push_back(std::move(one));
    waiting_ = std::move(later);
  }
  for (const Asked& one : asked) hear_now(one);
}

void Device::say(const std::vector<guide::Prompt>& prompts, std::optional<std::int64_t> answer_to,
                 std::optional<double> based_on_t_ms) {
  for (const guide::Prompt& prompt : prompts) {
    service::PromptMessage message = service::message_of(prompt);
    message.answer_to = answer_to;
    message.based_on_t_ms = based_on_t_ms;
    send(message);
  }
}

// ---- frames ----

Expected<FrameResult> Device::look(CameraFrame frame) {
  return without_faults([&]() -> Expected<FrameResult> {
    if (!frame_processor_) frame_processor_.emplace(camera(), host_.lens_of(*this));
    return frame_processor_->look(std::move(frame), host_.view_for(who_));
  });
}

bool Device::work() {
  std::optional<CameraFrame> frame;
  Clock::time_point came;
  {
    const std::scoped_lock lock(mutex_);
    came = newest_came_;
    if (looking_ || closed_) return false;
    frame = std::move(newest_);
    newest_.reset();
    looking_ = frame.has_value();
  }
  if (!frame) {
    answer_waiting(false);
    return false;
  }
  if (const auto shown = teaching(); shown && !shown->has_enough()) {
    // Nobody walks meanwhile, and the thing hides the room.
    const auto taught = without_faults([&] { return teach(*frame, *shown); });
    {
      const std::scoped_lock lock(mutex_);
      looking_ = false;
    }
    if (!taught) refuse(taught.error(), {}, frame->t_ms);
    answer_waiting(false);
    const std::scoped_lock lock(mutex_);
    return newest_.has_value();
  }
  const Clock::time_point began = Clock::now();
  const double t_ms = frame->t_ms;
  Expected<FrameResult> result = look(*std::move(frame));
  host_.looked(seconds_since(began), result.has_value());
  bool more = false;
  {
    const std::scoped_lock lock(mutex_);
    looking_ = false;
    more = newest_.has_value();
    if (result) last_result_ = *result;
  }
  if (result) {
    // What is shown comes last: who has it has all that this frame has to say.
    call_out(*result, came);
    send(seen_of(*result));
    const std::scoped_lock lock(seen_mutex_);
    host_.saw(*this, *result);
  } else {
    refuse(result.error(), {}, t_ms);
  }
  answer_waiting(more);
  return more;
}

void Device::call_out(const FrameResult& result, Clock::time_point came) {
  std::vector<guide::Prompt> prompts;
  std::optional<service::GoalBearing> bearing;
  {
    const std::scoped_lock lock(mutex_);
    const auto view = host_.view_for(who_);
    // What is in the way of somebody who is led is told by the guidance where that knows the place:
    // it knows the goal, and whether they are to walk. Told again and again to who stands before a
    // thing or turns, it would break off every sentence that says what to do.
    std::vector<guide::Prompt> of_guide;
    if (led_) {
      of_guide = led_->after(result, view);
      bearing = led_->goal_bearing(result.t_ms);
    }
    const bool tells_obstacles = !led_ || !led_->judges_obstacles();
    prompts = announcer_.after({*view, &result, settings_, result.t_ms}, tells_obstacles);
    std::erase_if(prompts, [&](const guide::Prompt& prompt) {
      return prompt.priority == guide::Priority::kCallout &&
             (quiet_ || !settings_.callouts || is_led());
    });
    if (led_ && settings_.may_watch) {
      const Clock::time_point now = Clock::now();
      if (is_led()) watch_.say(prompts, now);
      watch_.say(of_guide, now);
      if (is_led() && result.place) watch_.place(*result.place, came);
    }
    std::ranges::move(of_guide, std::back_inserter(prompts));
  }
  say(prompts, {}, result.t_ms);
  if (bearing) send(*bearing);
  show_walk(false);
}

// ---- helpers who watch ----

void Device::heard_at(double t_ms) {
  last_heard_t_ms_ = t_ms;
  last_heard_ = Clock::now();
}

double Device::now_t_ms() const {
  const bool was_heard = last_heard_ != Clock::time_point();
  return last_heard_t_ms_ + (was_heard ? 1e3 * seconds_since(last_heard_) : 0);
}

void Device::let_watch(bool may_watch) {
  {
    const std::scoped_lock lock(mutex_);
    speaks_for_itself_ = true;
    settings_.may_watch = may_watch;
    if (!may_watch) watch_ = {};
  }
  show_walk(true, /*with_end=*/false);
  if (may_watch) return;
  const std::scoped_lock lock(seen_mutex_);
  host_.shows_less(*this);
}

void Device::let_nobody_watch() {
  const std::scoped_lock lock(mutex_);
  speaks_for_itself_ = false;
  settings_.may_watch = false;
  watch_ = {};
}

// Who is led hears it; else who changes a setting has read it.
void Device::say_whether_watched(bool may_watch) {
  const std::scoped_lock lock(mutex_);
  if (!is_led()) return;
  const TimestampNs now_ns = std::llround(now_t_ms() * 1e6);
  say({guide::may_watch_prompt(may_watch, wording_of(settings_), now_ns)}, {}, {});
}

service::WatchedDevice Device::watched(bool with_end) const {
  service::WatchedDevice watched{who_.device, who().name, to_ms(Clock::now()), settings_.may_watch};
  const bool is_shown = settings_.may_watch && (with_end ? led_ != nullptr : is_led());
  if (is_shown) watched.walk = watch_.shown(led_->watched());
  return watched;
}

void Device::tell_of(std::span<const service::Identity> watchers) {
  const auto names = watch_.to_tell(watchers);
  if (names.empty()) return;
  const TimestampNs now_ns = std::llround(now_t_ms() * 1e6);
  say({guide::watched_prompt(names, wording_of(settings_), now_ns)}, {}, {});
}

// Sent under the lock: once a person said no, nothing that was so before it goes out.
void Device::show_walk(bool in_any_case, bool with_end) {
  const std::scoped_lock lock(mutex_);
  if (!greeted_ || closed_ || !camera_) return;
  // Else it would tell that they asked to be led.
  if (with_end && !settings_.may_watch) return;
  if (!in_any_case && !led_) return;
  std::vector<service::Identity> watchers = host_.watchers(who_);
  const service::WatchedDevice now = watched(with_end);
  if (now.walk && !is_led()) {
    std::erase_if(watchers, [&](const service::Identity& one) { return !watch_.was_told_of(one); });
  }
  if (watchers.empty()) return;
  if (now.walk) {
    const Clock::time_point now_is = Clock::now();
    if (!in_any_case && !watch_.is_due(*now.walk, !is_led(), now_is)) return;
    watch_.was_shown(*now.walk, now_is);
    tell_of(watchers);
  }
  host_.shows_walk(now, watchers);
}

void Device::show_walk_to(Device& helper) {
  const std::scoped_lock lock(mutex_);
  if (!greeted_ || closed_ || !camera_ || !speaks_for_itself_) return;
  if (helper.who_.device == who_.device) return;
  const service::WatchedDevice now = watched(/*with_end=*/false);
  if (now.walk) {
    std::vector<service::Identity> watchers = host_.watchers(who_);
    if (std::ranges::find(watchers, helper.who_.device, &service::Identity::device) ==
        watchers.end()) {
      watchers.push_back(helper.who());
    }
    tell_of(watchers);
  }
  helper.send(now);
}

// ---- recording ----

void Device::store(const CameraFrame& frame) {
  std::shared_ptr<WalkRecorder> recorder;
  {
    const std::scoped_lock lock(mutex_);
    recorder = recorder_;
  }
  if (!recorder) return;
  const auto stored = recorder->store(frame);
  // A full disk is told once and not with every frame.
  bool failed_before = false;
  {
    const std::scoped_lock lock(mutex_);
    failed_before = std::exchange(storing_fails_, !stored);
    const bool is_closed = stored && !*stored;
    if (is_closed && recorder_ == recorder) recorder_.reset();
    if (is_closed) return;  // whoever closed it told so
  }
  if (!stored && failed_before) return;
  if (!stored) host_.not_recorded(stored.error());
  host_.recorded(*this, {who_.device, stored ? "recording" : "failed", recorder->name(),
                         recorder->frames(), stored ? "" : stored.error().message});
}

void Device::record_to(std::shared_ptr<WalkRecorder> recorder) {
  const std::scoped_lock lock(mutex_);
  recorder_ = std::move(recorder);
  storing_fails_ = false;
}

// ---- from the home ----

void Device::home_changed() {
  // Sent under the lock: of two changes at once the later one is told last.
  const std::scoped_lock lock(mutex_);
  if (greeted_) out_->send_text(service::write_home_changed(welcome()));
}

void Device::send(const service::HomeMessage& message) {
  out_->send_text(write(message));
}

bool Device::is_here() const {
  const std::scoped_lock lock(mutex_);
  return greeted_ && !closed_;
}

std::optional<service::DeviceCamera> Device::camera() const {
  const std::scoped_lock lock(mutex_);
  return camera_;
}

service::Identity Device::who() const {
  const std::scoped_lock lock(name_mutex_);
  return {who_.device, name_, who_.role};
}

void Device::rename(const std::string& name) {
  {
    const std::scoped_lock lock(name_mutex_);
    name_ = name;
  }
  show_walk(/*in_any_case=*/true, /*with_end=*/false);
}

service::DeviceSeen Device::seen() const {
  const std::scoped_lock lock(mutex_);
  service::DeviceSeen seen{who_.device, who().name, greeted_ && !closed_, {}};
  if (last_result_) seen.seen = seen_of(*last_result_);
  if (seen.seen && !settings_.may_watch) seen.seen->position.reset();
  return seen;
}

std::uint64_t Device::dropped() const {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

}  // namespace roomwise::live
