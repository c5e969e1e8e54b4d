#pragma once

#include <optional>

#include "roomwise/base/timestamp.h"

namespace roomwise {

// A moment as people tell it, to the hour.
struct CalendarTime {
  int year = 0;
  int month = 0;  // 1 to 12
  int day = 0;    // 1 to 31
  int hour = 0;   // 0 to 23

  // From one day to another, counted at midnight; negative where `later` is not.
  [[nodiscard]] int days_until(const CalendarTime& later) const;
  [[nodiscard]] int hours_until(const CalendarTime& later) const {
    return 24 * days_until(later) + later.hour - hour;
  }
  [[nodiscard]] int weekday() const;  // 0 is Sunday, 6 Saturday

  friend bool operator==(const CalendarTime&, const CalendarTime&) = default;
};

// By the time zone of this computer. Absent where the stamp counts from something else than 1970,
// as clocks do that begin with a device or a recording: before 9 September 2001.
[[nodiscard]] std::optional<CalendarTime> calendar_time(TimestampNs timestamp_ns);

// Of the computer's clock, since 1970.
[[nodiscard]] TimestampNs unix_now_ns();

}  // namespace roomwise
