#include "device_voice.h"

#include <algorithm>
#include <iostream>
#include <ostream>
#include <utility>

#include "roomwise/speech/recorded_speaker.h"
#include "roomwise/speech/speech_dispatcher.h"

namespace roomwise::app {
namespace {

constexpr int kWordsPerMinute = 175;  // espeak-ng's own
constexpr double kReopenAfter_s = 2;
// A speaker is given up so long after twice the time that the words take.
constexpr double kSpeakerLate_s = 3;
constexpr double kCharacter_s = 0.06;  // spoken at kWordsPerMinute

// UTF-8: all bytes but those that continue a character.
double spoken_s(const std::string& text) {
  const auto characters =
      std::ranges::count_if(text, [](char byte) { return (byte & 0xC0) != 0x80; });
  return static_cast<double>(characters) * kCharacter_s;
}

}  // namespace

Expected<void> TextSpeaker::begin(const guide::Utterance& utterance, TimestampNs) {
  const guide::Prompt& prompt = utterance.prompt;
  if (prompt.sound != guide::Sound::kNone) out_ << '(' << guide::to_string(prompt.sound) << ") ";
  out_ << prompt.text << std::endl;
  return {};
}

// ---- ReopenedSpeaker ----

Expected<std::unique_ptr<ReopenedSpeaker>> ReopenedSpeaker::open(Open open, std::ostream& errors) {
  ROOMWISE_TRY(auto speaker, open());
  return std::unique_ptr<ReopenedSpeaker>(
      new ReopenedSpeaker(std::move(open), std::move(speaker), errors));
}

void ReopenedSpeaker::failed(const Error& error, TimestampNs now_ns) {
  if (speaker_) errors_ << "the speech failed and is opened again: " << error.message << std::endl;
  speaker_.reset();
  tried_ns_ = now_ns;
}

bool ReopenedSpeaker::has_speaker(TimestampNs now_ns) {
  if (speaker_ || seconds_between(tried_ns_, now_ns) < kReopenAfter_s) return speaker_ != nullptr;
  if (auto opened = open_()) {
    speaker_ = *std::move(opened);
  } else {
    failed(opened.error(), now_ns);
  }
  return speaker_ != nullptr;
}

Expected<void> ReopenedSpeaker::begin(const guide::Utterance& utterance, TimestampNs now_ns) {
  if (has_speaker(now_ns)) {
    const Expected<void> begun = speaker_->begin(utterance, now_ns);
    if (begun) return {};
    failed(begun.error(), now_ns);
  }
  errors_ << "not spoken: " << utterance.prompt.text << std::endl;
  return {};
}

Expected<void> ReopenedSpeaker::stop(TimestampNs now_ns) {
  if (!speaker_) return {};
  if (const auto stopped = speaker_->stop(now_ns); !stopped) failed(stopped.error(), now_ns);
  return {};
}

Expected<bool> ReopenedSpeaker::is_done(TimestampNs now_ns) {
  if (!speaker_) return true;
  const Expected<bool> done = speaker_->is_done(now_ns);
  if (done) return *done;
  failed(done.error(), now_ns);
  return true;
}

Expected<std::unique_ptr<speech::Speaker>> open_speaker(const std::string& choice,
                                                        TimestampNs now_ns, std::ostream& shown) {
  if (choice == "text") return std::make_unique<TextSpeaker>(shown);
  if (choice == "speech-dispatcher") {
    return ReopenedSpeaker::open(
        []() -> Expected<std::unique_ptr<speech::Speaker>> {
          return speech::SpeechDispatcher::open({});
        },
        std::cerr);
  }
  constexpr std::string_view kWav = "wav:";
  if (!choice.starts_with(kWav)) {
    return fail("'{}' is no way to speak; use speech-dispatcher, text or wav:FILE", choice);
  }
  ROOMWISE_TRY(speech::WavTimeline timeline,
               speech::WavTimeline::create(choice.substr(kWav.size()), now_ns,
                                           speech::RecordedSpeaker::kRate_hz));
  return std::make_unique<speech::RecordedSpeaker>(std::move(timeline), kWordsPerMinute);
}

void DeviceVoice::notice(const std::string& message, guide::Sound sound, TimestampNs now_ns) {
  say(guide::notice_prompt(message, sound, wording_, now_ns), now_ns, false);
}

void DeviceVoice::answer(const std::string& message, guide::Sound sound, TimestampNs now_ns) {
  guide::Prompt prompt = guide::notice_prompt(message, sound, wording_, now_ns);
  prompt.priority = guide::Priority::kAnswer;
  say(std::move(prompt), now_ns, false);
}

void DeviceVoice::withdraw_answers(TimestampNs now_ns) {
  if (queue_.withdraw_answers(now_ns)) must_stop_ = true;
}

void DeviceVoice::repeat(TimestampNs now_ns) {
  for (guide::Prompt& prompt : guide::repeat_prompts(queue_.last_said(), wording_, now_ns)) {
    say(std::move(prompt), now_ns, true);
  }
}

bool DeviceVoice::toggle_quiet(TimestampNs now_ns) {
  queue_.set_quiet(!queue_.quiet());
  notice(queue_.quiet() ? "device.quiet_on" : "device.quiet_off", guide::Sound::kAnswer, now_ns);
  return queue_.quiet();
}

Expected<void> DeviceVoice::step(TimestampNs now_ns) {
  if (std::exchange(must_stop_, false)) ROOMWISE_RETURN_IF_ERROR(speaker_->stop(now_ns));
  if (queue_.speaking()) ROOMWISE_RETURN_IF_ERROR(watch_speaker(now_ns));
  const auto utterance = queue_.next(now_ns);
  if (queue_.take_expired_answers() > 0) answer("device.failed", guide::Sound::kUnsure, now_ns);
  if (!utterance) return {};
  begun_ns_ = now_ns;
  return speaker_->begin(*utterance, now_ns);
}

Expected<void> DeviceVoice::watch_speaker(TimestampNs now_ns) {
  const guide::Utterance speaking = *queue_.speaking();
  ROOMWISE_TRY(const bool done, speaker_->is_done(now_ns));
  const double max_s = kSpeakerLate_s + 2 * spoken_s(speaking.prompt.text);
  const bool is_given_up = !done && seconds_between(begun_ns_, now_ns) > max_s;
  if (is_given_up) {
    std::cerr << "the speech does not tell that '" << speaking.prompt.text << "' has ended\n";
    ROOMWISE_RETURN_IF_ERROR(speaker_->stop(now_ns));
  }
  if (done || is_given_up) queue_.finished(speaking.id, now_ns);
  return {};
}

bool DeviceVoice::is_silent(TimestampNs now_ns) const {
  return !queue_.speaking() && !queue_.next_at(now_ns);
}

}  // namespace roomwise::app
