#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/guide/words/prompt.h"

namespace roomwise::guide {

struct PromptQueueOptions {
  double same_callout_s = 60;   // a callout is not begun again so soon after the same was said
  double same_hazard_s = 4;     // nor a hazard, which is seen anew with every picture
  double callout_gap_s = 0.75;  // of silence before a callout, so that somebody can think

  [[nodiscard]] Expected<void> validate() const;
};

// A prompt that is to be spoken now: its sound first, then its text.
struct Utterance {
  std::uint64_t id = 0;
  Prompt prompt;
  bool breaks_off = false;  // what is being spoken is to be stopped first
};

// What was said last, of what may be repeated: the prompts of one answer, or a callout.
struct Said {
  std::vector<Prompt> prompts;
  TimestampNs begun_ns = 0;  // the first of them
};

// The rules of speaking, for one person. The caller passes in the time, of a clock that never goes
// back, and does the speaking:
//
//   queue.add(prompt, now);
//   if (auto utterance = queue.next(now)) ...speak it...      again and again
//   queue.finished(utterance.id, now);                        when it has been spoken
//
// - The most urgent goes first; of equals the one that came first.
// - A prompt takes the place of one with its key that waits, and of those with keys KEY/..., which
//   are parts of the same answer. It keeps the urgency of what it replaces: somebody asked.
// - What is past its time is never begun.
// - The same callout (key and text) is not said twice within a minute; questions are always
//   answered.
// - Before a callout there is silence for a moment.
// - A hazard breaks off what is being spoken, unless that is a hazard too. So does an answer that
//   was asked for a notice or callout: it holds for seconds. An answer or notice that was broken
//   off is spoken again afterwards, if it still holds.
// - Who asks anew hears no more of the answers before: withdraw_answers().
// - While it is quiet, nothing is called out. Hazards, answers and notices are spoken.
class PromptQueue {
 public:
  explicit PromptQueue(const PromptQueueOptions& options = {}) : options_(options) {}

  // `is_asked_for`: somebody waits for it. A guide also speaks by itself, as urgently as it
  // answers.
  void add(Prompt prompt, TimestampNs now_ns, bool is_asked_for = true);
  // What to begin to speak now. Nothing while something is being spoken, unless it is broken off.
  [[nodiscard]] std::optional<Utterance> next(TimestampNs now_ns);
  // It has been spoken, to the end or not. Ignored where another one is being spoken by now.
  void finished(std::uint64_t id, TimestampNs now_ns);

  // Whether next() would break off what is being spoken.
  [[nodiscard]] bool interrupts(TimestampNs now_ns) const;
  // When next() may have something, if nothing is added or finished before; nothing: it will not.
  [[nodiscard]] std::optional<TimestampNs> next_at(TimestampNs now_ns) const;

  // Callouts that wait are forgotten.
  void set_quiet(bool quiet);
  [[nodiscard]] bool quiet() const { return is_quiet_; }
  // Forgets what waits with this key, and its parts.
  void withdraw(const std::string& key);
  // Forgets the answers that wait, since somebody asked anew. True where one is being spoken, which
  // counts as finished: the caller breaks it off.
  [[nodiscard]] bool withdraw_answers(TimestampNs now_ns);
  // How many answers that were asked for were past their time before they could be begun, since the
  // last call. Nobody heard of them, so the caller says that.
  [[nodiscard]] int take_expired_answers() { return std::exchange(expired_answers_, 0); }

  [[nodiscard]] const std::optional<Utterance>& speaking() const { return speaking_; }
  // The newest answer or callout that was begun, for somebody who did not catch it. Repetitions
  // themselves (key "repeat") do not count.
  [[nodiscard]] const std::optional<Said>& last_said() const { return last_said_; }

 private:
  struct Waiting {
    Prompt prompt;
    std::uint64_t place = 0;  // in the order of coming
    bool is_asked_for = false;
    bool was_begun = false;  // and broken off
  };
  [[nodiscard]] bool was_said_lately(const Prompt& prompt, TimestampNs now_ns) const;
  [[nodiscard]] bool breaks_off(const Waiting& waiting) const;
  [[nodiscard]] bool may_begin(const Waiting& waiting, TimestampNs now_ns) const;
  // The one to begin now; end() where there is none.
  [[nodiscard]] std::vector<Waiting>::const_iterator highest_priority(TimestampNs now_ns) const;
  void remember(const Prompt& prompt, TimestampNs now_ns);
  void forget_expired(TimestampNs now_ns);
  void break_off(const std::string& by_key, TimestampNs now_ns);

  PromptQueueOptions options_;
  std::vector<Waiting> waiting_;
  std::optional<Utterance> speaking_;
  std::optional<TimestampNs> silent_since_ns_;
  // When a key and text was begun last, as long as that matters.
  std::map<std::pair<std::string, std::string>, TimestampNs> said_at_ns_;
  std::optional<Said> last_said_;
  std::uint64_t places_ = 0;
  std::uint64_t utterances_ = 0;
  int expired_answers_ = 0;
  bool is_quiet_ = false;
};

}  // namespace roomwise::guide
