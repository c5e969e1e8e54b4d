#include "device_session.h"
#include "device_credentials.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/input.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/service/testing/testing_service.h"

namespace roomwise::app {
namespace {

using service::testing::Signal;
using ::testing::HasSubstr;

// A camera that sees the same all day, a hundred times a second.
class SameView final : public recording::FrameSource {
 public:
  SameView() {
    info_.name = "test";
    info_.camera.fx = info_.camera.fy = 10;
    info_.camera.width = info_.camera.height = 8;
    info_.frames_remaining = 1'000'000;
    // The pixels too: on a slow network they are put smaller.
    frame_.color = image::ColorImage(8, 8);
    frame_.depth = image::DepthImage(8, 8);
    frame_.encoded_color = image::encode_png(frame_.color);
    frame_.encoded_depth = image::encode_png(frame_.depth);
  }
  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    frame_.timestamp_ns += 10'000'000;
    return std::optional(frame_);
  }
  void skip_before(std::uint64_t) override {}

 private:
  recording::SourceInfo info_;
  image::RgbdFrame frame_;
};

// A live camera that is unplugged after a few frames.
class UnpluggedView final : public recording::FrameSource {
 public:
  UnpluggedView() : info_(view_.info()) { info_.frames_remaining.reset(); }
  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    if (left_-- > 0) return view_.next();
    return fail("the camera was unplugged");
  }
  void skip_before(std::uint64_t) override {}

 private:
  SameView view_;
  recording::SourceInfo info_;
  int left_ = 3;
};

// What is heard, by any thread. While it holds, no answer comes to its end.
class HeardSpeaker final : public speech::Speaker {
 public:
  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance, TimestampNs) override {
    speaks_answer = utterance.prompt.priority == guide::Priority::kAnswer;
    signal.change([&] { heard += utterance.prompt.text + "\n"; });
    return {};
  }
  [[nodiscard]] Expected<void> stop(TimestampNs) override {
    signal.change([&] { heard += "(stop)\n"; });
    return {};
  }
  [[nodiscard]] Expected<bool> is_done(TimestampNs) override { return !(holds && speaks_answer); }
  [[nodiscard]] bool hears(const std::string& text) {
    return signal.wait([&] { return heard.find(text) != std::string::npos; });
  }

  [[nodiscard]] int times(const std::string& text) {
    int count = 0;
    signal.change([&] {
      for (std::size_t at = 0; (at = heard.find(text, at)) != std::string::npos; ++at) ++count;
    });
    return count;
  }

  Signal signal;
  std::string heard;
  std::atomic<bool> holds = false;
  bool speaks_answer = false;  // of the session's thread alone
};

// A home that answers as the protocol says.
class AnsweringHome final : public service::SocketHandler {
 public:
  std::unique_ptr<service::SocketSession> connect(
      const service::Identity&, std::shared_ptr<service::SocketOut> out) override {
    return std::make_unique<Session>(*this, std::move(out));
  }
  [[nodiscard]] bool has_more_frames(int more) {
    int before = 0;
    signal.change([&] { before = frames; });
    return signal.wait([&] { return frames >= before + more; });
  }

  // A device says hello, and hears nothing of it.
  [[nodiscard]] bool was_greeted() {
    return signal.wait([&] { return last_out != nullptr; });
  }
  void welcome() {
    signal.change([&] { last_out->send_text(write(service::HomeMessage(kWelcome))); });
  }

  // To the device that said hello last.
  void say(const service::HomeMessage& message) {
    ASSERT_TRUE(was_greeted());
    std::shared_ptr<service::SocketOut> out;
    signal.change([&] { out = last_out; });
    out->send_text(write(message));
  }

  Signal signal;
  std::shared_ptr<service::SocketOut> last_out;
  int frames = 0;
  std::vector<service::Hello> hellos;
  std::vector<service::Ask> asks;
  std::atomic<bool> has_forgotten = false;  // whom it led
  std::atomic<bool> is_slow = false;        // to answer, without end
  std::atomic<bool> is_late = false;        // its answers hold no more when they come
  std::atomic<bool> welcomes = true;        // who says hello; else welcome() does

 private:
  inline static const service::Welcome kWelcome{
      "flat", "device", {"kitchen"}, {"bed", "lamp"},
      true,   true,     {},          {{"lamp", {"hall", "kitchen"}}}};
  class Session final : public service::SocketSession {
   public:
    Session(AnsweringHome& home, std::shared_ptr<service::SocketOut> out)
        : home_(home), out_(std::move(out)) {}
    void on_text(std::string_view text) override {
      const auto message = service::read_device_message(text);
      ASSERT_OK(message);
      if (const auto* hello = std::get_if<service::Hello>(&*message)) {
        if (home_.welcomes) out_->send_text(write(service::HomeMessage(kWelcome)));
        home_.signal.change([&] {
          home_.hellos.push_back(*hello);
          home_.last_out = out_;
        });
      } else if (const auto* ask = std::get_if<service::Ask>(&*message)) {
        home_.signal.change([&] { home_.asks.push_back(*ask); });
        if (!home_.is_slow) answer(*ask);
      }
    }
    void on_message(Bytes bytes) override {
      const auto frame = service::read_frame(bytes);
      ASSERT_OK(frame);
      home_.signal.change([&] { ++home_.frames; });
      out_->send_text(write(service::HomeMessage(service::FrameArrived{frame->t_ms, 0})));
    }
    void on_closed() override {}

   private:
    void answer(const service::Ask& ask) {
      if (ask.question == service::Question::kNameRoom || ask.subject == "nonsense") {
        out_->send_text(write(service::HomeMessage(service::ErrorMessage{"refused", ask.id})));
      } else if (ask.question == service::Question::kAroundMe) {
        for (const char* key : {"around", "around/2", "around/3"}) say(ask, key, "Bed.");
      } else if (ask.subject == "piano") {
        say(ask, "thing piano", "I know no piano.", "where.unknown");
      } else if (ask.question == service::Question::kTakeMeTo) {
        say(ask, "guide", "To the " + ask.subject + ".", "guide.begin");
      } else if (ask.question == service::Question::kGuide && home_.has_forgotten) {
        say(ask, "guide", "I lead you nowhere.", "guide.not_running");
      } else if (ask.question == service::Question::kGuide) {
        using service::GuideWish;
        say(ask, "guide", "As you wish.",
            ask.wish == GuideWish::kEnd      ? "guide.ended"
            : ask.wish == GuideWish::kResume ? "guide.resumed"
                                             : "guide.paused");
      } else if (ask.question == service::Question::kTeachThing) {
        say(ask, "teaching", "Show it.", "teach.begin");
      } else if (ask.question == service::Question::kNameThing) {
        const bool is_taken = ask.subject == "bed";
        say(ask, "teaching", is_taken ? "Taken." : "One moment.",
            is_taken ? "teach.name" : "teach.learning");
      } else if (ask.question == service::Question::kStopTeaching) {
        say(ask, "teaching", "Stopped.", "teach.stopped");
      } else {
        say(ask, "answer", "Answer about " + ask.subject + ".");
      }
    }
    void say(const service::Ask& ask, const std::string& key, const std::string& text,
             const std::string& message = "room.is") {
      service::PromptMessage prompt;
      prompt.answer_to = ask.id;
      prompt.replace_key = key;
      prompt.message_id = message;
      prompt.text = text;
      prompt.language = "en";
      prompt.priority = "answer";
      prompt.confidence = "sure";
      prompt.sound = "answer";
      prompt.valid_until_t_ms = ask.t_ms + (home_.is_late ? -1 : 60'000);
      out_->send_text(write(service::HomeMessage(prompt)));
    }

    AnsweringHome& home_;
    std::shared_ptr<service::SocketOut> out_;
  };
};

class DeviceSessionTest : public ::testing::Test {
 protected:
  DeviceSessionTest()
      : DeviceSessionTest(
            std::make_unique<DeviceCamera>(std::make_unique<SameView>(), CameraPace{})) {}
  explicit DeviceSessionTest(std::unique_ptr<DeviceCamera> camera,
                             const std::string& language = "en") {
    auto speaker = std::make_unique<HeardSpeaker>();
    speaker_ = speaker.get();
    guide::Wording wording;
    wording.catalogue = &catalogue_;
    wording.style.language = language;
    start_server();
    DeviceParts parts;
    parts.server = {"127.0.0.1", server_->port()};
    parts.credentials = {around_.certificate.fingerprint, around_.device.token};
    parts.hello.version = service::kProtocolVersion;
    parts.hello.name = "Cap";
    parts.hello.kind = service::DeviceKind::kWearable;
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    keyboard_ = ends[0];
    typing_ = ends[1];
    EXPECT_EQ(::mkfifo((folder_ / "event0").c_str(), 0600), 0);
    parts.keys = DeviceKeys::open(keyboard_, folder_ / "event0").value();
    buttons_ = ::open((folder_ / "event0").c_str(), O_WRONLY);
    parts.camera = std::move(camera);
    // However slow the machine is, nothing is lost and nothing slow.
    parts.times = {.acknowledged_s = 1000, .slow_from_s = 1000};
    parts.wait = {.timeout = std::chrono::seconds(10), .silence = std::chrono::seconds(10)};
    parts.voice = std::make_unique<DeviceVoice>(std::move(speaker), wording);
    session_ = std::make_unique<DeviceSession>(std::move(parts));
  }
  ~DeviceSessionTest() override {
    ::close(keyboard_);
    ::close(typing_);
    ::close(buttons_);
  }
  void type(const std::string& text) const {
    EXPECT_EQ(::write(typing_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void press(int key, bool is_held = false) const {
    std::array<input_event, 2> events{};
    events[0].type = events[1].type = EV_KEY;
    events[0].code = events[1].code = static_cast<std::uint16_t>(key);
    events[0].value = 1;
    events[1].input_event_sec = is_held ? 3 : 0;
    EXPECT_EQ(::write(buttons_, events.data(), sizeof events), ssize_t{sizeof events});
  }
  // What is asked as the one of that number, from 1 on.
  service::Ask asked(std::size_t number) {
    EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() >= number; }));
    service::Ask ask;
    home_.signal.change([&] { ask = home_.asks.at(number - 1); });
    return ask;
  }
  void start_server() {
    around_.options.port = server_ ? server_->port() : std::uint16_t{0};
    server_.reset();
    server_ = service::Server::start(around_.options, service::Router({}), *around_.access, home_)
                  .value();
  }

  service::testing::TestServer around_;  // for its certificate and devices
  AnsweringHome home_;
  std::unique_ptr<service::Server> server_;
  guide::MessageCatalogue catalogue_ = guide::MessageCatalogue::built_in();
  HeardSpeaker* speaker_ = nullptr;
  int keyboard_ = -1;  // the two ends of a pipe
  int typing_ = -1;
  roomwise::testing::ScratchFolder folder_;
  int buttons_ = -1;  // where they are pressed
  std::unique_ptr<DeviceSession> session_;
};

// A base before the session, whose camera asks for it at once, from a thread of its own.
struct Plug {
  std::atomic<bool> is_plugged_in_ = false;
};

class UnpluggedCameraTest : protected Plug, public DeviceSessionTest {
 protected:
  UnpluggedCameraTest()
      : DeviceSessionTest(std::make_unique<DeviceCamera>(
            std::make_unique<UnpluggedView>(), CameraPace{.reopen_s = 0.01},
            [this]() -> Expected<std::unique_ptr<recording::FrameSource>> {
              if (!is_plugged_in_) return fail("no camera was found");
              return std::make_unique<SameView>();
            })) {}
};

TEST_F(UnpluggedCameraTest, SaysThatTheCameraFailedAndThatItIsBack) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("The camera does not work."));
  EXPECT_TRUE(speaker_->hears("Ready."));
  type("f lamp\n");
  EXPECT_TRUE(speaker_->hears("Answer about lamp.")) << "it goes on without";
  is_plugged_in_ = true;
  EXPECT_TRUE(speaker_->hears("The camera sees again."));
  EXPECT_TRUE(home_.has_more_frames(3));
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("The camera does not work."), 1);
}

TEST_F(DeviceSessionTest, SaysThatTheButtonsAreGoneAndThatTheyAreBack) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  ::close(buttons_);
  EXPECT_TRUE(speaker_->hears("The buttons do not work."));
  EXPECT_TRUE(speaker_->hears("Ready."));
  buttons_ = ::open((folder_ / "event0").c_str(), O_WRONLY);  // once they are looked for
  EXPECT_TRUE(speaker_->hears("The buttons work again."));
  press(KEY_1);
  EXPECT_EQ(asked(1).question, service::Question::kWhereAmI);
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("The buttons do not work."), 1);
}

TEST_F(DeviceSessionTest, GoesOnAfterTheServerWasAway) {
  struct Stop final : Interruption {
    [[nodiscard]] bool interrupted() const override { return asked; }
    std::atomic<bool> asked = false;
  } stop;
  std::thread running([&] { EXPECT_OK(session_->run(stop)); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  EXPECT_TRUE(home_.has_more_frames(3));
  server_->stop();
  EXPECT_TRUE(speaker_->hears("The connection is lost."));
  start_server();
  EXPECT_TRUE(speaker_->hears("Connected again."));
  EXPECT_TRUE(home_.has_more_frames(1));
  stop.asked = true;
  running.join();
  EXPECT_EQ(session_->counts().losses, 1u);
  ASSERT_EQ(home_.hellos.size(), 2u);
  EXPECT_EQ(home_.hellos[1].name, "Cap");
}

class GermanSessionTest : public DeviceSessionTest {
 protected:
  GermanSessionTest()
      : DeviceSessionTest(
            std::make_unique<DeviceCamera>(std::make_unique<SameView>(), CameraPace{}), "de") {}
};

TEST_F(GermanSessionTest, SaysInItsLanguageThatTheComputerIsNotThereYet) {
  server_->stop();
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ich erreiche den Computer nicht."));
  start_server();
  EXPECT_TRUE(speaker_->hears("Bereit."));
  server_->stop();
  EXPECT_TRUE(speaker_->hears("Die Verbindung ist weg."));
  start_server();
  EXPECT_TRUE(speaker_->hears("Wieder verbunden."));
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("Ich erreiche den Computer nicht."), 1);
  EXPECT_EQ(speaker_->times("127.0.0.1"), 0) << "what only the log needs";
}

class LedSessionTest : public DeviceSessionTest {
 protected:
  // Led to the bed, until the server goes and comes back.
  void lose_the_server_and_find_it(const char* typed_meanwhile) {
    EXPECT_TRUE(speaker_->hears("Ready."));
    type("g bed\n");
    EXPECT_TRUE(speaker_->hears("To the bed."));
    server_->stop();
    EXPECT_TRUE(speaker_->hears("Stop. The connection is lost."));
    if (*typed_meanwhile != '\0') {
      type(typed_meanwhile);
      EXPECT_TRUE(speaker_->hears("lost.\nThe connection is lost.")) << "the key was seen";
    }
    start_server();
    EXPECT_TRUE(speaker_->hears("Connected again."));
    EXPECT_TRUE(home_.has_more_frames(2));
  }
  // Led to the bed, until this is said, after which nobody is led on.
  void hear_the_end(const std::string& message) {
    std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
    EXPECT_TRUE(speaker_->hears("Ready."));
    type("g bed\n");
    EXPECT_TRUE(speaker_->hears("To the bed."));
    service::PromptMessage end;
    end.replace_key = "guide";
    end.message_id = message;
    end.text = "That is all.";
    end.language = "en";
    end.priority = "answer";
    end.confidence = "sure";
    end.sound = "back";
    end.valid_until_t_ms = 1e12;
    home_.say(end);
    EXPECT_TRUE(speaker_->hears("That is all."));
    server_->stop();
    EXPECT_TRUE(speaker_->hears("all.\nThe connection is lost."));
    start_server();
    EXPECT_TRUE(speaker_->hears("Connected again."));
    see_a_place();
    EXPECT_TRUE(home_.has_more_frames(3));
    type("x");
    running.join();
    EXPECT_EQ(home_.asks.size(), 1u);
  }
  void see_a_place() {
    service::Seen seen;
    seen.position = service::SeenPosition{1, 2, 1.5, 90, 0.02};
    home_.say(seen);
  }
  [[nodiscard]] std::size_t asked() {
    std::size_t count = 0;
    home_.signal.change([&] { count = home_.asks.size(); });
    return count;
  }
};

TEST_F(LedSessionTest, IsLedOnAfterTheServerWasAwayAsSoonAsItSeesThePlace) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  lose_the_server_and_find_it("");
  EXPECT_EQ(asked(), 1u) << "nobody knows yet where they are";
  see_a_place();
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 2; }));
  EXPECT_TRUE(home_.has_more_frames(1));
  see_a_place();
  EXPECT_TRUE(home_.has_more_frames(2));
  type("x");
  running.join();
  ASSERT_EQ(home_.asks.size(), 2u) << "asked once";
  EXPECT_EQ(home_.asks[1].question, service::Question::kTakeMeTo);
  EXPECT_EQ(home_.asks[1].subject, "bed");
  EXPECT_GT(home_.asks[1].id, home_.asks[0].id);
  EXPECT_GT(home_.asks[1].t_ms, home_.asks[0].t_ms);
}

// As where the words that the computer is back were still being spoken.
TEST_F(LedSessionTest, AnAnswerThatTheDeviceAskedForItselfAndThatCameTooLateIsNoFailure) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  lose_the_server_and_find_it("");
  home_.is_late = true;
  see_a_place();
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 2; }));
  EXPECT_TRUE(home_.has_more_frames(3));
  EXPECT_EQ(speaker_->times("That did not work."), 0);
  type("f lamp\n");
  EXPECT_TRUE(speaker_->hears("That did not work.")) << "somebody asked";
  type("x");
  running.join();
}

TEST_F(LedSessionTest, IsLedOnAlsoWhoAskedHowFarBeforeThePlaceWasSeen) {
  home_.has_forgotten = true;
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  lose_the_server_and_find_it("");
  type("h");
  EXPECT_TRUE(speaker_->hears("I lead you nowhere."));
  see_a_place();
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 3; }));
  type("x");
  running.join();
  EXPECT_EQ(home_.asks.back().question, service::Question::kTakeMeTo);
  EXPECT_EQ(home_.asks.back().subject, "bed");
}

TEST_F(LedSessionTest, WhoAskedForAnotherGoalMeanwhileIsNotLedToTheOldOne) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  lose_the_server_and_find_it("");
  home_.is_slow = true;
  type("g lamp\n");
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 2; }));
  see_a_place();
  EXPECT_TRUE(home_.has_more_frames(3));
  type("x");
  running.join();
  ASSERT_EQ(home_.asks.size(), 2U);
  EXPECT_EQ(home_.asks.back().subject, "lamp");
}

TEST_F(LedSessionTest, WhoAskedForWhatNobodyKnowsIsLedOnAsBefore) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  type("g piano\n");
  EXPECT_TRUE(speaker_->hears("I know no piano."));
  type("g bed\n");
  EXPECT_TRUE(speaker_->hears("To the bed."));
  type("g piano\ng nonsense\n");
  EXPECT_TRUE(speaker_->hears("I did not understand."));
  EXPECT_EQ(speaker_->times("I know no piano."), 2);
  server_->stop();
  EXPECT_TRUE(speaker_->hears("Stop. The connection is lost."));
  start_server();
  EXPECT_TRUE(speaker_->hears("Connected again."));
  see_a_place();
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 5; }));
  type("x");
  running.join();
  EXPECT_EQ(home_.asks.back().subject, "bed");
}

TEST_F(LedSessionTest, WhoWaitsToHearWhetherAGoalIsKnownIsLedOnAsBeforeWhereItIsNot) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  type("g bed\n");
  EXPECT_TRUE(speaker_->hears("To the bed."));
  home_.is_slow = true;
  type("g piano\n");
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 2; }));
  server_->stop();
  EXPECT_TRUE(speaker_->hears("Stop. The connection is lost."));
  home_.is_slow = false;
  start_server();
  EXPECT_TRUE(speaker_->hears("Connected again."));
  see_a_place();
  EXPECT_TRUE(speaker_->hears("I know no piano."));
  see_a_place();
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 4; }));
  type("x");
  running.join();
  EXPECT_EQ(home_.asks.back().subject, "bed");
}

TEST_F(LedSessionTest, IsNotLedOnWhoEndedItMeanwhile) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  lose_the_server_and_find_it("e");
  see_a_place();
  EXPECT_TRUE(home_.has_more_frames(3));
  type("x");
  running.join();
  EXPECT_EQ(home_.asks.size(), 1u);
}

TEST_F(LedSessionTest, IsLedOnWhoPausedOnceTheyGoOn) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  lose_the_server_and_find_it("p");
  see_a_place();
  EXPECT_TRUE(home_.has_more_frames(3));
  EXPECT_EQ(asked(), 1u);
  type("o");
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 2; }));
  type("x");
  running.join();
  EXPECT_EQ(home_.asks.back().question, service::Question::kTakeMeTo);
}

TEST_F(LedSessionTest, IsNotLedOnWhoHasArrived) {
  hear_the_end("guide.there_ahead");
}

TEST_F(LedSessionTest, IsNotLedOnToWhatANewMapLacks) {
  hear_the_end("guide.ended_unknown");
}

TEST_F(DeviceSessionTest, AsksWhatIsTypedAndSpeaksTheAnswers) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  type("f lamp\n");
  EXPECT_TRUE(speaker_->hears("Answer about lamp."));
  type("q");
  EXPECT_TRUE(speaker_->hears("I only answer now."));
  type("w");
  EXPECT_TRUE(home_.signal.wait([&] { return home_.asks.size() == 2; }));
  type("x");
  running.join();
  ASSERT_EQ(home_.asks.size(), 2u);
  EXPECT_EQ(home_.asks[1].question, service::Question::kWhereAmI);
  EXPECT_GE(session_->prompts(), 1u);
}

TEST_F(DeviceSessionTest, FiveButtonsChooseAGoalPauseGoOnAndEnd) {
  using service::GuideWish;
  using service::Question;
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  press(KEY_3);
  EXPECT_TRUE(asked(1).is_room) << "rooms come first";
  press(KEY_3);
  EXPECT_TRUE(asked(2).is_way_out);
  press(KEY_3);
  EXPECT_EQ(asked(3).question, Question::kWhereIs);
  EXPECT_EQ(asked(3).subject, "bed");
  EXPECT_TRUE(speaker_->hears("Answer about bed."));
  press(KEY_3, true);
  EXPECT_EQ(asked(4).question, Question::kTakeMeTo);
  EXPECT_EQ(asked(4).subject, "bed");
  EXPECT_TRUE(speaker_->hears("To the bed."));
  press(KEY_4, true);
  EXPECT_EQ(asked(5).wish, GuideWish::kPause);
  press(KEY_4, true);
  EXPECT_EQ(asked(6).wish, GuideWish::kResume);
  press(KEY_2, true);
  EXPECT_EQ(asked(7).wish, GuideWish::kBlocked);
  press(KEY_5, true);
  EXPECT_EQ(asked(8).wish, GuideWish::kEnd);
  press(KEY_3);
  press(KEY_3);
  EXPECT_EQ(asked(10).subject, "lamp");
  EXPECT_EQ(asked(9).in_room + asked(10).in_room, "hallkitchen") << "one in each room";
  type("x");
  running.join();
}

TEST_F(DeviceSessionTest, IsReadyOnceItIsWelcomed) {
  home_.welcomes = false;
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(home_.was_greeted());
  type("q");
  EXPECT_TRUE(speaker_->hears("I only answer now."));
  EXPECT_EQ(speaker_->times("Ready."), 0);
  home_.welcome();
  EXPECT_TRUE(speaker_->hears("Ready."));
  press(KEY_3);
  EXPECT_TRUE(asked(1).is_room) << "what there is can be chosen from";
  type("x");
  running.join();
}

TEST_F(DeviceSessionTest, IsNotReadyWhereTheComputerGoesBeforeItsWelcome) {
  home_.welcomes = false;
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(home_.was_greeted());
  server_->stop();
  EXPECT_TRUE(speaker_->hears("I cannot reach the computer."));
  home_.welcomes = true;
  start_server();
  EXPECT_TRUE(speaker_->hears("Ready."));
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("lost"), 0);
}

TEST_F(DeviceSessionTest, TeachesAThingByKeysAndStopsByTheSameKey) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  type("y");
  EXPECT_TRUE(speaker_->hears("Show it."));
  type("y");
  EXPECT_TRUE(speaker_->hears("Stopped."));
  type("y");
  EXPECT_TRUE(speaker_->signal.wait([&] { return speaker_->heard.ends_with("Show it.\n"); }));
  type("c");
  EXPECT_TRUE(speaker_->hears("What is it called?"));
  type("bed\n");
  EXPECT_TRUE(speaker_->hears("Taken."));
  type("c my mug\n");
  EXPECT_TRUE(speaker_->hears("One moment."));
  type("yx");
  running.join();
  std::vector<service::Question> asked;
  for (const service::Ask& ask : home_.asks) asked.push_back(ask.question);
  using service::Question;
  EXPECT_THAT(asked, ::testing::ElementsAre(Question::kTeachThing, Question::kStopTeaching,
                                            Question::kTeachThing, Question::kNameThing,
                                            Question::kNameThing, Question::kTeachThing))
      << "what was named is taught: the key begins anew";
  EXPECT_EQ(home_.asks[4].subject, "my mug");
}

TEST_F(DeviceSessionTest, AQuestionBreaksOffTheAnswerBefore) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  speaker_->holds = true;
  type("a");
  EXPECT_TRUE(speaker_->hears("Bed."));
  EXPECT_TRUE(home_.has_more_frames(2)) << "then the whole of the answer has come";
  type("f lamp\n");
  EXPECT_TRUE(speaker_->hears("(stop)\nAnswer about lamp."));
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("Bed."), 1);
}

TEST_F(DeviceSessionTest, TellsWhatTheComputerRefuses) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  home_.say(service::ErrorMessage{"of nobody's question", {}});
  home_.say(service::ErrorMessage{"of another's question", 99});
  type("f nonsense\n");
  EXPECT_TRUE(speaker_->hears("I did not understand."));
  type("n kitchen\n");
  EXPECT_TRUE(speaker_->hears("That did not work."));
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("I did not understand."), 1);
  EXPECT_EQ(speaker_->times("That did not work."), 1);
  ASSERT_EQ(home_.asks.size(), 2u);
  EXPECT_EQ(home_.asks[1].question, service::Question::kNameRoom);
  EXPECT_EQ(home_.asks[1].subject, "kitchen");
}

TEST_F(DeviceSessionTest, TellsThatItIsRecorded) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  service::RecordingState state;
  state.name = "walk";
  const auto send = [&](const char* now) {
    state.state = now;
    ++state.frames;
    home_.say(state);
  };
  const auto hears_last = [&](const std::string& text) {
    return speaker_->signal.wait([&] { return speaker_->heard.ends_with(text + "\n"); });
  };
  for (int frame = 0; frame < 3; ++frame) {
    send("recording");
    EXPECT_TRUE(hears_last("Recording."));
  }
  send("saved");
  EXPECT_TRUE(hears_last("The recording is saved."));
  send("recording");
  EXPECT_TRUE(hears_last("Recording."));
  send("failed");
  EXPECT_TRUE(hears_last("The recording failed."));
  send("none");
  send("recording");
  EXPECT_TRUE(hears_last("Recording."));
  state.frames = 0;
  send("empty");
  EXPECT_TRUE(hears_last("Nothing was recorded."));
  send("recording");
  EXPECT_TRUE(hears_last("Recording."));
  send("none");
  EXPECT_TRUE(hears_last("The recording is saved.")) << "it ended while nobody could say so";
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("Recording."), 4);
}

// Its command line may hold the code for ever.
TEST_F(DeviceSessionTest, AnEarlierPairingIsUsedWhereTheCodeWasUsedUp) {
  const std::filesystem::path file = folder_ / "device.json";
  const std::string server = "127.0.0.1:" + std::to_string(server_->port());
  const service::ClientWait wait{.timeout = std::chrono::seconds(10)};
  const auto found = [&](const std::string& code) {
    return find_pairing(file, server, code, "Cap", wait);
  };
  EXPECT_ERROR(found(""), "is not paired");
  ASSERT_OK(
      store_credentials(file, server, {around_.certificate.fingerprint, around_.device.token}));
  const auto earlier = found("123456");
  ASSERT_OK(earlier);
  EXPECT_FALSE(earlier->is_new);
  EXPECT_EQ(earlier->credentials.token, around_.device.token);
  server_.reset();
  EXPECT_OK(found("123456")) << "the computer is not there yet";
}

TEST_F(DeviceSessionTest, TellsOnceThatItWasRemoved) {
  std::thread running([&] { EXPECT_OK(session_->run(SilentProgress())); });
  EXPECT_TRUE(speaker_->hears("Ready."));
  ASSERT_OK(around_.access->revoke(around_.device.who.device));
  server_->disconnect(around_.device.who.device, "removed");
  EXPECT_TRUE(speaker_->hears("The connection is lost."));
  EXPECT_TRUE(speaker_->hears("This device was removed."));
  type("f lamp\n");
  EXPECT_TRUE(
      speaker_->hears("This device was removed. Ask your helper.\nThe connection is lost."));
  type("x");
  running.join();
  EXPECT_EQ(speaker_->times("This device was removed."), 1);
}

}  // namespace
}  // namespace roomwise::app
