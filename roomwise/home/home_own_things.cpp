// The part of Home that stores things that people taught.

#include "roomwise/base/name.h"
#include "roomwise/home/home.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

// A device's number alone. It used to be kept with its name, which changes.
std::string owner_number(std::string owner) {
  const std::size_t digits = owner.find_first_not_of("0123456789");
  if (digits != 0 && digits != std::string::npos && owner[digits] == ' ') owner.resize(digits);
  return owner;
}

OwnThingSighting sighting_columns(const Statement& row, int first) {
  OwnThingSighting sighting{row.column<std::optional<std::int64_t>>(first),
                            row.column<std::optional<std::string>>(first + 1),
                            row.column<std::optional<KeyframeId>>(first + 2), std::nullopt};
  if (sighting.keyframe && row.column<std::optional<double>>(first + 3)) {
    const auto [x, y, z] = row.columns<3>(first + 3);
    sighting.middle_keyframe = Eigen::Vector3d(x, y, z);
  }
  return sighting;
}

}  // namespace

Expected<bool> Home::has_own_things() const {
  return has_table(database_, "own_thing_views");  // both come at once
}

Expected<void> Home::check_new_name(const std::string& name) const {
  if (name.find_first_not_of(' ') == std::string::npos) {
    return fail_with(ErrorCode::kRefused, "a thing needs a name");
  }
  if (name.size() > kMaxOwnThingName) {
    return fail_with(ErrorCode::kRefused, "the name is {} bytes long; {} at most", name.size(),
                     kMaxOwnThingName);
  }
  if (!is_name(name)) {
    return fail_with(ErrorCode::kRefused,
                     "a name is one line of text in UTF-8, with a letter or digit");
  }
  ROOMWISE_TRY(const bool has, has_own_things());
  if (!has) return {};
  ROOMWISE_TRY(const bool is_taken,
               database_.get<bool>(
                   "SELECT count(*) > 0 FROM own_things WHERE name = ? COLLATE NOCASE", name));
  if (is_taken) {
    // Not as it is kept: it may be another's, who tells nobody of it.
    return fail_with(ErrorCode::kRefused,
                     "there is a thing called {} already; give another name, or forget that one",
                     name);
  }
  ROOMWISE_TRY(const auto count, database_.get<std::size_t>("SELECT count(*) FROM own_things"));
  if (count >= kMaxOwnThings) {
    return fail("{} things are known already, as many as are looked for; forget one", count);
  }
  return {};
}

Expected<OwnThingId> Home::add_own_thing(const OwnThing& thing,
                                         std::span<const objects::TaughtView> views) {
  ROOMWISE_RETURN_IF_ERROR(check_new_name(thing.name));
  if (views.empty()) return fail("{}: {} was not shown", file(), thing.name);
  OwnThingId id = 0;
  ROOMWISE_RETURN_IF_ERROR(atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(id, database_.insert("own_things (name, owner, is_shared, taught_s)", thing.name,
                                      thing.owner, thing.is_shared, thing.taught_s));
    for (const objects::TaughtView& view : views) {
      // Sealed pictures are bound to their number, so that is needed first.
      ROOMWISE_TRY(
          const auto view_id,
          database_.insert("own_thing_views (own_thing_id, picture, mask)", id, Bytes(), Bytes()));
      const auto number = static_cast<KeyframeId>(view_id);
      ROOMWISE_TRY(const Bytes picture,
                   encrypt_if_protected(number, PictureKind::kOwnThing, view.picture));
      ROOMWISE_TRY(const Bytes mask,
                   encrypt_if_protected(number, PictureKind::kOwnThingMask, view.mask));
      ROOMWISE_RETURN_IF_ERROR(
          database_.run("UPDATE own_thing_views SET picture = ?, mask = ? WHERE view_id = ?",
                        picture, mask, view_id));
    }
    return put_own_thing_sighting(id, thing.last_seen);
  }));
  return id;
}

Expected<std::vector<OwnThing>> Home::own_things() const {
  ROOMWISE_TRY(const bool has, has_own_things());
  if (!has) return std::vector<OwnThing>();
  return collect<std::vector<OwnThing>>(
      database_,
      "SELECT own_thing_id, name, owner, is_shared, taught_s, seen_s, seen_room, keyframe_id, x_m, "
      "y_m, z_m FROM own_things ORDER BY name",
      [](const Statement& row) {
        return OwnThing{row.column<OwnThingId>(0),
                        row.column<std::string>(1),
                        owner_number(row.column<std::string>(2)),
                        row.column<bool>(3),
                        row.column<std::int64_t>(4),
                        sighting_columns(row, 5)};
      });
}

Expected<std::vector<objects::TaughtView>> Home::own_thing_views(OwnThingId id) const {
  ROOMWISE_TRY(const bool has, has_own_things());
  if (!has) return fail("{}: has no thing {}", file(), id);
  return collect<std::vector<objects::TaughtView>>(
      database_,
      "SELECT view_id, picture, mask FROM own_thing_views WHERE own_thing_id = ? ORDER BY view_id",
      [this](const Statement& row) -> Expected<objects::TaughtView> {
        const auto number = row.column<KeyframeId>(0);
        objects::TaughtView view;
        ROOMWISE_TRY(view.picture,
                     decrypt_if_sealed(number, PictureKind::kOwnThing, row.column<Bytes>(1)));
        ROOMWISE_TRY(view.mask,
                     decrypt_if_sealed(number, PictureKind::kOwnThingMask, row.column<Bytes>(2)));
        return view;
      },
      id);
}

Expected<void> Home::change_own_thing(OwnThingId id,
                                      const std::function<Expected<void>()>& change) {
  ROOMWISE_TRY(const auto count,
               database_.get<int>("SELECT count(*) FROM own_things WHERE own_thing_id = ?", id));
  if (count == 0) return fail("{}: has no thing {}; it was forgotten", file(), id);
  return change();
}

Expected<void> Home::share_own_thing(OwnThingId id, bool is_shared) {
  return change_own_thing(id, [&] {
    return database_.run("UPDATE own_things SET is_shared = ? WHERE own_thing_id = ?", is_shared,
                         id);
  });
}

Expected<void> Home::put_own_thing_sighting(OwnThingId id, const OwnThingSighting& sighting) {
  return change_own_thing(id, [&] {
    std::optional<std::array<double, 3>> middle;
    if (sighting.keyframe && sighting.middle_keyframe) {
      const Eigen::Vector3d& at = *sighting.middle_keyframe;
      middle = {at.x(), at.y(), at.z()};
    }
    return database_.run(
        "UPDATE own_things SET seen_s = ?, seen_room = ?, keyframe_id = ?, x_m = ?, y_m = ?, "
        "z_m = ? WHERE own_thing_id = ?",
        sighting.seen_s, sighting.room, sighting.keyframe, middle, id);
  });
}

Expected<void> Home::remove_own_thing(OwnThingId id) {
  return change_own_thing(id, [&] {
    return atomically([&]() -> Expected<void> {
      ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM own_things WHERE own_thing_id = ?", id));
      ROOMWISE_RETURN_IF_ERROR(owe_erasing());
      // What was worked out from its views is of it, too.
      return database_.run("DELETE FROM derived_data WHERE name = 'own_things'");
    });
  });
}

}  // namespace roomwise::home
