#pragma once

#include <functional>
#include <iosfwd>
#include <memory>
#include <string>

#include "roomwise/guide/words/notices.h"
#include "roomwise/guide/words/prompt_queue.h"
#include "roomwise/speech/speaker.h"

namespace roomwise::app {

// Shows what would be spoken, a line each: for trying things, and for who reads braille.
class TextSpeaker final : public speech::Speaker {
 public:
  explicit TextSpeaker(std::ostream& out) : out_(out) {}
  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance,
                                     TimestampNs now_ns) override;
  [[nodiscard]] Expected<void> stop(TimestampNs) override { return {}; }
  [[nodiscard]] Expected<bool> is_done(TimestampNs) override { return true; }

 private:
  std::ostream& out_;
};

// Speaks by another speaker, and writes a line of each prompt beside it.
class ShownSpeaker final : public speech::Speaker {
 public:
  ShownSpeaker(std::ostream& out, std::unique_ptr<speech::Speaker> speaker)
      : shown_(out), speaker_(std::move(speaker)) {}
  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance,
                                     TimestampNs now_ns) override {
    ROOMWISE_RETURN_IF_ERROR(shown_.begin(utterance, now_ns));
    return speaker_->begin(utterance, now_ns);
  }
  [[nodiscard]] Expected<void> stop(TimestampNs now_ns) override { return speaker_->stop(now_ns); }
  [[nodiscard]] Expected<bool> is_done(TimestampNs now_ns) override {
    return speaker_->is_done(now_ns);
  }

 private:
  TextSpeaker shown_;
  std::unique_ptr<speech::Speaker> speaker_;
};

// Speaks by another speaker that may fail, as the speech daemon does when it is started anew: then
// it is opened again, with a wait between the tries. What could not be spoken is shown on `errors`.
class ReopenedSpeaker final : public speech::Speaker {
 public:
  using Open = std::function<Expected<std::unique_ptr<speech::Speaker>>()>;
  // Fails where it cannot be opened at first.
  [[nodiscard]] static Expected<std::unique_ptr<ReopenedSpeaker>> open(Open open,
                                                                       std::ostream& errors);
  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance,
                                     TimestampNs now_ns) override;
  [[nodiscard]] Expected<void> stop(TimestampNs now_ns) override;
  [[nodiscard]] Expected<bool> is_done(TimestampNs now_ns) override;

 private:
  ReopenedSpeaker(Open open, std::unique_ptr<speech::Speaker> speaker, std::ostream& errors)
      : open_(std::move(open)), speaker_(std::move(speaker)), errors_(errors) {}
  void failed(const Error& error, TimestampNs now_ns);
  // Whether there is a speaker; opens one where it is time to.
  [[nodiscard]] bool has_speaker(TimestampNs now_ns);

  Open open_;
  std::unique_ptr<speech::Speaker> speaker_;  // nullptr: it failed
  std::ostream& errors_;
  TimestampNs tried_ns_ = 0;
};

// "text" (on `shown`), "speech-dispatcher", or "wav:FILE", a recording of what was heard.
[[nodiscard]] Expected<std::unique_ptr<speech::Speaker>> open_speaker(const std::string& choice,
                                                                      TimestampNs now_ns,
                                                                      std::ostream& shown);

// Speaks prompts one after the other, by the rules of guide::PromptQueue.
class DeviceVoice {
 public:
  DeviceVoice(std::unique_ptr<speech::Speaker> speaker, guide::Wording wording)
      : speaker_(std::move(speaker)), wording_(std::move(wording)) {}

  void say(guide::Prompt prompt, TimestampNs now_ns, bool is_asked_for) {
    queue_.add(std::move(prompt), now_ns, is_asked_for);
  }
  // A message of the device itself: "device.connection_lost".
  void notice(const std::string& message, guide::Sound sound, TimestampNs now_ns);
  // The same in place of an answer: who asks anew does not hear it any more.
  void answer(const std::string& message, guide::Sound sound, TimestampNs now_ns);
  // Somebody asked anew: no more of the answers before.
  void withdraw_answers(TimestampNs now_ns);
  void repeat(TimestampNs now_ns);
  // Says which it is now.
  bool toggle_quiet(TimestampNs now_ns);

  // Goes on with what is due; again and again. A speaker that does not tell the end of a prompt
  // long after it must have come is not waited for.
  [[nodiscard]] Expected<void> step(TimestampNs now_ns);
  // Whether nothing is being spoken or will be, if nothing more comes.
  [[nodiscard]] bool is_silent(TimestampNs now_ns) const;

 private:
  [[nodiscard]] Expected<void> watch_speaker(TimestampNs now_ns);

  std::unique_ptr<speech::Speaker> speaker_;
  guide::Wording wording_;
  guide::PromptQueue queue_;
  bool must_stop_ = false;    // the speaker, at the next step
  TimestampNs begun_ns_ = 0;  // what is being spoken
};

}  // namespace roomwise::app
