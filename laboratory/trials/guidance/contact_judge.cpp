#include "laboratory/trials/guidance/contact_judge.h"

#include <set>

#include "laboratory/trials/guidance/leader.h"

namespace roomwise::trials {

void ContactJudge::hear(const SimulatedWalker& walker, std::size_t prompt) {
  const bool asks = walker.times_told() > (told_.empty() ? 0 : told_.back().number);
  if (asks) told_.push_back({walker.times_told(), prompt, steps_, walker.without_faults()});
}

void ContactJudge::step(double now_s, const SimulatedWalker& walker) {
  while (told_.size() > 1 && told_[1].number <= walker.does()) {
    judge(told_.front());
    told_.pop_front();
  }
  ++steps_;
  while (contacts_.size() < walker.contacts().size()) {
    const Eigen::Vector2d& place = walker.contacts()[contacts_.size()];
    Contact& contact = contacts_.emplace_back(Contact{now_s, place, home_.nearest_thing(place)});
    if (!told_.empty() && told_.front().number <= walker.does()) {
      contact.prompt = told_.front().prompt;
    }
  }
}

void ContactJudge::judge(const Told& told) {
  if (judged_ == contacts_.size()) return;
  SimulatedWalker exact = told.exact;
  for (std::size_t i = told.steps; i < steps_; ++i) exact.step(kWalkerStep_s);
  std::set<std::string> touched;
  for (const Eigen::Vector2d& place : exact.contacts()) {
    touched.insert(home_.nearest_thing(place));
  }
  for (; judged_ < contacts_.size(); ++judged_) {
    Contact& contact = contacts_[judged_];
    contact.is_by_prompt = contact.prompt && touched.contains(contact.thing);
  }
}

std::vector<Contact> ContactJudge::finish() {
  if (!told_.empty()) judge(told_.front());
  return std::move(contacts_);
}

}  // namespace roomwise::trials
