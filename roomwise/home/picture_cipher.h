#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/home/passphrase.h"

// How the pictures of a protected home are sealed: XChaCha20-Poly1305 with a random key of the
// home's own, which is kept in the home wrapped by a key that Argon2id (RFC 9106) makes of the
// passphrase. So another passphrase wraps the same key anew and rewrites no picture.
namespace roomwise::home {

// What a passphrase costs to try, once. Stored with what it protects, so it can change.
struct PassphraseCost {
  // Argon2id in 256 MiB of memory, three passes: half a second or more of one processor.
  std::uint64_t passes = 3;
  std::uint64_t memory_bytes = std::uint64_t{256} << 20U;
};

// Where protecting a home stands. What is between is left by a program that was killed.
enum class ProtectionState {
  kEncrypting,  // some pictures, or their remains in the file, are not encrypted yet
  kEncrypted,   // every picture is encrypted
  kDecrypting,  // protection is being taken away: some pictures are encrypted
};

enum class PictureKind : std::uint8_t {
  kColor = 1,
  kDepth = 2,
  kCoarseDepth = 3,
  kOwnThing = 4,  // of a thing that somebody taught; its number is that of the view
  kOwnThingMask = 5,
  kDepthView = 6,  // its number is its own
};

// Seals and opens the pictures of one home. Thread-safe.
class PictureCipher {
 public:
  // With a new random key.
  [[nodiscard]] static PictureCipher create();

  // The picture and a random nonce, sealed so that nothing of it can be seen or changed, nor can it
  // be taken for the picture of another key-frame or of another kind.
  [[nodiscard]] Bytes seal(std::uint64_t keyframe, PictureKind kind,
                           std::span<const std::uint8_t> picture) const;
  // Fails where it is not, to the bit, what seal() made for this key-frame and kind.
  [[nodiscard]] Expected<Bytes> open(std::uint64_t keyframe, PictureKind kind,
                                     std::span<const std::uint8_t> sealed) const;

  // The key, sealed by the passphrase, together with the state: a line of JSON.
  [[nodiscard]] Expected<std::string> wrap(const Passphrase& passphrase, ProtectionState state,
                                           const PassphraseCost& cost) const;

 private:
  friend struct UnwrappedCipher;
  friend Expected<struct UnwrappedCipher> unwrap_cipher(std::string_view, const Passphrase&);
  explicit PictureCipher(std::shared_ptr<const SecretBytes> key) : key_(std::move(key)) {}

  std::shared_ptr<const SecretBytes> key_;
};

struct UnwrappedCipher {
  PictureCipher cipher;
  ProtectionState state;
};
// Of what wrap() made. Fails where the passphrase is another, or where anything of it was changed.
[[nodiscard]] Expected<UnwrappedCipher> unwrap_cipher(std::string_view wrapped,
                                                      const Passphrase& passphrase);

// Sealed pictures begin with these bytes, which no JPEG and no PNG begins with.
inline constexpr std::string_view kSealedPictureMark = "RWsealed";
[[nodiscard]] bool is_sealed(std::span<const std::uint8_t> picture);

}  // namespace roomwise::home
