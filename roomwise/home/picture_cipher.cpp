#include "roomwise/home/picture_cipher.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

namespace roomwise::home {
namespace {

constexpr std::size_t kKeyBytes = crypto_aead_xchacha20poly1305_ietf_KEYBYTES;
constexpr std::size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kTagBytes = crypto_aead_xchacha20poly1305_ietf_ABYTES;
// A home from elsewhere must not make the program take all memory, or hours.
constexpr std::uint64_t kMostPasses = 64;
constexpr std::uint64_t kMostMemoryBytes = std::uint64_t{2} << 30U;

struct StateName {
  ProtectionState state;
  std::string_view name;
};
constexpr std::array kStateNames = {StateName{ProtectionState::kSealing, "sealing"},
                                    StateName{ProtectionState::kSealed, "sealed"},
                                    StateName{ProtectionState::kOpening, "opening"}};

std::string_view name_of(ProtectionState state) {
  return std::ranges::find(kStateNames, state, &StateName::state)->name;
}

void append(Bytes& bytes, std::string_view text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
}

// NONCE SEALED TAG, appended to `out`.
void append_sealed(Bytes& out, const SecretBytes& key, std::span<const std::uint8_t> plain,
                   const Bytes& context) {
  const std::size_t nonce = out.size();
  out.resize(nonce + kNonceBytes + plain.size() + kTagBytes);
  ::randombytes_buf(&out[nonce], kNonceBytes);
  ::crypto_aead_xchacha20poly1305_ietf_encrypt(&out[nonce + kNonceBytes], nullptr, plain.data(),
                                               plain.size(), context.data(), context.size(),
                                               nullptr, &out[nonce], key.data());
}

// Into `plain`, whose size must be right. False where anything is not as it was sealed.
bool open_sealed(std::span<const std::uint8_t> sealed, const SecretBytes& key, const Bytes& context,
                 std::span<std::uint8_t> plain) {
  return sealed.size() == kNonceBytes + plain.size() + kTagBytes &&
         ::crypto_aead_xchacha20poly1305_ietf_decrypt(
             plain.data(), nullptr, nullptr, &sealed[kNonceBytes], sealed.size() - kNonceBytes,
             context.data(), context.size(), sealed.data(), key.data()) == 0;
}

// What a picture is bound to: it cannot be opened as anything else.
Bytes context_of(std::uint64_t keyframe, PictureKind kind) {
  Bytes context;
  append(context, "roomwise picture 1");
  context.push_back(static_cast<std::uint8_t>(kind));
  for (unsigned shift = 0; shift < 64; shift += 8) {
    context.push_back(static_cast<std::uint8_t>(keyframe >> shift));
  }
  return context;
}

// What stands beside the wrapped key in the home, and is bound to it.
struct Wrapping {
  std::string state;
  PassphraseCost cost;
  Bytes salt;

  [[nodiscard]] Bytes context() const {
    const nlohmann::json parts = {"roomwise key 1", state, cost.passes, cost.memory_bytes, salt};
    Bytes context;
    append(context, parts.dump());
    return context;
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

std::string to_hex(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, ""));
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
  if (state == kStateNames.end() || !salt || !key || cost.passes < 1 || cost.passes > kMostPasses ||
      cost.memory_bytes < crypto_pwhash_MEMLIMIT_MIN || cost.memory_bytes > kMostMemoryBytes) {
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
  Bytes sealed;
  sealed.reserve(kSealedPictureMark.size() + kNonceBytes + picture.size() + kTagBytes);
  append(sealed, kSealedPictureMark);
  append_sealed(sealed, *key_, picture, context_of(keyframe, kind));
  return sealed;
}

Expected<Bytes> PictureCipher::open(std::uint64_t keyframe, PictureKind kind,
                                    std::span<const std::uint8_t> sealed) const {
  constexpr std::size_t kLeast = kSealedPictureMark.size() + kNonceBytes + kTagBytes;
  if (is_sealed(sealed) && sealed.size() >= kLeast) {
    Bytes picture(sealed.size() - kLeast);
    const auto rest = sealed.subspan(kSealedPictureMark.size());
    if (open_sealed(rest, *key_, context_of(keyframe, kind), picture)) return picture;
  }
  return fail("a picture of key-frame {} was changed since it was sealed, or is another's",
              keyframe);
}

Expected<std::string> PictureCipher::wrap(const Passphrase& passphrase, ProtectionState state,
                                          const PassphraseCost& cost) const {
  Wrapping wrapping{std::string(name_of(state)), cost, Bytes(crypto_pwhash_SALTBYTES)};
  ::randombytes_buf(wrapping.salt.data(), wrapping.salt.size());
  ROOMWISE_TRY(const SecretBytes key, key_from(passphrase, wrapping));
  Bytes wrapped;
  append_sealed(wrapped, key, key_->bytes(), wrapping.context());
  return nlohmann::json{{"method", "argon2id, xchacha20-poly1305"},
                        {"state", wrapping.state},
                        {"passes", cost.passes},
                        {"memory_bytes", cost.memory_bytes},
                        {"salt", to_hex(wrapping.salt)},
                        {"key", to_hex(wrapped)}}
      .dump();
}

Expected<UnwrappedCipher> unwrap_cipher(std::string_view wrapped, const Passphrase& passphrase) {
  const auto parsed = parse(wrapped);
  if (!parsed) {
    return fail("is damaged: the key of its pictures cannot be read; put back a copy of it");
  }
  ROOMWISE_TRY(const SecretBytes wrapping_key, key_from(passphrase, parsed->wrapping));
  auto key = std::make_shared<SecretBytes>(kKeyBytes);
  if (!open_sealed(parsed->key, wrapping_key, parsed->wrapping.context(), key->bytes())) {
    return fail("the passphrase is wrong (or the key of its pictures was damaged)");
  }
  return UnwrappedCipher{PictureCipher(std::move(key)), parsed->state};
}

bool is_sealed(std::span<const std::uint8_t> picture) {
  return picture.size() >= kSealedPictureMark.size() &&
         std::equal(kSealedPictureMark.begin(), kSealedPictureMark.end(), picture.begin());
}

}  // namespace roomwise::home
