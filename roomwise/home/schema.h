#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "roomwise/home/database.h"
#include "roomwise/home/picture_cipher.h"

// The tables of a home file. Their SQL stands in schema.cpp and nowhere else; its comments are part
// of the file, and any SQLite browser shows them.
namespace roomwise::home {

// Bytes 68 to 71 of every home ("Rmws"), by which it is known from other databases.
constexpr std::uint32_t kApplicationId = 0x526d7773;
// The user_version of the homes that this program reads and writes. It grows with every change of
// the tables.
constexpr int kHomeVersion = 1;

// Makes an empty database a home with nothing in it, in one transaction.
[[nodiscard]] Expected<void> create_tables(Database& database);

// Adds the tables that homes of before have not, and a home cannot be read wrongly without: what
// people changed by hand, the things that they taught, depth between pictures.
[[nodiscard]] Expected<void> add_later_tables(Database& database);

// Fails, naming it, where a table or a column of a home is missing; of a later table, where it is
// there and lacks one.
[[nodiscard]] Expected<void> check_tables(const Database& database);

// Homes of before that are only read lack later tables.
[[nodiscard]] Expected<bool> has_table(const Database& database, std::string_view name);

// The key of the setting that says how the home's pictures are protected (PictureCipher::wrap()).
// It is no part of what the home holds: the pictures are the same.
inline constexpr std::string_view kProtectionSetting = "picture_protection";
// The key of the setting that is there while erasing is owed (Home::owe_erasing()); no part of what
// the home holds either.
inline constexpr std::string_view kErasingSetting = "erasing_owed";

// Where pictures stand that a protected home seals, beside the number that they are bound to.
struct PictureColumn {
  std::string_view table;
  std::string_view column;
  PictureKind kind;
  std::string_view id = "keyframe_id";
};
inline constexpr std::array kPictureColumns = {
    PictureColumn{"keyframe_images", "color", PictureKind::kColor},
    PictureColumn{"keyframe_images", "depth", PictureKind::kDepth},
    PictureColumn{"keyframe_depths", "depth", PictureKind::kCoarseDepth},
    PictureColumn{"own_thing_views", "picture", PictureKind::kOwnThing, "view_id"},
    PictureColumn{"own_thing_views", "mask", PictureKind::kOwnThingMask, "view_id"},
    PictureColumn{"keyframe_depth_views", "depth", PictureKind::kDepthView, "depth_view_id"}};

}  // namespace roomwise::home
