#include "roomwise/recording/association.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>

namespace roomwise::recording {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

// An entry of one of the two lists, in the list of both by time.
struct Event {
  TimestampNs timestamp_ns = 0;
  bool in_second = false;
  std::size_t index = 0;  // in its own list
  // The events before and after it that are not paired yet.
  std::size_t previous = kNone;
  std::size_t next = kNone;
  bool paired = false;
};

std::vector<Event> merge_by_time(std::span<const TimestampNs> first,
                                 std::span<const TimestampNs> second) {
  std::vector<Event> events;
  events.reserve(first.size() + second.size());
  for (std::size_t i = 0; i < first.size(); ++i) events.push_back({first[i], false, i});
  for (std::size_t i = 0; i < second.size(); ++i) events.push_back({second[i], true, i});
  std::inplace_merge(
      events.begin(), events.begin() + static_cast<std::ptrdiff_t>(first.size()), events.end(),
      [](const Event& a, const Event& b) { return a.timestamp_ns < b.timestamp_ns; });
  for (std::size_t i = 0; i < events.size(); ++i) {
    events[i].previous = i == 0 ? kNone : i - 1;
    events[i].next = i + 1 == events.size() ? kNone : i + 1;
  }
  return events;
}

// Two events, one of each list, that might be paired; the least is to be taken first.
struct Candidate {
  TimestampNs difference_ns;
  Association association;
  std::size_t earlier, later;  // events

  friend bool operator>(const Candidate& a, const Candidate& b) {
    const auto order = [](const Candidate& c) {
      return std::tuple(c.difference_ns, c.association.first, c.association.second);
    };
    return order(a) > order(b);
  }
};

}  // namespace

std::vector<Association> associate(std::span<const TimestampNs> first,
                                   std::span<const TimestampNs> second, TimestampNs tolerance_ns) {
  // The closest pair is always one of neighbours in time: an entry between the two would be closer
  // to one of them. So it is enough to look at neighbours, and at the new neighbours that appear
  // when a pair leaves.
  std::vector<Event> events = merge_by_time(first, second);
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> candidates;
  const auto consider = [&](std::size_t earlier, std::size_t later) {
    if (earlier == kNone || later == kNone) return;
    const Event& a = events[earlier];
    const Event& b = events[later];
    const TimestampNs difference_ns = b.timestamp_ns - a.timestamp_ns;
    if (a.in_second == b.in_second || difference_ns >= tolerance_ns) return;
    const Association association =
        a.in_second ? Association{b.index, a.index} : Association{a.index, b.index};
    candidates.push({difference_ns, association, earlier, later});
  };
  for (std::size_t i = 0; i + 1 < events.size(); ++i) consider(i, i + 1);

  std::vector<Association> associations;
  while (!candidates.empty()) {
    const Candidate closest = candidates.top();
    candidates.pop();
    Event& earlier = events[closest.earlier];
    Event& later = events[closest.later];
    if (earlier.paired || later.paired) continue;
    earlier.paired = later.paired = true;
    associations.push_back(closest.association);
    if (earlier.previous != kNone) events[earlier.previous].next = later.next;
    if (later.next != kNone) events[later.next].previous = earlier.previous;
    consider(earlier.previous, later.next);
  }
  std::ranges::sort(associations, {}, &Association::first);
  return associations;
}

}  // namespace roomwise::recording
