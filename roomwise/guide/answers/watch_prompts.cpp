#include "roomwise/guide/answers/watch_prompts.h"

namespace roomwise::guide {

Prompt may_watch_prompt(bool may_watch, const Wording& wording, TimestampNs now_ns) {
  return make_prompt(wording, "watch", may_watch ? "watch.shown" : "watch.hidden", {},
                     Confidence::kSure, after(now_ns, kNoticeValid_s));
}

Prompt watched_prompt(const std::vector<std::string>& names, const Wording& wording,
                      TimestampNs now_ns) {
  Prompt prompt = make_prompt(wording, "watch", "watch.by", {{"names", thing_list(names)}},
                              Confidence::kSure, after(now_ns, kHomeValid_s));
  prompt.priority = Priority::kNotice;
  prompt.sound = Sound::kNone;
  return prompt;
}

}  // namespace roomwise::guide
