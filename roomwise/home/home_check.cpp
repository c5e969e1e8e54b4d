// What of a home's file is whole.
#include <algorithm>

#include "roomwise/base/shell_word.h"
#include "roomwise/home/home.h"
#include "roomwise/home/page_checksums.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

Expected<std::vector<std::string>> damaged_tables(const Database& database) {
  ROOMWISE_TRY(const auto tables,
               collect<std::vector<std::string>>(
                   database, "SELECT name FROM sqlite_schema WHERE type = 'table'",
                   [](const Statement& row) { return row.column<std::string>(0); }));
  std::vector<std::string> damaged;
  for (const std::string& table : tables) {
    const auto answer =
        database.get<std::string>(fmt::format("PRAGMA integrity_check(\"{}\")", table));
    if (!answer || *answer != "ok") damaged.push_back(table);
  }
  return damaged;
}

Expected<std::vector<std::string>> broken_references(const Database& database) {
  return collect<std::vector<std::string>>(
      database, "SELECT DISTINCT \"table\" FROM pragma_foreign_key_check",
      [](const Statement& row) { return row.column<std::string>(0); });
}

// The first of what a check found, for people.
std::string finding(const HomeCheck& check) {
  if (!check.damaged_tables.empty())
    return fmt::format("its table '{}' cannot be read in full", check.damaged_tables.front());
  if (!check.broken_references.empty())
    return fmt::format("a row of table '{}' belongs to one that is not there",
                       check.broken_references.front());
  if (!check.lost_own_things.empty())
    return "the pictures of a thing that somebody taught cannot be read";
  return fmt::format("page {} differs from its checksum", check.damaged_pages.front());
}

}  // namespace

Expected<HomeCheck> Home::check() const {
  ROOMWISE_TRY(PageCheck pages, check_pages(database_.handle(), file()));
  HomeCheck check;
  check.pages = pages.pages;
  check.damaged_pages = std::move(pages.damaged);
  ROOMWISE_TRY(check.damaged_tables, damaged_tables(database_));
  if (auto images = unreadable_pictures()) check.lost_pictures = *std::move(images);
  if (auto things = unreadable_own_things()) check.lost_own_things = *std::move(things);
  // Of tables that cannot be read nothing more can be said.
  if (auto references = broken_references(database_))
    check.broken_references = *std::move(references);
  if (const auto stored = recordings()) {
    for (const StoredRecording& one : *stored) {
      const auto valid = one.recording.camera.validate();
      const auto doubt =
          valid ? one.recording.camera.doubt() : std::optional(valid.error().message);
      if (doubt)
        check.doubtful_cameras.push_back(fmt::format("{}: {}", one.recording.name, *doubt));
    }
  }
  return check;
}

Expected<void> Home::verify() const {
  ROOMWISE_TRY(const HomeCheck check, this->check());
  if (check.is_whole()) return {};
  if (check.damaged_tables.empty() && !check.lost_pictures.empty())
    return fail("{}", check.lost_pictures.begin()->second);
  return fail(
      "{}: is damaged ({}); put back a copy of it, or see what is left of it with: roomwise "
      "check {}",
      file(), finding(check), shell_word(file()));
}

Expected<std::map<KeyframeId, std::string>> Home::unreadable_pictures() const {
  ROOMWISE_TRY(const auto ids,
               collect<std::vector<KeyframeId>>(
                   database_, "SELECT keyframe_id FROM keyframes ORDER BY keyframe_id",
                   [](const Statement& row) { return row.column<KeyframeId>(0); }));
  const auto read = [&](std::uint64_t id, const PictureColumn& column) -> Expected<void> {
    ROOMWISE_TRY(auto picture,
                 database_.find<Bytes>(fmt::format("SELECT {} FROM {} WHERE {} = ?", column.column,
                                                   column.table, column.id),
                                       id));
    if (!picture || is_locked()) return {};
    return decrypt_if_sealed(id, column.kind, *std::move(picture)).map([](const Bytes&) {});
  };
  std::map<KeyframeId, std::string> unreadable;
  for (const KeyframeId id : ids) {
    for (const PictureColumn& column : kPictureColumns) {
      if (column.id != "keyframe_id") continue;
      if (const auto is_read = read(id, column); !is_read)
        unreadable.emplace(id, is_read.error().message);
    }
  }
  const auto* const of_view =
      std::ranges::find(kPictureColumns, PictureKind::kDepthView, &PictureColumn::kind);
  if (const auto views = depth_views()) {
    for (const DepthView& view : *views) {
      if (const auto is_read = read(view.id, *of_view); !is_read)
        unreadable.emplace(view.keyframe, is_read.error().message);
    }
  }
  return unreadable;
}

Expected<std::vector<OwnThingId>> Home::unreadable_own_things() const {
  std::vector<OwnThingId> unreadable;
  if (is_locked()) return unreadable;
  ROOMWISE_TRY(const auto things, own_things());
  for (const OwnThing& thing : things) {
    if (!own_thing_views(thing.id)) unreadable.push_back(thing.id);
  }
  return unreadable;
}

}  // namespace roomwise::home
