#include "roomwise/service/protocol/prompt_message.h"

#include <array>
#include <cmath>

namespace roomwise::service {
namespace {

// The one of `values` that is called so.
template <typename Value, std::size_t N>
Expected<Value> named(const std::string& text, const std::array<Value, N>& values) {
  for (const Value value : values) {
    if (guide::to_string(value) == text) return value;
  }
  return fail("a prompt of the computer says '{}', which this device does not know", text);
}

}  // namespace

PromptMessage message_of(const guide::Prompt& prompt) {
  PromptMessage message;
  message.replace_key = prompt.replace_key;
  message.message_id = prompt.message_id;
  message.text = prompt.text;
  message.language = prompt.language;
  message.priority = to_string(prompt.priority);
  message.confidence = to_string(prompt.confidence);
  message.sound = to_string(prompt.sound);
  message.because = prompt.because;
  message.valid_until_t_ms = static_cast<double>(prompt.valid_until_ns) / 1e6;
  return message;
}

Expected<guide::Prompt> prompt_of(const PromptMessage& message) {
  using guide::Confidence;
  using guide::Priority;
  using guide::Sound;
  guide::Prompt prompt;
  prompt.replace_key = message.replace_key;
  prompt.message_id = message.message_id;
  prompt.text = message.text;
  prompt.language = message.language;
  prompt.because = message.because;
  ROOMWISE_TRY(prompt.priority,
               named(message.priority, std::array{Priority::kHazard, Priority::kAnswer,
                                                  Priority::kNotice, Priority::kCallout}));
  ROOMWISE_TRY(prompt.confidence,
               named(message.confidence,
                     std::array{Confidence::kSure, Confidence::kProbable, Confidence::kUnsure}));
  ROOMWISE_TRY(prompt.sound,
               named(message.sound, std::array{Sound::kNone, Sound::kAnswer, Sound::kUnsure,
                                               Sound::kLost, Sound::kBack, Sound::kAlert}));
  prompt.valid_until_ns = std::llround(message.valid_until_t_ms * 1e6);
  return prompt;
}

}  // namespace roomwise::service
