#include <filesystem>

#include "commands.h"
#include "open_home.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using rooms::Concepts;

struct ConceptsOptions {
  fs::path home;
  std::string object;
  std::vector<std::string> labels;
  std::vector<std::string> room_types;
};

std::string joined(const std::set<std::string>& words, const char* none) {
  return words.empty() ? none : fmt::format("{}", fmt::join(words, "; "));
}

Answer describe(const Concepts& concepts) {
  Answer answer;
  answer.json = {{"objects", Json::object()}, {"room_types", Json::object()}};
  answer.text = "Objects, and the network's labels that mean them:\n";
  for (const auto& [object, labels] : concepts.vocabulary.objects()) {
    answer.text += fmt::format("  {:<16} {}\n", object, joined(labels, "(none)"));
    answer.json["objects"][object] = labels;
  }
  answer.text += "Room types, and the objects that they have:\n";
  for (const auto& [type, objects] : concepts.objects_of_room_type) {
    answer.text += fmt::format("  {:<16} {}\n", type, joined(objects, "(none)"));
    answer.json["room_types"][type] = objects;
  }
  return answer;
}

Expected<Answer> list(const ConceptsOptions& options, Context& context) {
  if (options.home.empty()) return describe(Concepts::standard());
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const Concepts concepts, home.concepts());
  return describe(concepts);
}

// The labels as the home's networks spell them. Before any network has looked at the home they are
// taken as they are.
Expected<std::vector<std::string>> networks_spelling(const home::Home& home,
                                                     const std::vector<std::string>& wanted) {
  ROOMWISE_TRY(const auto networks, home.networks());
  std::vector<std::string> known;
  for (const auto& [id, network] : networks) {
    known.insert(known.end(), network.labels.begin(), network.labels.end());
  }
  ROOMWISE_TRY(const auto finders, home.region_finders());
  for (const auto& [id, finder] : finders) {
    known.insert(known.end(), finder.labels.begin(), finder.labels.end());
  }
  if (known.empty()) return wanted;
  std::vector<std::string> labels;
  for (const std::string& label : wanted) {
    ROOMWISE_TRY(labels.emplace_back(), objects::find_label(known, label));
  }
  return labels;
}

Expected<void> add(Concepts& concepts, const ConceptsOptions& options,
                   const std::vector<std::string>& labels) {
  if (!options.object.empty()) {
    if (labels.empty() && !concepts.vocabulary.objects().contains(options.object)) {
      return fail("'{}' is a new object; give with --label what the network calls it",
                  options.object);
    }
    ROOMWISE_RETURN_IF_ERROR(concepts.vocabulary.add(options.object, labels));
  }
  for (const std::string& type : options.room_types) {
    std::set<std::string>& objects = concepts.objects_of_room_type[type];
    if (!options.object.empty()) objects.insert(options.object);
  }
  return {};
}

// An object may be taken out of a room type, lose a label, or go as a whole; so may a room type.
Expected<void> remove(Concepts& concepts, const ConceptsOptions& options) {
  auto& types = concepts.objects_of_room_type;
  for (const std::string& type : options.room_types) {
    const auto found = types.find(type);
    if (found == types.end()) return fail("there is no room type '{}'", type);
    if (options.object.empty()) {
      types.erase(found);
    } else if (found->second.erase(options.object) == 0) {
      return fail("the room type '{}' has no '{}'", type, options.object);
    }
  }
  if (options.object.empty()) return {};

  const auto object = concepts.vocabulary.objects().find(options.object);
  if (object == concepts.vocabulary.objects().end()) {
    return fail("there is no object '{}'", options.object);
  }
  std::set<std::string> kept = object->second;
  for (const std::string& label : options.labels) {
    if (std::erase_if(kept, [&](const auto& own) { return objects::same_label(own, label); }) ==
        0) {
      return fail("'{}' does not mean '{}'", label, options.object);
    }
  }
  if (options.labels.empty() && !options.room_types.empty()) return {};
  ROOMWISE_RETURN_IF_ERROR(concepts.vocabulary.remove(options.object));
  if (!options.labels.empty()) {
    return concepts.vocabulary.add(options.object, {kept.begin(), kept.end()});
  }
  for (auto& [type, objects] : types) objects.erase(options.object);
  return {};
}

// What the networks saw stays the same; which of it counts does not. The home has both, the words
// and what follows from them, or is as it was.
Expected<void> replace_concepts(home::Home& home, const Concepts& concepts) {
  ROOMWISE_TRY(const auto settings, pipeline::stored_map_settings(home));
  const objects::ObjectRules rules = settings ? settings->objects : objects::ObjectRules{};
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(home.replace_concepts(concepts));
    ROOMWISE_RETURN_IF_ERROR(pipeline::update_objects(home, rules));
    return {};
  });
}

Expected<Answer> edit(const ConceptsOptions& options, bool adding, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(Concepts concepts, home.concepts());
  if (adding) {
    ROOMWISE_TRY(const std::vector<std::string> labels, networks_spelling(home, options.labels));
    ROOMWISE_RETURN_IF_ERROR(add(concepts, options, labels));
  } else {
    ROOMWISE_RETURN_IF_ERROR(remove(concepts, options));
  }
  ROOMWISE_RETURN_IF_ERROR(replace_concepts(home, concepts));
  return describe(concepts);
}

template <bool adding>
void add_edit(CLI::App& group, Context& context, const std::string& description,
              const std::string& example) {
  const auto [command, options] = add_command<ConceptsOptions>(
      group, context, adding ? "add" : "remove", description, example,
      [](const ConceptsOptions& given, Context& with) { return edit(given, adding, with); });
  command->add_option("--home", options.home, "Home file")->required();
  CLI::Option* object = command->add_option("--object", options.object, "Object, for example desk");
  command->add_option("--label", options.labels, "A network's label that means it; may be repeated")
      ->needs(object);
  command->add_option("--room-type", options.room_types, "Room type that has it; may be repeated");
  command->parse_complete_callback([&given = options] {
    if (given.object.empty() && given.room_types.empty()) {
      throw CLI::RequiredError("--object or --room-type");
    }
  });
}

}  // namespace

void add_concepts_commands(CLI::App& app, Context& context) {
  CLI::App* group =
      add_group(app, "concepts", "The objects and room types that count, and which room has which",
                "roomwise concepts list --home my.home");
  const auto [list_command, options] = add_command<ConceptsOptions>(
      *group, context, "list", "List the concepts of a home, or those that every home begins with",
      "roomwise concepts list --home my.home", list);
  list_command->add_option("--home", options.home, "Home file");

  add_edit<true>(
      *group, context, "Add an object, labels of it, or a room type that has it",
      "roomwise concepts add --home my.home --object bathtub --label tub --room-type bathroom");
  add_edit<false>(*group, context,
                  "Remove an object, a room type, or (both given) the object from the room type",
                  "roomwise concepts remove --home my.home --object lamp --room-type bedroom");
}

}  // namespace roomwise::app
