#include "roomwise/guide/words/notices.h"

#include <algorithm>

namespace roomwise::guide {
namespace {

constexpr double kTooOld_s = 60;

}  // namespace

Prompt notice_prompt(const std::string& message, Sound sound, const Wording& wording,
                     TimestampNs now_ns) {
  Prompt prompt =
      make_prompt(wording, message.substr(0, message.find('_')), message, {}, Confidence::kSure,
                  after(now_ns, kNoticeValid_s), "the device says so");
  prompt.priority = Priority::kNotice;
  prompt.sound = sound;
  return prompt;
}

std::vector<Prompt> repeat_prompts(const std::optional<Said>& last_said, const Wording& wording,
                                   TimestampNs now_ns) {
  const auto refusal = [&](const char* message) {
    return std::vector{make_prompt(wording, "repeat", message, {}, Confidence::kUnsure,
                                   after(now_ns, kNoticeValid_s), "somebody asked to repeat")};
  };
  if (!last_said || last_said->prompts.empty()) return refusal("repeat.nothing");
  if (now_ns > after(last_said->begun_ns, kTooOld_s)) return refusal("repeat.too_old");
  std::vector<Prompt> prompts;
  for (Prompt prompt : last_said->prompts) {
    const auto before = static_cast<double>(prompts.size());
    // The one before it is still being spoken, when this one holds no more.
    if (after(now_ns, before * kSpokenIn_s) > prompt.valid_until_ns) {
      Wording then = wording;
      then.style.language = prompt.language;  // one prompt is of one language
      prompt.text = then.phrases().text("repeat.earlier", {{"text", prompt.text}});
      prompt.message_id = "repeat.earlier";
      prompt.confidence = Confidence::kUnsure;
      prompt.sound = Sound::kUnsure;
      // It says itself that it is old.
      prompt.valid_until_ns = after(now_ns, kNoticeValid_s + before * kSpokenIn_s);
    }
    prompt.replace_key = part_key("repeat", prompts.size());
    prompt.priority = Priority::kAnswer;
    prompts.push_back(std::move(prompt));
  }
  return prompts;
}

}  // namespace roomwise::guide
