// The part of Home that protects its pictures by a passphrase.

#include "roomwise/base/in_context.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/home/home.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

// So many pictures are sealed or opened in one transaction: few enough to lie in memory, enough to
// wait for the disk seldom.
constexpr std::size_t kPicturesAtOnce = 32;

// Of those that are not as they are to be.
Expected<std::vector<KeyframeId>> keyframes_to_convert(const Database& database,
                                                       const PictureColumn& column,
                                                       bool to_sealed) {
  const Bytes mark(kSealedPictureMark.begin(), kSealedPictureMark.end());
  std::vector<KeyframeId> ids;
  ROOMWISE_RETURN_IF_ERROR(database.for_each(
      fmt::format("SELECT {2} FROM {0} WHERE (substr({1}, 1, ?) = ?) <> ? ORDER BY {2}",
                  column.table, column.column, column.id),
      [&](const Statement& row) { ids.push_back(row.column<KeyframeId>(0)); }, mark.size(), mark,
      to_sealed));
  return ids;
}

}  // namespace

Error Home::locked_error() const {
  return {fmt::format(
      "{}: its pictures are protected by a passphrase; give the file that holds it by "
      "--passphrase-file, or name that file in the environment's ROOMWISE_PASSPHRASE_FILE",
      file())};
}

Expected<Home> Home::with_protection_state(Home home, const OpenOptions& options) {
  ROOMWISE_TRY(const auto wrapped,
               home.database_.find<std::string>("SELECT value FROM settings WHERE key = ?",
                                                kProtectionSetting));
  home.is_protected_ = wrapped.has_value();
  if (!options.passphrase) return home;
  if (!wrapped) {
    return fail(
        "{}: a passphrase was given, but its pictures are not protected; protect them by: "
        "roomwise protect {}, or give no passphrase",
        home.file(), shell_word(home.file()));
  }
  ROOMWISE_TRY(auto unwrapped,
               in_context(home.file(), unwrap_cipher(*wrapped, *options.passphrase)));
  home.cipher_ = std::move(unwrapped.cipher);
  home.protection_state_ = unwrapped.state;
  return home;
}

Expected<void> Home::begin_protection(const Passphrase& passphrase, ProtectionState state,
                                      const PassphraseCost& cost) {
  PictureCipher cipher = cipher_ ? *cipher_ : PictureCipher::create();
  ROOMWISE_TRY(const auto wrapped, in_context(file(), cipher.wrap(passphrase, state, cost)));
  ROOMWISE_RETURN_IF_ERROR(database_.put("settings (key, value)", kProtectionSetting, wrapped));
  is_protected_ = true;
  cipher_ = std::move(cipher);
  protection_state_ = state;
  return {};
}

Expected<std::size_t> Home::protect(const Passphrase& passphrase, const PassphraseCost& cost) {
  if (is_locked()) return Unexpected(locked_error());
  if (is_protected_ && protection_state_ == ProtectionState::kEncrypted) {
    ROOMWISE_RETURN_IF_ERROR(begin_protection(passphrase, ProtectionState::kEncrypted, cost));
    return 0;
  }
  ROOMWISE_RETURN_IF_ERROR(begin_protection(passphrase, ProtectionState::kEncrypting, cost));
  // By these anybody could ask what the pictures show.
  ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM derived_data WHERE name = 'word_places'"));
  ROOMWISE_TRY(const std::size_t count, convert_pictures(/*to_sealed=*/true));
  // Only once nothing of them is left in the file are they said to be sealed.
  ROOMWISE_RETURN_IF_ERROR(erase_removed());
  ROOMWISE_RETURN_IF_ERROR(begin_protection(passphrase, ProtectionState::kEncrypted, cost));
  return count;
}

Expected<std::size_t> Home::unprotect(const Passphrase& passphrase, const PassphraseCost& cost) {
  if (is_locked()) return Unexpected(locked_error());
  if (!is_protected_) return fail("{}: its pictures are not protected", file());
  ROOMWISE_RETURN_IF_ERROR(begin_protection(passphrase, ProtectionState::kDecrypting, cost));
  ROOMWISE_TRY(const std::size_t count, convert_pictures(/*to_sealed=*/false));
  ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM settings WHERE key = ?", kProtectionSetting));
  is_protected_ = false;
  cipher_.reset();
  return count;
}

Expected<std::size_t> Home::convert_pictures(bool to_sealed) {
  std::size_t converted = 0;
  for (const PictureColumn& column : kPictureColumns) {
    const std::string read =
        fmt::format("SELECT {} FROM {} WHERE {} = ?", column.column, column.table, column.id);
    const std::string write =
        fmt::format("UPDATE {} SET {} = ? WHERE {} = ?", column.table, column.column, column.id);
    ROOMWISE_TRY(const auto ids, keyframes_to_convert(database_, column, to_sealed));
    for (std::size_t begin = 0; begin < ids.size(); begin += kPicturesAtOnce) {
      const std::size_t end = std::min(begin + kPicturesAtOnce, ids.size());
      ROOMWISE_RETURN_IF_ERROR(atomically([&]() -> Expected<void> {
        for (std::size_t i = begin; i < end; ++i) {
          ROOMWISE_TRY(Bytes picture, database_.get<Bytes>(read, ids[i]));
          ROOMWISE_TRY(picture, to_sealed
                                    ? encrypt_if_protected(ids[i], column.kind, std::move(picture))
                                    : decrypt_if_sealed(ids[i], column.kind, std::move(picture)));
          ROOMWISE_RETURN_IF_ERROR(database_.run(write, picture, ids[i]));
        }
        return {};
      }));
    }
    converted += ids.size();
  }
  return converted;
}

Expected<void> Home::reseal_pictures(const std::map<KeyframeId, KeyframeId>& old_numbers) {
  for (const PictureColumn& column : kPictureColumns) {
    if (column.id != "keyframe_id") continue;
    for (const auto& [id, old] : old_numbers) {
      ROOMWISE_TRY(auto stored,
                   database_.find<Bytes>(fmt::format("SELECT {} FROM {} WHERE keyframe_id = ?",
                                                     column.column, column.table),
                                         id));
      if (!stored || !is_sealed(*stored)) continue;
      if (!cipher_) return Unexpected(locked_error());
      const auto picture = cipher_->open(old, column.kind, *std::move(stored));
      if (!picture) continue;  // damaged: it cannot be read under any number
      ROOMWISE_RETURN_IF_ERROR(database_.run(
          fmt::format("UPDATE {} SET {} = ? WHERE keyframe_id = ?", column.table, column.column),
          cipher_->seal(id, column.kind, *picture), id));
    }
  }
  return {};
}

Expected<Bytes> Home::encrypt_if_protected(KeyframeId keyframe, PictureKind kind,
                                           Bytes picture) const {
  if (is_locked()) return Unexpected(locked_error());
  return cipher_ ? cipher_->seal(keyframe, kind, picture) : std::move(picture);
}

Expected<Bytes> Home::decrypt_if_sealed(KeyframeId keyframe, PictureKind kind, Bytes stored) const {
  // A reader may have opened the home before a writer protected it.
  if (is_locked() || (!cipher_ && is_sealed(stored))) return Unexpected(locked_error());
  if (!cipher_) return stored;
  if (!is_sealed(stored) && protection_state_ != ProtectionState::kEncrypted) return stored;
  return in_context(file(), cipher_->open(keyframe, kind, stored));
}

}  // namespace roomwise::home
