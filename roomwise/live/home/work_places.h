#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <set>
#include <utility>

#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"

namespace roomwise::live {

// How long work is shared out: so many at once, each with so many threads. One processor is left to
// answers where there are two or more.
struct WorkShare {
  std::size_t places = 1;
  std::size_t threads = 1;
};
// `threads`: wanted for each.
[[nodiscard]] WorkShare share_of_work(std::size_t processors, std::size_t threads);

// Places for long work that the homes of one process share, so that all of them at once do not take
// the processors from the answers. Who waits for one is interruptible. Thread-safe.
class WorkPlaces {
 public:
  // What answers wait for comes before other work; of the same urgency who came first.
  enum class Urgency { kAnswersWait, kCanWait };

  explicit WorkPlaces(std::size_t places) : free_(places) {}

  // Free for others when it ends. `WorkPlaces` must outlive it.
  class Place {
   public:
    Place(Place&& other) noexcept : of_(std::exchange(other.of_, nullptr)) {}
    Place& operator=(Place&&) = delete;
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;
    ~Place();

   private:
    friend class WorkPlaces;
    explicit Place(WorkPlaces* of) : of_(of) {}
    WorkPlaces* of_;
  };

  // Waits for a place. Fails where the work is to stop.
  [[nodiscard]] Expected<Place> take(Urgency urgency, const Interruption& interruption);
  // How many wait for one.
  [[nodiscard]] std::size_t waiting() const;

 private:
  void give_back();

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t free_;
  std::size_t came_ = 0;
  std::set<std::pair<Urgency, std::size_t>> waiting_;  // in the order of their turns
};

}  // namespace roomwise::live
