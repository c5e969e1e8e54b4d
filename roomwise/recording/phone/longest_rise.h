#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <type_traits>
#include <vector>

namespace roomwise::recording {

// Which of some values, in their order, belong to the longest run that strictly increases: of times
// of which some are damaged, one that is far off costs itself alone. Of two that are equal the
// first is taken.
template <typename Value>
[[nodiscard]] std::vector<bool> in_longest_increasing_subsequence(
    const std::vector<Value>& values) {
  std::vector<std::size_t> ends;  // of all runs of length 1, 2, ... the end of the lowest one
  std::vector<std::size_t> before(values.size());
  const auto value_of = [&](std::size_t i) { return values[i]; };
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto end = std::ranges::lower_bound(ends, values[i], {}, value_of);
    before[i] = end == ends.begin() ? i : *std::prev(end);
    if (end == ends.end()) {
      ends.push_back(i);
    } else if (values[i] < values[*end]) {
      *end = i;
    }
  }
  std::vector<bool> is_in(values.size());
  std::size_t at = ends.empty() ? 0 : ends.back();
  for (std::size_t left = ends.size(); left > 0; --left, at = before[at]) is_in[at] = true;
  return is_in;
}

// Takes out of a container of frames those whose `value_of` does not rise with the longest run of
// the others; `taken_out` is told of each before it goes.
template <typename Frames, typename ValueOf, typename TakenOut>
void keep_longest_rise(Frames& frames, const ValueOf& value_of, const TakenOut& taken_out) {
  std::vector<std::decay_t<decltype(value_of(*frames.begin()))>> values;
  for (const auto& frame : frames) values.push_back(value_of(frame));
  const std::vector<bool> is_in_order = in_longest_increasing_subsequence(values);
  std::size_t place = 0;
  std::erase_if(frames, [&](const auto& frame) {
    if (is_in_order[place++]) return false;
    taken_out(frame);
    return true;
  });
}

}  // namespace roomwise::recording
