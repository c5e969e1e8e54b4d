#include "roomwise/pipeline/objects/home_things.h"

#include <algorithm>
#include <tuple>

#include "roomwise/objects/changes/changes.h"
#include "roomwise/pipeline/objects/thing_history.h"

namespace roomwise::pipeline {
namespace {

using objects::PlacedInstance;

// What keeps a change's place and a thing's apart from those of other components, which have worlds
// of their own.
constexpr std::uint64_t kApart = std::numeric_limits<std::uint64_t>::max();

bool is_same_box(const network::PixelBox& a, const network::PixelBox& b) {
  return a.left == b.left && a.top == b.top && a.right == b.right && a.bottom == b.bottom;
}

// What people changed, laid over what programs found.
class Overlay {
 public:
  Overlay(const home::Home& home, std::vector<home::Keyframe> keyframes)
      : home_(home), keyframes_(std::move(keyframes)) {}

  void add_found(objects::Instance instance) {
    Work& work = works_.emplace_back();
    static_cast<objects::Instance&>(work.thing) = std::move(instance);
    work.thing.found_as = work.thing.name;
  }

  Expected<void> apply(const StoredEdit& edit) {
    if (edit.kind == EditKind::kAddThing) {
      add(edit);
      return {};
    }
    if (edit.places.empty()) return lose(edit, "it says of nothing where it is");
    ROOMWISE_TRY(const auto at, find(edit, edit.places[0], edit.change.thing));
    if (!at) return {};
    note_about(edit, *at);
    HomeThing& thing = works_[*at].thing;
    // Who notes, moves or merges it calls it so, too, whatever programs call it later.
    confirm(thing, edit.kind == EditKind::kRenameThing ? edit.change.name : edit.change.old_name);
    switch (edit.kind) {
      case EditKind::kRenameThing:
        break;
      case EditKind::kNote:
        thing.note = edit.change.note;
        break;
      case EditKind::kMoveThing:
        return move(edit, *at);
      case EditKind::kMergeThings:
        return merge(edit, *at);
      default:
        works_[*at].is_there = false;
        break;
    }
    return {};
  }

  [[nodiscard]] HomeThings take() && {
    for (Work& work : works_) {
      if (work.is_there) things_.things.push_back(std::move(work.thing));
    }
    return std::move(things_);
  }

 private:
  struct Work {
    HomeThing thing;
    bool is_there = true;
  };

  // Somebody says so who was there.
  static void confirm(HomeThing& thing, const std::string& name) {
    thing.name = name;
    thing.names = {{name, 1.0}};
    thing.probability = 1;
    thing.is_confirmed = true;
  }

  [[nodiscard]] std::uint64_t component_of(home::KeyframeId keyframe) const {
    return keyframe < keyframes_.size() ? keyframes_[keyframe].pose.component : kApart;
  }
  [[nodiscard]] PlacedInstance placed(const objects::Instance& one, std::string name) const {
    return {
        std::move(name), one.box_world(keyframes_[one.keyframe_id].pose.world_from_keyframe), {}};
  }

  void note_about(const StoredEdit& edit, std::size_t at) {
    things_.things_of_edit[edit.id].insert(at);
  }
  Expected<void> lose(const StoredEdit& edit, std::string why) {
    things_.without_effect[edit.id] = std::move(why);
    return {};
  }

  void add(const StoredEdit& edit) {
    const auto box = edit.places.empty() ? std::nullopt : box_world(edit.places[0], keyframes_);
    if (!box) {
      things_.without_effect[edit.id] = "the walk by which its place was known was forgotten";
      return;
    }
    const home::EditPlace& place = edit.places[0];
    // Programs found it, too.
    const auto found =
        nearest({edit.change.name, *box, {}}, component_of(*place.keyframe), /*by_name=*/true);
    Work& work = found ? works_[*found] : works_.emplace_back();
    const std::size_t at = found.value_or(works_.size() - 1);
    added_[edit.id] = at;
    note_about(edit, at);
    work.is_there = true;  // also where somebody took it out before
    HomeThing& thing = work.thing;
    if (!found) {
      thing.keyframe_id = *place.keyframe;
      thing.box_keyframe = place.box_keyframe;
      thing.added_by_edit = edit.id;
      if (!edit.change.room.empty()) thing.room = edit.change.room;
    }
    if (!edit.change.note.empty()) thing.note = edit.change.note;
    confirm(thing, edit.change.name);
  }

  Expected<void> move(const StoredEdit& edit, std::size_t at) {
    HomeThing& thing = works_[at].thing;
    const auto box = edit.places.size() < 2 ? std::nullopt : box_world(edit.places[1], keyframes_);
    if (!box) return lose(edit, "the walk by which its new place was known was forgotten");
    if (component_of(*edit.places[1].keyframe) != component_of(thing.keyframe_id)) {
      return lose(edit, "its place and the thing lie on parts of the map that are not joined");
    }
    const geometry::RigidTransform keyframe_from_world =
        keyframes_[thing.keyframe_id].pose.world_from_keyframe.inverse();
    // What programs find there by its name is the thing itself, seen in its new place.
    std::optional<std::size_t> seen;
    for (const std::string& name : {thing.found_as, thing.name}) {
      if (!seen) seen = nearest({name, *box, {}}, component_of(thing.keyframe_id), true, at);
    }
    const geometry::OrientedBox stands = seen ? placed(works_[*seen].thing, {}).box_world : *box;
    if (seen) works_[*seen].is_there = false;
    thing.box_keyframe = {keyframe_from_world * stands.world_from_box, stands.size_m};
    thing.room.reset();
    if (!edit.change.room.empty()) thing.room = edit.change.room;
    return {};
  }

  Expected<void> merge(const StoredEdit& edit, std::size_t at) {
    if (edit.places.size() < 2) return lose(edit, "its second thing is missing");
    ROOMWISE_TRY(const auto other, find(edit, edit.places[1], edit.change.double_of));
    if (!other || *other == at) return {};  // the walks made one thing of them meanwhile
    note_about(edit, *other);
    works_[*other].is_there = false;
    if (works_[at].thing.note.empty()) works_[at].thing.note = works_[*other].thing.note;
    return {};
  }

  // The thing that a change is about; where there is none, why.
  Expected<std::optional<std::size_t>> find(const StoredEdit& edit, const home::EditPlace& place,
                                            const std::optional<home::EditId>& added) {
    std::optional<std::size_t> none;
    if (added) {
      const auto one = added_.find(*added);
      if (one != added_.end()) return std::optional(one->second);
      things_.without_effect[edit.id] = "what was added by hand is without a place";
      return none;
    }
    for (std::size_t i = 0; i < works_.size(); ++i) {
      const HomeThing& one = works_[i].thing;
      if (one.added_by_edit == 0 && place.keyframe == one.keyframe_id && one.visit == 0 &&
          !is_same_box(place.picture_box, {}) && is_same_box(place.picture_box, one.picture_box)) {
        return std::optional(i);
      }
    }
    const auto box = box_world(place, keyframes_);
    if (!box) {
      things_.without_effect[edit.id] = "the walk by which its place was known was forgotten";
      return none;
    }
    const std::uint64_t component = component_of(*place.keyframe);
    ROOMWISE_TRY(Later moved, by_walks(place, *box));
    if (!moved.at) {
      ROOMWISE_TRY(const Later visited, by_visits(place, *box));
      moved.at = visited.at;
      moved.gone.insert(moved.gone.end(), visited.gone.begin(), visited.gone.end());
    }
    if (moved.at) return moved.at;
    if (const auto there = nearest({place.name, *box, {}}, component, true)) return there;
    if (edit.kind != EditKind::kRemoveThing && moved.gone.empty()) {
      if (const auto there = nearest({place.name, *box, {}}, component, false)) return there;
    }
    things_.without_effect[edit.id] =
        moved.gone.empty() ? "nothing is found in its place" : "the walks found it gone";
    for (const objects::Instance& one : moved.gone) call_gone(one, edit);
    return none;
  }

  void call_gone(const objects::Instance& one, const StoredEdit& edit) {
    std::string name = edit.change.old_name;
    if (edit.kind == EditKind::kRenameThing) name = edit.change.name;
    if (edit.kind == EditKind::kRemoveThing) name.clear();
    things_.gone.push_back({one, std::move(name)});
  }

  // Of what programs found and stands in that place the nearest, `but` one; `by_name`: of those
  // that they call so.
  [[nodiscard]] std::optional<std::size_t> nearest(
      const PlacedInstance& place, std::uint64_t component, bool by_name,
      const std::optional<std::size_t>& but = std::nullopt) const {
    std::vector<std::size_t> at;
    std::vector<PlacedInstance> standing;
    for (std::size_t i = 0; i < works_.size(); ++i) {
      const HomeThing& one = works_[i].thing;
      if (but == i || one.added_by_edit != 0 || component_of(one.keyframe_id) != component)
        continue;
      if (!works_[i].is_there && !by_name) continue;
      at.push_back(i);
      standing.push_back(placed(one, by_name ? one.found_as : place.name));
    }
    const auto match = objects::match_by_name_and_place(std::span(&place, 1), standing).front();
    return match ? std::optional(at[*match]) : std::nullopt;
  }

  // What became of what stood in a place.
  struct Later {
    std::optional<std::size_t> at;        // where it is now
    std::vector<objects::Instance> gone;  // what it was that stands there no more
  };

  // Whether programs found it where a change was made, called as then.
  [[nodiscard]] bool stood_there(const objects::Instance& one, const home::EditPlace& place,
                                 const geometry::OrientedBox& box) const {
    if (one.name != place.name || component_of(one.keyframe_id) != component_of(*place.keyframe)) {
      return false;
    }
    const PlacedInstance asked{place.name, box, {}}, stood = placed(one, one.name);
    return objects::match_by_name_and_place(std::span(&asked, 1), std::span(&stood, 1))
        .front()
        .has_value();
  }

  // Where the walks say that what stood there is now.
  Expected<Later> by_walks(const home::EditPlace& place, const geometry::OrientedBox& box) {
    if (!history_) {
      ROOMWISE_TRY(history_, home_history_as_found(home_));
    }
    Later told;
    for (const ThingHistory& one : history_->things) {
      const bool has_moved = std::ranges::any_of(one.events, [&](const WalkEvent& event) {
        return event.from && stood_there(*event.from, place, box);
      });
      const bool was_there = has_moved || (one.is_gone && stood_there(one.thing, place, box));
      if (!was_there) continue;
      if (one.is_gone) told.gone.push_back(one.thing);
      for (std::size_t i = 0; i < works_.size() && !one.is_gone; ++i) {
        if (history_->of(works_[i].thing) == &one) told.at = i;
      }
      if (told.at) return told;
    }
    return told;
  }

  // The same of visits, one after the other: what one brought the next may have moved.
  Expected<Later> by_visits(const home::EditPlace& place, const geometry::OrientedBox& box) {
    if (!past_) {
      ROOMWISE_TRY(past_, home_.past_instances());
    }
    Later told;
    for (const home::PastInstance& one : *past_) {
      if (!stood_there(one.instance, place, box)) continue;
      const home::PastInstance* left = &one;
      while (left != nullptr && left->reason == home::PastReason::kMoved) {
        const Arrival arrival = arrival_of(*left);
        if (arrival.now) return Later{arrival.now, std::move(told.gone)};
        left = arrival.past;
      }
      if (left != nullptr) told.gone.push_back(left->instance);
    }
    return told;
  }

  // What a visit brought: a thing of now, or one that a later visit found moved or gone.
  struct Arrival {
    std::optional<std::size_t> now;
    const home::PastInstance* past = nullptr;
  };
  // Of what the visit that found it moved brought of its name: of several the nearest pairs are
  // one, as objects::find_changes() has it.
  [[nodiscard]] Arrival arrival_of(const home::PastInstance& moved) const {
    const auto is_alike = [&](const objects::Instance& one, const std::string& name) {
      return name == moved.instance.name &&
             component_of(one.keyframe_id) == component_of(moved.instance.keyframe_id);
    };
    std::vector<const objects::Instance*> left, brought;
    std::vector<Arrival> arrivals;
    for (std::size_t i = 0; i < works_.size(); ++i) {
      const HomeThing& one = works_[i].thing;
      if (one.visit != moved.noticed_by || !is_alike(one, one.found_as)) continue;
      brought.push_back(&one);
      arrivals.push_back({i, nullptr});
    }
    for (const home::PastInstance& one : *past_) {
      if (!is_alike(one.instance, one.instance.name)) continue;
      if (one.instance.visit == moved.noticed_by) {
        brought.push_back(&one.instance);
        arrivals.push_back({std::nullopt, &one});
      }
      if (one.noticed_by == moved.noticed_by && one.reason == home::PastReason::kMoved) {
        left.push_back(&one.instance);
      }
    }
    std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
    for (std::size_t l = 0; l < left.size(); ++l) {
      for (std::size_t b = 0; b < brought.size(); ++b) {
        pairs.emplace_back((middle(*left[l]) - middle(*brought[b])).norm(), l, b);
      }
    }
    std::ranges::sort(pairs);
    std::set<std::size_t> paired, taken;
    for (const auto& [distance_m, l, b] : pairs) {
      if (paired.contains(l) || !taken.insert(b).second) continue;
      if (left[l] == &moved.instance) return arrivals[b];
      paired.insert(l);
    }
    return {};
  }
  [[nodiscard]] Eigen::Vector3d middle(const objects::Instance& one) const {
    return placed(one, {}).box_world.center();
  }

  const home::Home& home_;
  std::vector<home::Keyframe> keyframes_;  // by id
  std::vector<Work> works_;
  std::map<home::EditId, std::size_t> added_;
  std::optional<HomeHistory> history_;
  std::optional<std::vector<home::PastInstance>> past_;
  HomeThings things_;
};

}  // namespace

std::optional<std::string> HomeThings::name_of_gone(const objects::Instance& one) const {
  std::optional<std::string> name = one.name;
  for (const GoneThing& said : gone) {
    const bool is_it = said.found.name == one.name && said.found.visit == one.visit &&
                       said.found.keyframe_id == one.keyframe_id &&
                       is_same_box(said.found.picture_box, one.picture_box);
    if (!is_it) continue;
    name = said.name.empty() ? std::nullopt : std::optional(said.name);
  }
  return name;
}

Expected<HomeThings> find_home_things(const home::Home& home) {
  ROOMWISE_TRY(auto instances, home.instances());
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  Overlay overlay(home, std::move(keyframes));
  for (objects::Instance& one : instances) overlay.add_found(std::move(one));
  ROOMWISE_TRY(const auto rooms, home.rooms());
  for (std::size_t i = 0; i < edits.size(); ++i) {
    StoredEdit edit = edits[i];
    if (!is_of_thing(edit.kind)) continue;
    // Its room may be called otherwise now, be part of another, or be none any more.
    apply_later_room_names(std::span(edits).subspan(i + 1), edit.change);
    const auto room = std::ranges::find(rooms, edit.change.room, &rooms::Room::name);
    if (room == rooms.end()) edit.change.room.clear();
    ROOMWISE_RETURN_IF_ERROR(overlay.apply(edit));
  }
  return std::move(overlay).take();
}

}  // namespace roomwise::pipeline
