#include "roomwise/rooms/concepts/room_objects.h"

#include <algorithm>
#include <utility>

namespace roomwise::rooms {
namespace {

// What somebody says is nearly certain: they may be wrong, or the thing may have moved.
constexpr double kClaimedShare = 0.98;

// Some rooms' shares are set, all at once; the rest goes to the others as they share it among
// themselves, or in equal parts where they have none. With no others, all get equal parts.
void set_shares(const std::map<std::string, double>& set, std::map<std::string, double>& shares) {
  double rest_before = 0, rest = 1;
  for (const auto& [room, share] : shares) {
    const auto found = set.find(room);
    if (found == set.end()) {
      rest_before += share;
    } else {
      rest -= found->second;
    }
  }
  const auto others = static_cast<double>(shares.size() - set.size());
  for (auto& [room, share] : shares) {
    if (const auto found = set.find(room); found != set.end()) {
      share = others > 0 ? found->second : 1 / static_cast<double>(shares.size());
    } else {
      share = rest_before > 0 ? share / rest_before * rest : rest / others;
    }
  }
}

}  // namespace

RoomObjects::RoomObjects(std::span<const NamedPicture> pictures, std::vector<ObjectClaim> claims,
                         std::span<const std::string> rooms)
    : claims_(std::move(claims)) {
  for (const std::string& room : rooms) rooms_[room];
  for (const NamedPicture& picture : pictures) {
    Room& room = rooms_[picture.room];
    ++room.pictures;
    for (const std::string& object : picture.objects) ++room.shown[object];
  }
  std::erase_if(claims_, [&](const ObjectClaim& claim) { return !rooms_.contains(claim.room); });
}

std::optional<bool> RoomObjects::claimed(const std::string& room, const std::string& object) const {
  const auto claim = std::ranges::find_if(
      claims_, [&](const ObjectClaim& one) { return one.room == room && one.object == object; });
  return claim != claims_.end() ? std::optional(claim->represents) : std::nullopt;
}

int RoomObjects::shown(const Room& room, const std::string& object) const {
  const auto found = room.shown.find(object);
  return found != room.shown.end() ? found->second : 0;
}

double RoomObjects::weight(const std::string& room, const std::string& object) const {
  const auto found = rooms_.find(room);
  if (found == rooms_.end() || found->second.pictures == 0) return 0;
  return (shown(found->second, object) + 0.5) / (found->second.pictures + 1.0);
}

std::map<std::string, double> RoomObjects::shares(const std::string& object) const {
  std::map<std::string, double> shares;
  const bool is_shown =
      std::ranges::any_of(rooms_, [&](const auto& room) { return shown(room.second, object) > 0; });
  const auto claim = std::ranges::find_if(
      claims_, [&](const ObjectClaim& one) { return one.object == object && one.represents; });
  if (!is_shown && claim == claims_.end()) return shares;
  double sum = 0;
  for (const auto& [room, counts] : rooms_) sum += shares[room] = weight(room, object);
  if (sum > 0) {
    for (auto& [room, share] : shares) share /= sum;
  }
  if (shares.size() == 1) return {{shares.begin()->first, 1.0}};
  const double equal_part = 1 / static_cast<double>(shares.size());
  std::map<std::string, double> denied;
  for (const ObjectClaim& one : claims_) {
    if (one.object != object || one.represents) continue;
    denied[one.room] = std::min(shares.at(one.room), equal_part);
  }
  set_shares(denied, shares);
  if (claim != claims_.end() && shares.at(claim->room) < kClaimedShare) {
    set_shares({{claim->room, kClaimedShare}}, shares);
  }
  return shares;
}

std::optional<std::string> RoomObjects::represented_room(const std::string& object) const {
  const auto all = shares(object);
  const auto best = std::ranges::max_element(all, {}, [](const auto& one) { return one.second; });
  if (best == all.end()) return std::nullopt;
  const std::string& room = best->first;
  if (const auto said = claimed(room, object)) return *said ? std::optional(room) : std::nullopt;
  const bool is_reliable = best->second >= kMinShare && shown(rooms_.at(room), object) >= kMinShown;
  return is_reliable ? std::optional(room) : std::nullopt;
}

std::vector<RoomObjects::Relation> RoomObjects::relations() const {
  std::vector<Relation> relations;
  for (const auto& [room, counts] : rooms_) {
    std::set<std::string> objects;
    for (const auto& [object, count] : counts.shown) objects.insert(object);
    for (const ObjectClaim& claim : claims_) {
      if (claim.room == room) objects.insert(claim.object);
    }
    for (const std::string& object : objects) {
      relations.push_back({room, object, shown(counts, object), counts.pictures,
                           weight(room, object), shares(object)[room],
                           represented_room(object) == room, claimed(room, object).has_value()});
    }
  }
  std::ranges::stable_sort(relations, [](const Relation& a, const Relation& b) {
    return a.room != b.room ? a.room < b.room : a.weight > b.weight;
  });
  return relations;
}

}  // namespace roomwise::rooms
