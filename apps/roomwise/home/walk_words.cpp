#include "home/walk_words.h"

#include "roomwise/base/calendar_time.h"
#include "roomwise/guide/words/message_catalogue.h"

namespace roomwise::app {

Expected<WalkWords> WalkWords::of(const home::Home& home) {
  WalkWords words;
  ROOMWISE_TRY(const auto recordings, home.recordings());
  std::map<std::string, int> count;
  for (const home::StoredRecording& one : recordings) ++count[one.recording.name];
  std::size_t number = 0;
  for (const home::StoredRecording& one : recordings) {
    ++number;
    const std::string& name = one.recording.name;
    words.names_[one.id] = count[name] > 1 ? fmt::format("{} (#{})", name, number) : name;
  }
  const guide::MessageCatalogue catalogue = guide::MessageCatalogue::built_in();
  for (int month = 1; month <= 12; ++month)
    words.months_.push_back(catalogue.in("en").month(month));
  return words;
}

std::optional<std::string> WalkWords::date(TimestampNs timestamp_ns) const {
  const auto time = calendar_time(timestamp_ns);
  if (!time) return std::nullopt;
  return fmt::format("{} {} {} at {} o'clock", time->day,
                     months_.at(static_cast<std::size_t>(time->month - 1)), time->year, time->hour);
}

Json date_json(TimestampNs timestamp_ns) {
  const auto time = calendar_time(timestamp_ns);
  if (!time) return nullptr;
  return fmt::format("{:04}-{:02}-{:02}T{:02}", time->year, time->month, time->day, time->hour);
}

}  // namespace roomwise::app
