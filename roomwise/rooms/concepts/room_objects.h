#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace roomwise::rooms {

// A picture whose room is known, and the objects that the naming network sees in it.
struct NamedPicture {
  std::string room;
  std::set<std::string> objects;
};

// Somebody's word on whether an object tells that one is in a room. It counts more than pictures.
struct ObjectClaim {
  std::string object;
  std::string room;
  bool represents = true;

  friend bool operator==(const ObjectClaim&, const ObjectClaim&) = default;
};

// Has-a relations with weights, learned from a home's own pictures: how often the pictures of each
// room show each object, and which objects are representative, since one room alone shows them.
// They are counted by what the network says, right or wrong: a radiator that it always takes for a
// toilet represents its room all the same.
class RoomObjects {
 public:
  // An object is representative from so many pictures of its room on (the paper's four
  // observations), and where so much of what speaks for any room speaks for that one.
  static constexpr int kMinShown = 4;
  static constexpr double kMinShare = 0.8;

  RoomObjects() = default;
  // `rooms`: those that claims may be on, beside those of the pictures; claims on others say
  // nothing.
  explicit RoomObjects(std::span<const NamedPicture> pictures, std::vector<ObjectClaim> claims = {},
                       std::span<const std::string> rooms = {});

  struct Relation {
    std::string room;
    std::string object;
    int shown = 0;      // pictures of the room that show the object
    int pictures = 0;   // of the room
    double weight = 0;  // weight() of them
    double share = 0;   // of shares()
    bool is_representative = false;
    bool is_claimed = false;  // since somebody said so, or said that it is not
  };
  // Those that were seen or claimed, by room; the heaviest first.
  [[nodiscard]] std::vector<Relation> relations() const;

  // The probability that a picture of the room shows the object. Half a picture that does and half
  // a one that does not are counted in (Jeffreys' prior), so that few pictures prove little. 0 for
  // a room without pictures.
  [[nodiscard]] double weight(const std::string& room, const std::string& object) const;
  // How probable each room is where a picture shows the object, each room alike beforehand; they
  // add up to 1. A room that it represents, as somebody says, has 0.98 or more, and one that it
  // does not represent no more than an equal part. Empty for an object that no picture shows and
  // that nobody says to represent a room.
  [[nodiscard]] std::map<std::string, double> shares(const std::string& object) const;
  // The room that the object represents, if any.
  [[nodiscard]] std::optional<std::string> represented_room(const std::string& object) const;

 private:
  struct Room {
    int pictures = 0;
    std::map<std::string, int> shown;  // by object
  };
  [[nodiscard]] std::optional<bool> claimed(const std::string& room,
                                            const std::string& object) const;
  [[nodiscard]] int shown(const Room& room, const std::string& object) const;

  std::map<std::string, Room> rooms_;
  std::vector<ObjectClaim> claims_;
};

}  // namespace roomwise::rooms
