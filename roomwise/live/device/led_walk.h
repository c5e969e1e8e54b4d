#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roomwise/guide/led/guidance.h"
#include "roomwise/guide/questions/dialogue.h"
#include "roomwise/live/device/answers.h"

namespace roomwise::live {

// Somebody who is led to a goal in a home. What the home knew when it began is kept; where the map
// is made anew, or the goal was moved, it begins again; it ends where there is no such goal any
// more.
class LedWalk {
 public:
  // Nothing where the home has no such goal, or nobody knows where: answer() says so then.
  // `before`: the walk on which somebody was led last, if they were; what they came upon then bars
  // the way for a while.
  [[nodiscard]] static std::unique_ptr<LedWalk> to(const service::Ask& goal,
                                                   const std::shared_ptr<const HomeView>& home,
                                                   const Situation& situation,
                                                   const LedWalk* before = nullptr);

  // The answer to who asked to be led: never nothing.
  [[nodiscard]] guide::Prompt begin(const Situation& situation);
  // After each picture that was looked at.
  [[nodiscard]] std::vector<guide::Prompt> after(const FrameResult& result,
                                                 const std::shared_ptr<const HomeView>& home);
  [[nodiscard]] guide::Prompt hear(service::GuideWish wish, double now_t_ms);
  [[nodiscard]] guide::Prompt repeat(double now_t_ms);
  // The way from where somebody stands then, whatever has been walked.
  [[nodiscard]] guide::Plan plan_from(const Situation& situation) const;
  // From now on.
  void speak_by(const service::SpeakingSettings& settings);
  [[nodiscard]] bool is_over() const { return guidance_->is_over(); }
  // Not paused, lost, by rooms or on stairs.
  [[nodiscard]] bool follows_way() const;
  [[nodiscard]] const guide::Noun& goal() const { return guidance_->goal().noun; }
  // The floor as it was found on the way; null where the home's map is another, or has none.
  [[nodiscard]] const fusion::FloorGrid* floor_on(const HomeView& home) const {
    return is_same_map(home) ? guidance_->floor().grid() : nullptr;
  }
  // By the picture that was looked at last, of that time (guide::Guidance).
  [[nodiscard]] std::optional<service::GoalBearing> goal_bearing(double taken_t_ms) const;
  // But for who is led and what was said.
  [[nodiscard]] service::WatchedWalk watched() const;
  // Of what is in the way (guide::Guidance).
  [[nodiscard]] bool judges_obstacles() const { return guidance_->judges_obstacles(now_ns_); }

 private:
  LedWalk(service::Ask asked, std::shared_ptr<const HomeView> home, guide::Goal goal,
          const Situation& situation, std::vector<guide::BarredPlace> barred);
  [[nodiscard]] std::vector<guide::Prompt> begin_anew(const FrameResult& result,
                                                      const std::shared_ptr<const HomeView>& home);
  [[nodiscard]] bool is_same_map(const HomeView& home) const;
  // What is asked for now, or one of it, stands where the way leads.
  [[nodiscard]] bool is_goal_there(const HomeView& home) const;
  [[nodiscard]] TimestampNs at(double t_ms);

  service::Ask asked_;
  service::SpeakingSettings asked_by_;                  // in this language the goal was named
  service::SpeakingSettings settings_;                  // in which is spoken
  std::optional<CalendarTime> today_;                   // when it was asked for
  std::shared_ptr<const HomeView> home_, newest_home_;  // when it began, and when it last looked
  std::vector<rooms::Doorway> doorways_;
  std::unique_ptr<guide::Guidance> guidance_;
  TimestampNs now_ns_ = 0;  // never goes back, as pictures and questions may
};

// Where each of the choices lies from where somebody stands; nothing of one to which no whole way
// is known, or that is on another storey. Empty where their place is not sure.
[[nodiscard]] std::vector<std::optional<guide::ChoicePlace>> places_of(
    std::span<const guide::Understood> choices, const service::Ask& in_words, const HomeView& home,
    const guide::UserLocation& location, const service::SpeakingSettings& settings,
    const std::optional<CalendarTime>& today);

}  // namespace roomwise::live
