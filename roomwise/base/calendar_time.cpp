#include "roomwise/base/calendar_time.h"

#include <chrono>
#include <ctime>

namespace roomwise {
namespace {

std::chrono::sys_days day_of(const CalendarTime& time) {
  return std::chrono::year(time.year) / std::chrono::month(static_cast<unsigned>(time.month)) /
         std::chrono::day(static_cast<unsigned>(time.day));
}

}  // namespace

int CalendarTime::days_until(const CalendarTime& later) const {
  return static_cast<int>((day_of(later) - day_of(*this)).count());
}

int CalendarTime::weekday() const {
  return static_cast<int>(std::chrono::weekday(day_of(*this)).c_encoding());
}

std::optional<CalendarTime> calendar_time(TimestampNs timestamp_ns) {
  constexpr TimestampNs kNsPerSecond = 1'000'000'000;
  constexpr TimestampNs kFirst_s = 1'000'000'000;
  const TimestampNs seconds = timestamp_ns / kNsPerSecond;
  if (seconds < kFirst_s) return std::nullopt;
  const std::time_t time = seconds;
  std::tm local{};
  if (localtime_r(&time, &local) == nullptr) return std::nullopt;
  return CalendarTime{local.tm_year + 1900, local.tm_mon + 1, local.tm_mday, local.tm_hour};
}

TimestampNs unix_now_ns() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

}  // namespace roomwise
