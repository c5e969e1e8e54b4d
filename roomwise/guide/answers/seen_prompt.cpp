#include "roomwise/guide/answers/seen_prompt.h"

#include <array>

namespace roomwise::guide {
namespace {

struct Seen {
  std::string message_id;
  Values values = {};
};

// What to say of when a thing was seen; absent where a clock is wrong: it was not seen yet.
std::optional<Seen> seen_on(const CalendarTime& time, const CalendarTime& today,
                            const Phrasebook& phrases) {
  constexpr int kNoon = 12, kEvening = 18, kWeek = 7;
  constexpr std::array kOnDay{"where.seen_sunday",    "where.seen_monday",   "where.seen_tuesday",
                              "where.seen_wednesday", "where.seen_thursday", "where.seen_friday",
                              "where.seen_saturday"};
  const int days = time.days_until(today);
  if (days < 0 || (days == 0 && time.hour > today.hour)) return std::nullopt;
  if (days == 1) return Seen{"where.seen_yesterday"};
  if (days == 0) {
    return Seen{time.hour < kNoon      ? "where.seen_morning"
                : time.hour < kEvening ? "where.seen_afternoon"
                                       : "where.seen_evening"};
  }
  if (days < kWeek) return Seen{kOnDay.at(static_cast<std::size_t>(time.weekday()))};
  Seen seen{time.year == today.year ? "where.seen_on" : "where.seen_on_year",
            {{"day", fmt::format("{}", time.day)}, {"month", phrases.month(time.month)}}};
  if (time.year != today.year) seen.values["year"] = fmt::format("{}", time.year);
  return seen;
}

}  // namespace

std::optional<Prompt> seen_prompt(std::string key, const std::optional<CalendarTime>& seen,
                                  const std::optional<CalendarTime>& today, const Wording& wording,
                                  TimestampNs now_ns, std::string because) {
  if (!seen || !today) return std::nullopt;
  const auto what = seen_on(*seen, *today, wording.phrases());
  if (!what) return std::nullopt;
  Prompt prompt = make_prompt(wording, std::move(key), what->message_id, what->values,
                              Confidence::kSure, after(now_ns, kHomeValid_s), std::move(because));
  prompt.sound = Sound::kNone;
  return prompt;
}

}  // namespace roomwise::guide
