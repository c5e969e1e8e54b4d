#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace roomwise {

// Time spent in the stages of a pipeline, summed over all threads. Thread-safe.
class StageClock {
 public:
  struct Stage {
    std::uint64_t calls = 0;
    double wall_s = 0;
    double cpu_s = 0;  // processor time of the thread that ran the stage
  };

  // Measures from its making to its end:  { const auto timing = clock.measure("features"); ... }
  class Measurement {
   public:
    Measurement(StageClock& clock, std::string name);
    ~Measurement();
    Measurement(const Measurement&) = delete;
    Measurement& operator=(const Measurement&) = delete;

   private:
    StageClock& clock_;
    std::string name_;
    std::chrono::steady_clock::time_point wall_start_;
    double cpu_start_s_;
  };

  [[nodiscard]] Measurement measure(std::string stage) {
    return Measurement(*this, std::move(stage));
  }
  void add(const std::string& stage, double wall_s, double cpu_s);
  // By name of stage.
  [[nodiscard]] std::map<std::string, Stage> stages() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, Stage> stages_;
};

// Processor time of the calling thread and of the whole process (all threads), seconds.
double thread_cpu_time_s();
double process_cpu_time_s();

}  // namespace roomwise
