#include "roomwise/base/stage_clock.h"

#include <ctime>

namespace roomwise {
namespace {

double read_clock_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double thread_cpu_time_s() {
  return read_clock_s(CLOCK_THREAD_CPUTIME_ID);
}
double process_cpu_time_s() {
  return read_clock_s(CLOCK_PROCESS_CPUTIME_ID);
}

StageClock::Measurement::Measurement(StageClock& clock, std::string name)
    : clock_(clock),
      name_(std::move(name)),
      wall_start_(std::chrono::steady_clock::now()),
      cpu_start_s_(thread_cpu_time_s()) {}

StageClock::Measurement::~Measurement() {
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start_;
  clock_.add(name_, wall.count(), thread_cpu_time_s() - cpu_start_s_);
}

void StageClock::add(const std::string& stage, double wall_s, double cpu_s) {
  const std::lock_guard lock(mutex_);
  Stage& entry = stages_[stage];
  ++entry.calls;
  entry.wall_s += wall_s;
  entry.cpu_s += cpu_s;
}

std::map<std::string, StageClock::Stage> StageClock::stages() const {
  const std::lock_guard lock(mutex_);
  return stages_;
}

}  // namespace roomwise
