#include "roomwise/guide/words/prompt_queue.h"

#include <algorithm>
#include <string_view>

#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {
namespace {

// "around/2" is a part of "around".
bool is_of(std::string_view key, std::string_view whole) {
  return key.starts_with(whole) && (key.size() == whole.size() || key[whole.size()] == '/');
}

std::string_view whole_of(std::string_view key) {
  return key.substr(0, key.find('/'));
}

}  // namespace

Expected<void> PromptQueueOptions::validate() const {
  if (!(same_callout_s >= 0))
    return fail("same_callout_s is {}; expected 0 or more", same_callout_s);
  if (!(same_hazard_s >= 0)) return fail("same_hazard_s is {}; expected 0 or more", same_hazard_s);
  if (!(callout_gap_s >= 0)) return fail("callout_gap_s is {}; expected 0 or more", callout_gap_s);
  return {};
}

bool PromptQueue::was_said_lately(const Prompt& prompt, TimestampNs now_ns) const {
  const double lately_s = prompt.priority == Priority::kCallout  ? options_.same_callout_s
                          : prompt.priority == Priority::kHazard ? options_.same_hazard_s
                                                                 : 0;
  const auto said = said_at_ns_.find({prompt.replace_key, prompt.text});
  return said != said_at_ns_.end() && now_ns < after(said->second, lately_s);
}

void PromptQueue::add(Prompt prompt, TimestampNs now_ns, bool is_asked_for) {
  std::uint64_t place = places_++;
  for (const Waiting& each : waiting_) {
    if (!is_of(each.prompt.replace_key, prompt.replace_key) || now_ns > each.prompt.valid_until_ns)
      continue;
    prompt.priority = std::min(prompt.priority, each.prompt.priority);
    place = std::min(place, each.place);
    is_asked_for = is_asked_for || each.is_asked_for;
  }
  // Also where this one is not spoken: it is the newer word on the same.
  withdraw(prompt.replace_key);
  const bool is_unwanted = is_quiet_ && prompt.priority == Priority::kCallout;
  if (!is_unwanted && !was_said_lately(prompt, now_ns)) {
    waiting_.push_back({std::move(prompt), place, is_asked_for, false});
  }
}

void PromptQueue::withdraw(const std::string& key) {
  std::erase_if(waiting_, [&](const Waiting& each) { return is_of(each.prompt.replace_key, key); });
}

bool PromptQueue::withdraw_answers(TimestampNs now_ns) {
  std::erase_if(waiting_,
                [](const Waiting& each) { return each.prompt.priority == Priority::kAnswer; });
  if (!speaking_ || speaking_->prompt.priority != Priority::kAnswer) return false;
  finished(speaking_->id, now_ns);
  return true;
}

void PromptQueue::forget_expired(TimestampNs now_ns) {
  std::erase_if(waiting_, [&](const Waiting& each) {
    const bool is_expired = now_ns > each.prompt.valid_until_ns;
    const bool is_answer = each.prompt.priority == Priority::kAnswer && each.is_asked_for;
    if (is_expired && is_answer && !each.was_begun) ++expired_answers_;
    return is_expired;
  });
}

bool PromptQueue::breaks_off(const Waiting& waiting) const {
  const Priority spoken = speaking_->prompt.priority;
  if (waiting.prompt.priority == Priority::kHazard) return spoken != Priority::kHazard;
  return waiting.prompt.priority == Priority::kAnswer && waiting.is_asked_for &&
         spoken > Priority::kAnswer;
}

bool PromptQueue::may_begin(const Waiting& waiting, TimestampNs now_ns) const {
  const Prompt& prompt = waiting.prompt;
  if (now_ns > prompt.valid_until_ns || was_said_lately(prompt, now_ns)) return false;
  if (speaking_) return breaks_off(waiting);
  return prompt.priority != Priority::kCallout || !silent_since_ns_ ||
         now_ns >= after(*silent_since_ns_, options_.callout_gap_s);
}

std::vector<PromptQueue::Waiting>::const_iterator PromptQueue::highest_priority(
    TimestampNs now_ns) const {
  auto best = waiting_.end();
  for (auto each = waiting_.begin(); each != waiting_.end(); ++each) {
    if (!may_begin(*each, now_ns)) continue;
    const auto rank = [](const Waiting& waiting) {
      return std::pair(waiting.prompt.priority, waiting.place);
    };
    if (best == waiting_.end() || rank(*each) < rank(*best)) best = each;
  }
  return best;
}

std::optional<Utterance> PromptQueue::next(TimestampNs now_ns) {
  forget_expired(now_ns);
  const auto found = highest_priority(now_ns);
  if (found == waiting_.end()) return std::nullopt;
  const Prompt prompt = found->prompt;
  waiting_.erase(found);
  const bool breaks_off = speaking_.has_value();
  if (breaks_off) break_off(prompt.replace_key, now_ns);
  remember(prompt, now_ns);
  speaking_ = Utterance{++utterances_, prompt, breaks_off};
  return speaking_;
}

void PromptQueue::break_off(const std::string& by_key, TimestampNs now_ns) {
  Prompt prompt = std::move(speaking_->prompt);
  finished(speaking_->id, now_ns);
  const bool is_superseded =
      is_of(prompt.replace_key, by_key) || std::ranges::any_of(waiting_, [&](const Waiting& each) {
        return each.prompt.replace_key == prompt.replace_key;
      });
  // Callouts are not worth a second beginning.
  if (prompt.priority == Priority::kCallout || is_superseded) return;
  // Before its own parts, which came later.
  std::uint64_t place = places_++;
  for (const Waiting& each : waiting_) {
    if (whole_of(each.prompt.replace_key) == whole_of(prompt.replace_key))
      place = std::min(place, each.place);
  }
  waiting_.insert(waiting_.begin(), {std::move(prompt), place, false, true});
}

void PromptQueue::remember(const Prompt& prompt, TimestampNs now_ns) {
  std::erase_if(said_at_ns_, [&](const auto& said) {
    return now_ns > after(said.second, std::max(options_.same_callout_s, options_.same_hazard_s));
  });
  said_at_ns_[{prompt.replace_key, prompt.text}] = now_ns;
  const bool may_be_repeated =
      (prompt.priority == Priority::kAnswer || prompt.priority == Priority::kCallout) &&
      whole_of(prompt.replace_key) != "repeat";
  if (!may_be_repeated) return;
  const bool is_a_part = prompt.replace_key != whole_of(prompt.replace_key);
  const bool continues =
      is_a_part && last_said_ &&
      whole_of(last_said_->prompts.front().replace_key) == whole_of(prompt.replace_key);
  if (!continues) last_said_ = Said{{}, now_ns};
  // It was broken off before and is begun again.
  std::erase_if(last_said_->prompts,
                [&](const Prompt& each) { return each.replace_key == prompt.replace_key; });
  last_said_->prompts.push_back(prompt);
}

void PromptQueue::finished(std::uint64_t id, TimestampNs now_ns) {
  if (!speaking_ || speaking_->id != id) return;
  speaking_.reset();
  silent_since_ns_ = now_ns;
}

bool PromptQueue::interrupts(TimestampNs now_ns) const {
  return speaking_ && highest_priority(now_ns) != waiting_.end();
}

std::optional<TimestampNs> PromptQueue::next_at(TimestampNs now_ns) const {
  if (highest_priority(now_ns) != waiting_.end()) return now_ns;
  if (speaking_ || !silent_since_ns_) return std::nullopt;
  const TimestampNs after_gap = after(*silent_since_ns_, options_.callout_gap_s);
  if (after_gap > now_ns && highest_priority(after_gap) != waiting_.end()) return after_gap;
  return std::nullopt;
}

void PromptQueue::set_quiet(bool quiet) {
  is_quiet_ = quiet;
  if (!quiet) return;
  std::erase_if(waiting_,
                [](const Waiting& each) { return each.prompt.priority == Priority::kCallout; });
}

}  // namespace roomwise::guide
