#include "roomwise/pipeline/stored/lost_pictures.h"

#include <fmt/format.h>

#include <string>
#include <utility>

namespace roomwise::pipeline {

Expected<void> LostPictures::note(home::KeyframeId id, const Error& why) {
  if (!leave_out_) {
    is_stopped_ = true;
    return Unexpected(why);
  }
  const bool is_new = [&] {
    const std::scoped_lock lock(mutex_);
    return lost_.emplace(id, why.message).second;
  }();
  if (is_new) tell_(why);
  return {};
}

std::map<home::KeyframeId, std::string> LostPictures::all() const {
  const std::scoped_lock lock(mutex_);
  return lost_;
}

Expected<void> go_on_without(const home::Home& home, home::KeyframeId id, Error why,
                             const std::shared_ptr<LostPictures>& lost) {
  const bool is_of_all = home.is_locked() || why.code == ErrorCode::kInterrupted;
  if (is_of_all) return Unexpected(std::move(why));
  const std::string file = home.file() + ": ";
  if (why.message.starts_with(file)) why.message.erase(0, file.size());  // it is named but once
  Error named = std::move(why).with_context(fmt::format("{}key-frame {}", file, id));
  if (lost == nullptr) return Unexpected(std::move(named));
  return lost->note(id, named);
}

}  // namespace roomwise::pipeline
