#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "roomwise/home/database.h"
#include "roomwise/home/picture_cipher.h"

// The tables of a home file and how older files become newer ones. The SQL stands in schema.cpp and
// nowhere else; its comments are part of the file, and any SQLite browser shows them.
namespace roomwise::home {

// Bytes 68 to 71 of every home ("Rmws"), by which it is known from other databases.
constexpr std::uint32_t kApplicationId = 0x526d7773;

// What makes a home of version `version` from one of version - 1. Version 0 is an empty database.
// A migration that stands here is never changed again: homes of its version exist.
struct Migration {
  int version = 0;
  const char* sql = nullptr;
};
// In order; the last one's version is the one that this program reads and writes.
[[nodiscard]] std::span<const Migration> migrations();

struct Table {
  std::string_view name;
  // What the content digest leaves out: only what may differ between two runs of one seed, or
  // follows from the rest.
  bool in_digest = true;
  std::string_view column_outside_digest = {};
  std::string_view rows_outside_digest = {};  // an SQL condition
  // The version that brought it. The digest covers a later table once it holds something: a home
  // does not change by being brought up to date.
  int since_version = 1;
};
// Every table of a home.
[[nodiscard]] std::span<const Table> tables();

// Brings the database to the version of the last migration: each step is one transaction, so a
// failed or killed migration leaves the version before it, whole.
[[nodiscard]] Expected<void> migrate(Database& database, std::span<const Migration> migrations);

// Fails, naming it, where a table or a column is missing that a home after these migrations has.
[[nodiscard]] Expected<void> check_tables(const Database& database,
                                          std::span<const Migration> migrations);

// The key of the setting that says how the home's pictures are protected (PictureCipher::wrap()).
// It is no part of what the home holds: the pictures are the same.
inline constexpr std::string_view kProtectionSetting = "picture_protection";

// Where pictures stand that a protected home seals, all beside a column keyframe_id.
struct PictureColumn {
  std::string_view table;
  std::string_view column;
  PictureKind kind;
};
inline constexpr std::array kPictureColumns = {
    PictureColumn{"keyframe_images", "color", PictureKind::kColor},
    PictureColumn{"keyframe_images", "depth", PictureKind::kDepth},
    PictureColumn{"keyframe_depths", "depth", PictureKind::kCoarseDepth}};

// The version that brought the table picture_features.
constexpr int kPictureFeaturesVersion = 2;
// That brought where in key-frames things are, and what they are together: region_finders,
// keyframe_depths, keyframe_looks, keyframe_regions, instances, instance_names.
constexpr int kInstancesVersion = 3;
// That brought later visits and the past: visits, instance_visits, past_instances.
constexpr int kVisitsVersion = 4;
// That brought pictures of later visits by which rooms are known: visit_pictures.
constexpr int kVisitPicturesVersion = 5;

}  // namespace roomwise::home
