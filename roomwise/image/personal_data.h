#pragma once

namespace roomwise::image {

// What a recording or a picture says that is nobody's business: never what it is, only that it is
// there.
struct PersonalData {
  bool place = false;   // where it was taken
  bool device = false;  // the name, model or number of what took it
  bool owner = false;   // whose it is, or who took it

  [[nodiscard]] bool any() const { return place || device || owner; }
  PersonalData& operator|=(const PersonalData& other) {
    place = place || other.place;
    device = device || other.device;
    owner = owner || other.owner;
    return *this;
  }
  friend bool operator==(const PersonalData&, const PersonalData&) = default;
};

}  // namespace roomwise::image
