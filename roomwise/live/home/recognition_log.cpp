#include "roomwise/live/home/recognition_log.h"

#include <algorithm>

namespace roomwise::live {

void RecognitionLog::add(const service::Identity& who, std::int64_t time_s,
                         const service::Seen& seen, const Bytes& picture) {
  const std::scoped_lock lock(mutex_);
  const std::string said = seen.room_decision + "/" + seen.room;
  if (std::exchange(last_[who.device], said) == said) return;
  entries_.push_back({next_++, who, time_s, seen, picture});
  if (entries_.size() > kMax) entries_.pop_front();
}

std::vector<Recognition> RecognitionLog::newest_first() const {
  const std::scoped_lock lock(mutex_);
  std::vector<Recognition> all;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    all.push_back({entry->number, entry->who, entry->time_s, entry->seen, {}});
  }
  return all;
}

std::optional<Bytes> RecognitionLog::picture(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  const auto entry = std::ranges::find(entries_, number, &Recognition::number);
  return entry != entries_.end() ? std::optional(entry->picture) : std::nullopt;
}

void RecognitionLog::clear() {
  const std::scoped_lock lock(mutex_);
  entries_.clear();
  last_.clear();
}

}  // namespace roomwise::live
