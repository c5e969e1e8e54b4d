#include "roomwise/home/content_digest.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

void append_number(Bytes& bytes, std::uint64_t number) {
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(number >> shift));
  }
}

// One value so that no two different values look alike: its type, its length, its bytes.
void append_blob(Bytes& bytes, int type, const Bytes& value) {
  bytes.push_back(static_cast<std::uint8_t>(type));
  append_number(bytes, value.size());
  bytes.insert(bytes.end(), value.begin(), value.end());
}

void append_value(Bytes& bytes, const Statement& row, int column) {
  const int type = sqlite3_column_type(row.handle(), column);
  if (type == SQLITE_TEXT || type == SQLITE_BLOB) {
    return append_blob(bytes, type, row.column<Bytes>(column));
  }
  bytes.push_back(static_cast<std::uint8_t>(type));
  if (type == SQLITE_INTEGER) {
    append_number(bytes, row.column<std::uint64_t>(column));
  } else if (type == SQLITE_FLOAT) {
    append_number(bytes, std::bit_cast<std::uint64_t>(row.column<double>(column)));
  }
}

// What the digest leaves out: only what may differ between two runs of one seed, or follows from
// the rest.
bool is_left_out(std::string_view table) {
  return table == "stage_timings" || table == "picture_features" || table == "derived_data";
}
std::string_view column_left_out(std::string_view table) {
  if (table == "edits") return "made_s";
  if (table == "own_things") return "taught_s";
  return table == "recordings" || table == "visits" ? "folder" : "";
}

// What kind of picture stands in the column, if any.
const PictureColumn* picture_column(std::string_view table, std::string_view column) {
  const auto found = std::ranges::find_if(kPictureColumns, [&](const PictureColumn& picture) {
    return picture.table == table && picture.column == column;
  });
  return found == kPictureColumns.end() ? nullptr : &*found;
}

// The columns that the digest covers by name, joined for a SELECT.
Expected<std::string> columns_by_name(const Database& database, const std::string& table) {
  return database.get<std::string>(
      "SELECT group_concat(name, ', ') FROM "
      "(SELECT name FROM pragma_table_info(?) WHERE name <> ? ORDER BY name)",
      table, column_left_out(table));
}

// The digest of a table is that of its columns' names and its rows' digests, sorted.
Expected<std::string> table_digest(const Database& database, const std::string& table,
                                   const PlainPicture& plain_picture) {
  ROOMWISE_TRY(const std::string columns, columns_by_name(database, table));
  std::vector<std::string> rows;
  const auto add_row = [&](const Statement& row) -> Expected<void> {
    Bytes bytes;
    const int count =
        sqlite3_column_count(row.handle()) - 1;  // the last is the pictures' number, or 0
    for (int i = 0; i < count; ++i) {
      const auto* picture = picture_column(table, sqlite3_column_name(row.handle(), i));
      if (picture == nullptr) {
        append_value(bytes, row, i);
        continue;
      }
      ROOMWISE_TRY(const Bytes plain, plain_picture(row.column<std::uint64_t>(count), picture->kind,
                                                    row.column<Bytes>(i)));
      append_blob(bytes, SQLITE_BLOB, plain);
    }
    rows.push_back(sha256_hex(bytes));
    return {};
  };
  const auto pictures = std::ranges::find(kPictureColumns, table, &PictureColumn::table);
  const std::string rows_left_out =
      table == "settings" ? fmt::format("key IN ('{}', '{}')", kProtectionSetting, kErasingSetting)
                          : "FALSE";
  ROOMWISE_RETURN_IF_ERROR(database.for_each(
      fmt::format("SELECT {}, {} FROM \"{}\" WHERE NOT ({})", columns,
                  pictures == kPictureColumns.end() ? "0" : pictures->id, table, rows_left_out),
      add_row));
  std::ranges::sort(rows);
  const std::string text = fmt::format("{}\n{}\n", columns, fmt::join(rows, "\n"));
  return sha256_hex(Bytes(text.begin(), text.end()));
}

}  // namespace

Expected<std::string> content_digest(const Database& database, const PlainPicture& plain_picture) {
  ROOMWISE_TRY(const auto tables,
               collect<std::vector<std::string>>(
                   database,
                   "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE "
                   "'sqlite_%' ORDER BY name",
                   [](const Statement& row) { return row.column<std::string>(0); }));
  std::string digests;
  for (const std::string& table : tables) {
    if (is_left_out(table)) continue;
    ROOMWISE_TRY(const std::string digest, table_digest(database, table, plain_picture));
    digests += fmt::format("{} {}\n", table, digest);
  }
  return sha256_hex(Bytes(digests.begin(), digests.end()));
}

}  // namespace roomwise::home
