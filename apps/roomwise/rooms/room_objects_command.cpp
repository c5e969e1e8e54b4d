// "rooms objects" and "rooms types": what stands in the rooms, and what that tells.

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "roomwise/pipeline/rooms/room_contents.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// ---- rooms objects ----

struct ObjectsOfRoomsOptions {
  fs::path home;
  std::vector<std::string> represents;      // "OBJECT=ROOM"
  std::vector<std::string> represents_not;  // likewise
  std::vector<std::string> unsay;           // likewise

  [[nodiscard]] bool edits() const {
    return !represents.empty() || !represents_not.empty() || !unsay.empty();
  }
};

// An object and a room that the home has.
Expected<rooms::ObjectClaim> parse_claim(const std::string& text, bool represents,
                                         const home::Home& home) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    return fail("'{}' is no object of a room; expected OBJECT=ROOM, for example microwave=kitchen",
                text);
  }
  rooms::ObjectClaim claim{text.substr(0, equals), text.substr(equals + 1), represents};
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (std::ranges::find(rooms, claim.room, &rooms::Room::name) == rooms.end()) {
    return fail("this home has no room '{}'; see roomwise info {}", claim.room, home.file());
  }
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  if (!concepts.vocabulary.objects().contains(claim.object)) {
    return fail("this home has no word '{}'; see roomwise concepts list --home {}", claim.object,
                home.file());
  }
  return claim;
}

Expected<void> edit_claims(home::Home& home, const ObjectsOfRoomsOptions& options) {
  ROOMWISE_TRY(auto claims, pipeline::object_claims(home));
  const auto forget = [&](const rooms::ObjectClaim& one) {
    return std::erase_if(claims, [&](const rooms::ObjectClaim& other) {
      return other.object == one.object && other.room == one.room;
    });
  };
  for (const std::string& text : options.unsay) {
    ROOMWISE_TRY(const rooms::ObjectClaim claim, parse_claim(text, true, home));
    if (forget(claim) == 0) return fail("nobody said anything of '{}'", text);
  }
  for (const auto& [texts, represents] :
       {std::pair(&options.represents, true), std::pair(&options.represents_not, false)}) {
    for (const std::string& text : *texts) {
      ROOMWISE_TRY(const rooms::ObjectClaim claim, parse_claim(text, represents, home));
      forget(claim);
      // It cannot tell that one is in two rooms.
      if (represents) {
        std::erase_if(claims, [&](const rooms::ObjectClaim& other) {
          return other.object == claim.object && other.represents;
        });
      }
      claims.push_back(claim);
    }
  }
  return pipeline::store_object_claims(home, claims);
}

Answer answer_of(const rooms::RoomObjects& objects) {
  Answer answer;
  answer.json["rooms"] = Json::object();
  std::string room;
  for (const rooms::RoomObjects::Relation& one : objects.relations()) {
    if (one.room != room) answer.text += fmt::format("{} ({} pictures)\n", one.room, one.pictures);
    room = one.room;
    answer.text += fmt::format("  {:<16} in {:3} pictures, weight {:.2f}; share {:.2f}{}{}\n",
                               one.object, one.shown, one.weight, one.share,
                               one.is_representative ? "; representative" : "",
                               one.is_claimed ? ", as was said" : "");
    answer.json["rooms"][one.room].push_back({{"object", one.object},
                                              {"shown", one.shown},
                                              {"pictures", one.pictures},
                                              {"weight", one.weight},
                                              {"share", one.share},
                                              {"representative", one.is_representative},
                                              {"said", one.is_claimed}});
  }
  if (answer.text.empty()) {
    answer.text =
        "No objects were seen in named rooms: name rooms (roomwise rooms name), and map with a "
        "network that names things.\n";
  }
  return answer;
}

Expected<Answer> objects_of_rooms(const ObjectsOfRoomsOptions& options, Context& context) {
  if (options.edits()) {
    ROOMWISE_TRY(home::Home home, open_home(options.home, context));
    ROOMWISE_RETURN_IF_ERROR(edit_claims(home, options));
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const rooms::RoomObjects objects, pipeline::room_objects(home));
  return answer_of(objects);
}

// ---- rooms types ----

struct TypesOptions {
  fs::path home;
  bool accept = false;
};

constexpr double kProbableEnough = 0.8;  // to be taken by --accept

Expected<Answer> types_of_rooms(const TypesOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, options.accept ? open_home(options.home, context)
                                               : open_home_read_only(options.home, context));
  CommandRun run(context);
  ROOMWISE_TRY(const auto layout, pipeline::find_home_layout(home, run));
  ROOMWISE_TRY(const auto guesses, pipeline::classify_room_types(home, layout));
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(auto rooms, home.rooms());
  Answer answer;
  answer.json["rooms"] = Json::array();
  for (rooms::Room& room : rooms) {
    const rooms::TypePosterior& best = guesses.at(room.name).front();
    const bool is_known = concepts.objects_of_room_type.contains(room.type);
    const bool is_guessed = best.type != rooms::kOtherType;
    const bool takes =
        options.accept && !is_known && is_guessed && best.probability >= kProbableEnough;
    answer.text += fmt::format("{} (type: {}): ", room.name, room.type);
    answer.text +=
        is_guessed ? fmt::format("its things say {} ({:.2f}): {}{}\n", best.type, best.probability,
                                 fmt::join(best.because, ", "), takes ? "; taken" : "")
                   : std::string("its things tell no type\n");
    Json json = {
        {"room", room.name}, {"type", room.type}, {"guesses", Json::array()}, {"taken", takes}};
    for (const rooms::TypePosterior& guess : guesses.at(room.name)) {
      json["guesses"].push_back(
          {{"type", guess.type == rooms::kOtherType ? Json(nullptr) : Json(guess.type)},
           {"probability", guess.probability},
           {"because", guess.because}});
    }
    answer.json["rooms"].push_back(std::move(json));
    if (takes) room.type = best.type;
  }
  if (options.accept) ROOMWISE_RETURN_IF_ERROR(home.replace_rooms(rooms));
  return answer;
}

}  // namespace

void add_room_objects_commands(CLI::App& group, Context& context) {
  {
    const auto [command, options] = add_command<ObjectsOfRoomsOptions>(
        group, context, "objects",
        "What the pictures of each room show, and which objects tell the room by themselves",
        "roomwise rooms objects --home my.home --represents piano=\"Anna's room\"",
        objects_of_rooms);
    command->add_option("--home", options.home, "Home file")->required();
    command->add_option("--represents", options.represents,
                        "OBJECT=ROOM: the object is in this room only, whatever the pictures show");
    command->add_option("--represents-not", options.represents_not,
                        "OBJECT=ROOM: the object says nothing about this room, for example because "
                        "people move it about");
    command->add_option("--unsay", options.unsay,
                        "OBJECT=ROOM: forget what was said; the pictures decide again");
  }
  {
    const auto [command, options] = add_command<TypesOptions>(
        group, context, "types", "Which type each room is by the things in it",
        "roomwise rooms types --home my.home --accept", types_of_rooms);
    command->add_option("--home", options.home, "Home file")->required();
    command->add_flag("--accept", options.accept,
                      "Take what is probable (0.8 or more) for rooms whose type the concepts do "
                      "not know");
  }
}

}  // namespace roomwise::app
