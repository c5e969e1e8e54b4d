#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "home/command_line_author.h"
#include "open_home.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/live/recording/room_photos.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/edits/thing_target.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/rooms/home_layout.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// Of all changes; each takes what it needs.
struct EditOptions {
  fs::path home;
  std::string what, other;  // the thing or room, and the second one, the new name or the note
  std::vector<double> at_m;
  std::optional<double> height_m;
  std::string room, note;
  std::vector<double> line_m, outline_m;
  std::optional<home::EditId> change;  // absent: the newest
};

// The photos of rooms lie beside the home, as serve keeps them.
live::RoomPhotos photos_of(const EditOptions& options) {
  return live::RoomPhotos(options.home.string() + ".photos");
}

// The thing of that name, or with "#2" the second that objects list lists.
Expected<pipeline::HomeThing> find_thing(const home::Home& home, const std::string& text) {
  ROOMWISE_TRY(const pipeline::HomeThings things, pipeline::find_home_things(home));
  const auto named = [&](const std::string& name) {
    std::vector<const pipeline::HomeThing*> found;
    for (const pipeline::HomeThing& one : things.things) {
      if (one.name == name) found.push_back(&one);
    }
    return found;
  };
  const auto all = named(text);
  if (all.size() == 1) return *all.front();
  if (all.size() > 1) {
    return fail(
        "{}: has {} things called {}; say which: {}#1 to {}#{}, as roomwise objects list "
        "lists them",
        home.file(), all.size(), text, text, text, all.size());
  }
  const std::size_t sign = text.rfind('#');
  std::size_t number = 0;
  if (sign != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + sign + 1, end, number);
    const auto of_name = named(text.substr(0, sign));
    if (read.ptr == end && number >= 1 && number <= of_name.size()) return *of_name[number - 1];
  }
  return fail("{}: has no thing called {}; see what there is: roomwise objects list --home {}",
              home.file(), text, shell_word(home.file()));
}

Expected<pipeline::ThingTarget> find_target(const home::Home& home, const EditOptions& options,
                                            const std::string& name,
                                            const pipeline::HomeThing* before, Context& context) {
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::HomeFloor floor, pipeline::find_home_floor(home, run));
  std::optional<rooms::RoomLayout> layout;
  if (floor.grid) {
    ROOMWISE_TRY(layout, pipeline::find_room_layout(home, floor.frame, *floor.grid));
  }
  pipeline::SaidPlace where{.height_m = options.height_m, .room = options.room};
  if (!options.at_m.empty()) where.point_plan = {options.at_m[0], options.at_m[1]};
  return pipeline::target_of(home, floor.frame, layout ? &*layout : nullptr, where, name, before);
}

Expected<pipeline::HomeFloor> find_floor(const home::Home& home, Context& context) {
  CommandRun run(context);
  return pipeline::find_home_floor(home, run);
}

pipeline::FloorLine line_of(const EditOptions& options) {
  const auto& n = options.line_m;
  return {{n[0], n[1]}, {n[2], n[3]}};
}

// ---- the changes ----

using Made = Expected<home::EditId>;

Made add_thing(home::Home& home, const EditOptions& options, Context& context) {
  ROOMWISE_TRY(const auto where, find_target(home, options, options.what, nullptr, context));
  return pipeline::add_thing(home, command_line_author(), options.what, where, options.note);
}

Made add_way_out(home::Home& home, const EditOptions& options, Context& context) {
  EditOptions way_out = options;
  way_out.what = "way out";
  return add_thing(home, way_out, context);
}

Made rename_thing(home::Home& home, const EditOptions& options, Context&) {
  ROOMWISE_TRY(const auto thing, find_thing(home, options.what));
  return pipeline::rename_thing(home, command_line_author(), thing, options.other);
}

Made note_thing(home::Home& home, const EditOptions& options, Context&) {
  ROOMWISE_TRY(const auto thing, find_thing(home, options.what));
  return pipeline::note_thing(home, command_line_author(), thing, options.other);
}

Made move_thing(home::Home& home, const EditOptions& options, Context& context) {
  ROOMWISE_TRY(const auto thing, find_thing(home, options.what));
  ROOMWISE_TRY(const auto where, find_target(home, options, thing.name, &thing, context));
  return pipeline::move_thing(home, command_line_author(), thing, where);
}

Made merge_things(home::Home& home, const EditOptions& options, Context&) {
  ROOMWISE_TRY(const auto kept, find_thing(home, options.what));
  ROOMWISE_TRY(const auto twin, find_thing(home, options.other));
  return pipeline::merge_things(home, command_line_author(), kept, twin);
}

Made remove_thing(home::Home& home, const EditOptions& options, Context&) {
  ROOMWISE_TRY(const auto thing, find_thing(home, options.what));
  return pipeline::remove_thing(home, command_line_author(), thing);
}

Made rename_room(home::Home& home, const EditOptions& options, Context&) {
  home::EditId id = 0;
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(id,
                 pipeline::rename_room(home, command_line_author(), options.what, options.other));
    return photos_of(options).begin_rename(options.what, options.other);
  }));
  return id;
}

Made set_room_type(home::Home& home, const EditOptions& options, Context&) {
  return pipeline::set_room_type(home, command_line_author(), options.what, options.other);
}

Made remove_room(home::Home& home, const EditOptions& options, Context&) {
  home::EditId id = 0;
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(id, pipeline::remove_room(home, command_line_author(), options.what));
    return photos_of(options).set_aside(options.what);
  }));
  return id;
}

Made join_rooms(home::Home& home, const EditOptions& options, Context&) {
  ROOMWISE_RETURN_IF_ERROR(photos_of(options).check_can_join(options.what, options.other));
  return pipeline::join_rooms(home, command_line_author(), options.what, options.other);
}

Made divide_room(home::Home& home, const EditOptions& options, Context& context) {
  ROOMWISE_TRY(const auto floor, find_floor(home, context));
  return pipeline::divide_room(home, command_line_author(), floor, options.what, line_of(options),
                               options.other);
}

Made move_border(home::Home& home, const EditOptions& options, Context& context) {
  ROOMWISE_TRY(const auto floor, find_floor(home, context));
  return pipeline::move_border(home, command_line_author(), floor, options.what, options.other,
                               line_of(options));
}

Made draw_room(home::Home& home, const EditOptions& options, Context& context) {
  if (options.outline_m.size() % 2 != 0) {
    return fail("--outline needs pairs of numbers, x and y of each corner");
  }
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t i = 0; i < options.outline_m.size(); i += 2) {
    outline.emplace_back(options.outline_m[i], options.outline_m[i + 1]);
  }
  ROOMWISE_TRY(const auto floor, find_floor(home, context));
  return pipeline::draw_room(home, command_line_author(), floor, options.what, outline);
}

Made add_door(home::Home& home, const EditOptions& options, Context& context) {
  ROOMWISE_TRY(const auto floor, find_floor(home, context));
  return pipeline::add_door(home, command_line_author(), floor, {options.what, options.other},
                            {options.at_m[0], options.at_m[1]});
}

// ---- what all of them share ----

template <Made (*kChange)(home::Home&, const EditOptions&, Context&)>
Expected<Answer> change(const EditOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  const Made changed = kChange(home, options, context);
  const Expected<void> settled = photos_of(options).settle(home);
  ROOMWISE_TRY(const home::EditId id, changed);
  ROOMWISE_RETURN_IF_ERROR(settled);
  ROOMWISE_TRY(const auto edits, pipeline::stored_edits(home));
  const auto made = std::ranges::find(edits, id, &pipeline::StoredEdit::id);
  const std::string words = pipeline::describe(*made);
  return Answer{fmt::format("{} (change {}; undo it: roomwise edit undo {} --home {})\n", words, id,
                            id, shell_word(options.home)),
                {{"change", id}, {"did", words}}};
}

Json edit_json(const pipeline::StoredEdit& edit) {
  return {{"change", edit.id},
          {"what", std::string(pipeline::to_string(edit.kind))},
          {"did", pipeline::describe(edit)},
          {"made_s", edit.made_s},
          {"by", edit.made_by}};
}

Expected<Answer> list(const EditOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto edits, pipeline::stored_edits(home));
  ROOMWISE_TRY(const pipeline::HomeThings things, pipeline::find_home_things(home));
  Answer answer;
  answer.json["changes"] = Json::array();
  for (const pipeline::StoredEdit& edit : edits) {
    const auto lost = things.without_effect.find(edit.id);
    const std::string why = lost == things.without_effect.end() ? "" : lost->second;
    answer.text += fmt::format("{:>4}  {}{}{}\n", edit.id, pipeline::describe(edit),
                               edit.made_by.empty() ? "" : ", by " + edit.made_by,
                               why.empty() ? "" : fmt::format(" (of no effect now: {})", why));
    answer.json["changes"].push_back(edit_json(edit));
    answer.json["changes"].back()["without_effect"] = why.empty() ? Json(nullptr) : Json(why);
  }
  if (edits.empty()) answer.text = "nothing was changed by hand\n";
  return answer;
}

Expected<Answer> undo(const EditOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const auto edits, pipeline::stored_edits(home));  // marked places are none
  if (edits.empty()) return fail("{}: nothing was changed by hand", home.file());
  const home::EditId id = options.change.value_or(edits.back().id);
  live::RoomPhotos photos = photos_of(options);
  const auto undone = live::undo_edit(home, photos, id);
  const Expected<void> settled = photos.settle(home);
  ROOMWISE_RETURN_IF_ERROR(undone);
  ROOMWISE_RETURN_IF_ERROR(settled);
  return Answer{fmt::format("undone: {}\n", pipeline::describe(*undone)), edit_json(*undone)};
}

// What could be undone until now.
Expected<Answer> forget(const EditOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const bool has_any, pipeline::has_removed_rooms(home));
  live::RoomPhotos photos = photos_of(options);
  ROOMWISE_RETURN_IF_ERROR(photos.settle(home));
  ROOMWISE_RETURN_IF_ERROR(photos.forget_set_aside());
  if (has_any) ROOMWISE_RETURN_IF_ERROR(pipeline::forget_removed_rooms(home));
  ROOMWISE_RETURN_IF_ERROR(pipeline::forget_taken_walks(home).map([](const auto&) {}));
  ROOMWISE_TRY(const bool owes_erasing, home.owes_erasing());
  if (owes_erasing) ROOMWISE_RETURN_IF_ERROR(home.erase_removed());
  return Answer{owes_erasing ? "what was removed is forgotten; no byte of it is left\n"
                             : "nothing was removed\n",
                {{"forgotten", owes_erasing}}};
}

class EditGroup {
 public:
  EditGroup(CLI::App& group, Context& context) : group_(group), context_(context) {}

  // A change, and its words: ROOM, NAME.
  std::pair<CLI::App*, EditOptions&> add(const std::string& name, const std::string& description,
                                         const std::string& example,
                                         Expected<Answer> (*body)(const EditOptions&, Context&),
                                         const std::vector<std::string>& words = {}) {
    const auto [command, options] = add_command<EditOptions>(
        group_, context_, name, description, "roomwise edit " + name + " " + example, body);
    command->add_option("--home", options.home, "Home file")->required();
    const std::array places{&options.what, &options.other};
    for (std::size_t i = 0; i < words.size(); ++i) {
      command->add_option(words[i], *places.at(i), meaning_of(words[i]))->required();
    }
    return {command, options};
  }

  static void add_place(CLI::App* command, EditOptions& options) {
    CLI::Option* const at = add_point(command, options);
    CLI::Option* const room =
        command->add_option("--room", options.room, "In the middle of this room");
    at->excludes(room);
    command->add_option("--height", options.height_m,
                        "Of its middle above the floor, m; default: as before, on the floor or on "
                        "a table");
  }
  static CLI::Option* add_point(CLI::App* command, EditOptions& options) {
    return command
        ->add_option("--at", options.at_m,
                     "x and y on the floor, m, as roomwise rooms layout and export json give them")
        ->expected(2);
  }
  static void add_line(CLI::App* command, EditOptions& options) {
    command
        ->add_option("--line", options.line_m,
                     "x and y of two points on the floor, m; what lies left of who looks from the "
                     "first to the second is the left side")
        ->expected(4)
        ->required();
  }

 private:
  static std::string meaning_of(const std::string& word) {
    if (word == "THING") return "Its name; of several of a name NAME#2 for the second listed";
    if (word == "DOUBLE") return "The thing that is listed twice, and goes";
    if (word == "NOTE") return "To be said with it; '' takes it away";
    if (word == "TYPE") return "What kind of room it is: any word";
    if (word == "NEW_ROOM") return "Name of the room on the left side of the line";
    if (word == "NAME") return "Its name from now on";
    return "Name of the room";
  }

  CLI::App& group_;
  Context& context_;
};

void add_thing_changes(EditGroup& group) {
  const auto [add, of_add] =
      group.add("add-thing", "Add a thing that no walk showed; the guide tells it for certain",
                "kettle --room kitchen --note hot --home my.home", change<add_thing>, {"NAME"});
  EditGroup::add_place(add, of_add);
  add->add_option("--note", of_add.note, "To be said with it");
  const auto [way_out, of_way_out] = group.add("add-way-out", "Say where one leaves the home",
                                               "--at 0.5 3.2 --home my.home", change<add_way_out>);
  EditGroup::add_place(way_out, of_way_out);
  group.add("rename-thing", "Rename a thing; later walks keep the name", "cup mug --home my.home",
            change<rename_thing>, {"THING", "NAME"});
  group.add("note", "Write on a thing what the guide is to say with it",
            "stove 'hot in the evening' --home my.home", change<note_thing>, {"THING", "NOTE"});
  const auto [move, of_move] =
      group.add("move-thing", "Say where a thing stands", "cup --room kitchen --home my.home",
                change<move_thing>, {"THING"});
  EditGroup::add_place(move, of_move);
  group.add("merge-things", "Say that one thing is listed twice", "sofa armchair --home my.home",
            change<merge_things>, {"THING", "DOUBLE"});
  group.add("remove-thing", "Say that a thing is not there", "laptop#2 --home my.home",
            change<remove_thing>, {"THING"});
}

void add_room_changes(EditGroup& group) {
  group.add("rename-room", "Rename a room; it keeps its type and what was learned of it",
            "bedroom 'Anna s room' --home my.home", change<rename_room>, {"ROOM", "NAME"});
  group.add("room-type", "Say what kind of room it is", "den study --home my.home",
            change<set_room_type>, {"ROOM", "TYPE"});
  group.add("remove-room",
            "Take a room out; edit undo brings it back until edit forget, or until roomwise serve "
            "HOME opens or closes the home",
            "den --home my.home", change<remove_room>, {"ROOM"});
  group.add("join-rooms", "Make two rooms one, which has the first one's name",
            "kitchen pantry --home my.home", change<join_rooms>, {"ROOM", "OTHER"});
  const auto [divide, of_divide] = group.add("divide-room", "Divide a room by a line",
                                             "living dining --line 2 0 2 4 --home my.home",
                                             change<divide_room>, {"ROOM", "NEW_ROOM"});
  EditGroup::add_line(divide, of_divide);
  const auto [border, of_border] = group.add(
      "move-border", "Say where one room ends and another begins: LEFT lies left of the line",
      "kitchen hall --line 2 0 2 4 --home my.home", change<move_border>, {"LEFT", "RIGHT"});
  EditGroup::add_line(border, of_border);
  const auto [draw, of_draw] =
      group.add("draw-room", "Say what floor is a room's, which may be new, by its corners",
                "pantry --outline 0 0 1 0 1 1.5 0 1.5 --home my.home", change<draw_room>, {"ROOM"});
  constexpr int kFewest = 2 * 3, kMost = 2 * 100;
  draw->add_option("--outline", of_draw.outline_m, "x and y of each corner, m")
      ->expected(kFewest, kMost)
      ->required();
  const auto [door, of_door] =
      group.add("add-door", "Say where one gets from a room to another",
                "kitchen hall --at 2 1 --home my.home", change<add_door>, {"ROOM", "OTHER"});
  EditGroup::add_point(door, of_door)->required();
}

}  // namespace

pipeline::EditAuthor command_line_author() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return {"command line", std::chrono::duration_cast<std::chrono::seconds>(now).count()};
}

void add_edit_commands(CLI::App& app, Context& context) {
  CLI::App* const app_group =
      add_group(app, "edit",
                "What people know better of a home: things and rooms changed by hand, kept over "
                "later walks, and undone",
                "roomwise edit rename-thing cup mug --home my.home");
  EditGroup group(*app_group, context);
  group.add("list", "What was changed by hand, when and by whom", "--home my.home --json", list);
  const auto [undo_command, of_undo] =
      group.add("undo", "Take a change back: the home is as if it had never been made",
                "--home my.home", undo);
  undo_command->add_option("CHANGE", of_undo.change,
                           "Its number in edit list; default: the newest");
  group.add("forget",
            "Forget removed rooms, and walks that were taken away, for good: they cannot be undone "
            "any more",
            "--home my.home", forget);
  add_thing_changes(group);
  add_room_changes(group);
}

}  // namespace roomwise::app
