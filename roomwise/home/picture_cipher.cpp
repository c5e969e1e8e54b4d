#include "roomwise/home/picture_cipher.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "roomwise/base/encodings.h"

namespace roomwise::home {
namespace {

constexpr std::size_t kKeyBytes = crypto_aead_xchacha20poly1305_ietf_KEYBYTES;
constexpr std::size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
// A home from elsewhere must not make the program take all memory, or hours.
constexpr std::uint64_t kMaxPasses = 64;
constexpr std::uint64_t kMaxMemoryBytes = std::uint64_t{2} << 30U;

struct StateName {
  ProtectionState state;
  std::string_view name;  // as homes store it
};
constexpr std::array kStateNames = {StateName{ProtectionState::kEncrypting, "sealing"},
                                    StateName{ProtectionState::kEncrypted, "sealed"},
                                    StateName{ProtectionState::kDecrypting, "opening"}};

std::string_view name_of(ProtectionState state) {
  return std::ranges::find(kStateNames, state, &StateName::state)->name;
}

// What bytes are bound to when they are sealed: they open as nothing else.
using Binding = std::string;

const std::uint8_t* bytes_of(std::string_view text) {
  return reinterpret_cast<const std::uint8_t*>(text.data());
}

// NONCE CIPHERTEXT TAG, into `sealed`, whose size must be right.
void seal_into(std::span<std::uint8_t> sealed, const SecretBytes& key,
               std::span<const std::uint8_t> plain, const Binding& binding) {
  ::randombytes_buf(sealed.data(), kNonceBytes);
  ::crypto_aead_xchacha20poly1305_ietf_encrypt(sealed.data() + kNonceBytes, nullptr, plain.data(),
                                               plain.size(), bytes_of(binding), binding.size(),
                                               nullptr, sealed.data(), key.data());
}

// Into `plain`, whose size must be right. False where anything is not as it was sealed.
bool open_sealed(std::span<const std::uint8_t> sealed, const SecretBytes& key,
                 const Binding& binding, std::span<std::uint8_t> plain) {
  return sealed.size() == kNonceBytes + plain.size() + kTagBytes &&
         ::crypto_aead_xchacha20poly1305_ietf_decrypt(
             plain.data(), nullptr, nullptr, &sealed[kNonceBytes], sealed.size() - kNonceBytes,
             bytes_of(binding), binding.size(), sealed.data(), key.data()) == 0;
}

Binding binding_of(std::uint64_t keyframe, PictureKind kind) {
  return fmt::format("roomwise picture 1, kind {}, key-frame {}", static_cast<int>(kind), keyframe);
}

// For people.
std::string described(PictureKind kind, std::uint64_t number) {
  switch (kind) {
    case PictureKind::kOwnThing:
    case PictureKind::kOwnThingMask:
      return fmt::format("view {} of a thing that somebody taught", number);
    case PictureKind::kDepthView:
      return fmt::format("depth image {} between pictures", number);
    default:
      return fmt::format("a picture of key-frame {}", number);
  }
}

// What stands beside the wrapped key in the home, and is bound to it.
struct Wrapping {
  std::string state;
  PassphraseCost cost;
  Bytes salt;

  [[nodiscard]] Binding binding() const {
    const nlohmann::json parts = {"roomwise key 1", state, cost.passes, cost.memory_bytes, salt};
    return parts.dump();
  }
};

Expected<SecretBytes> key_from(const Passphrase& passphrase, const Wrapping& wrapping) {
  SecretBytes key(kKeyBytes);
  const auto text = passphrase.bytes();
  if (::crypto_pwhash(key.data(), kKeyBytes, reinterpret_cast<const char*>(text.data()),
                      text.size(), wrapping.salt.data(), wrapping.cost.passes,
                      wrapping.cost.memory_bytes, crypto_pwhash_ALG_ARGON2ID13) != 0) {
    return fail("there is not enough memory to make a key of the passphrase (it takes {} MiB)",
                wrapping.cost.memory_bytes >> 20U);
  }
  return key;
}

std::optional<Bytes> from_hex(const std::string& text, std::size_t size) {
  Bytes bytes(size);
  std::size_t written = 0;
  if (text.size() != 2 * size || ::sodium_hex2bin(bytes.data(), size, text.data(), text.size(),
                                                  nullptr, &written, nullptr) != 0) {
    return std::nullopt;
  }
  return written == size ? std::optional(std::move(bytes)) : std::nullopt;
}

struct WrappedKey {
  Wrapping wrapping;
  ProtectionState state;
  Bytes key;
};

std::optional<WrappedKey> parse(std::string_view text) {
  const auto json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto is_text = [&](const char* key) { return json.contains(key) && json[key].is_string(); };
  const auto number = [&](const char* key) {
    const bool is_number = json.contains(key) && json[key].is_number_unsigned();
    return is_number ? json[key].get<std::uint64_t>() : 0;
  };
  if (!json.is_object() || !is_text("state") || !is_text("salt") || !is_text("key")) return {};
  const auto state =
      std::ranges::find(kStateNames, json["state"].get<std::string>(), &StateName::name);
  auto salt = from_hex(json["salt"], crypto_pwhash_SALTBYTES);
  auto key = from_hex(json["key"], kNonceBytes + kKeyBytes + kTagBytes);
  const PassphraseCost cost{number("passes"), number("memory_bytes")};
  if (state == kStateNames.end() || !salt || !key || cost.passes < 1 || cost.passes > kMaxPasses ||
      cost.memory_bytes < crypto_pwhash_MEMLIMIT_MIN || cost.memory_bytes > kMaxMemoryBytes) {
    return {};
  }
  return WrappedKey{
      {std::string(state->name), cost, *std::move(salt)}, state->state, *std::move(key)};
}

}  // namespace

PictureCipher PictureCipher::create() {
  auto key = std::make_shared<SecretBytes>(kKeyBytes);
  ::crypto_aead_xchacha20poly1305_ietf_keygen(key->data());
  return PictureCipher(std::move(key));
}

Bytes PictureCipher::seal(std::uint64_t keyframe, PictureKind kind,
                          std::span<const std::uint8_t> picture) const {
  Bytes sealed(kSealedPictureMark.size() + kNonceBytes + picture.size() + kTagBytes);
  std::ranges::copy(kSealedPictureMark, sealed.begin());
  seal_into(std::span(sealed).subspan(kSealedPictureMark.size()), *key_, picture,
            binding_of(keyframe, kind));
  return sealed;
}

Expected<Bytes> PictureCipher::open(std::uint64_t keyframe, PictureKind kind,
                                    std::span<const std::uint8_t> sealed) const {
  constexpr std::size_t kMin = kSealedPictureMark.size() + kNonceBytes + kTagBytes;
  if (is_sealed(sealed) && sealed.size() >= kMin) {
    Bytes picture(sealed.size() - kMin);
    const auto rest = sealed.subspan(kSealedPictureMark.size());
    if (open_sealed(rest, *key_, binding_of(keyframe, kind), picture)) return picture;
  }
  return fail("{} was changed since it was sealed, or is another's", described(kind, keyframe));
}

Expected<std::string> PictureCipher::wrap(const Passphrase& passphrase, ProtectionState state,
                                          const PassphraseCost& cost) const {
  Wrapping wrapping{std::string(name_of(state)), cost, Bytes(crypto_pwhash_SALTBYTES)};
  ::randombytes_buf(wrapping.salt.data(), wrapping.salt.size());
  ROOMWISE_TRY(const SecretBytes key, key_from(passphrase, wrapping));
  Bytes wrapped(kNonceBytes + kKeyBytes + kTagBytes);
  seal_into(wrapped, key, key_->bytes(), wrapping.binding());
  return nlohmann::json{{"method", "argon2id, xchacha20-poly1305"},
                        {"state", wrapping.state},
                        {"passes", cost.passes},
                        {"memory_bytes", cost.memory_bytes},
                        {"salt", hexadecimal(wrapping.salt)},
                        {"key", hexadecimal(wrapped)}}
      .dump();
}

Expected<UnwrappedCipher> unwrap_cipher(std::string_view wrapped, const Passphrase& passphrase) {
  const auto parsed = parse(wrapped);
  if (!parsed) {
    return fail("is damaged: the key of its pictures cannot be read; put back a copy of it");
  }
  ROOMWISE_TRY(const SecretBytes wrapping_key, key_from(passphrase, parsed->wrapping));
  auto key = std::make_shared<SecretBytes>(kKeyBytes);
  if (!open_sealed(parsed->key, wrapping_key, parsed->wrapping.binding(), key->bytes())) {
    return fail("the passphrase is wrong (or the key of its pictures was damaged)");
  }
  return UnwrappedCipher{PictureCipher(std::move(key)), parsed->state};
}

bool is_sealed(std::span<const std::uint8_t> picture) {
  return picture.size() >= kSealedPictureMark.size() &&
         std::equal(kSealedPictureMark.begin(), kSealedPictureMark.end(), picture.begin());
}

}  // namespace roomwise::home
