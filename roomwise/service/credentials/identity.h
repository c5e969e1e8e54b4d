#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace roomwise::service {

// What a paired client may do; each may all that those before it may.
enum class Role {
  kDevice,  // sends frames and asks
  kHelper,  // also sees and changes the home, pairs and removes devices
};

[[nodiscard]] std::string_view to_string(Role role);  // "device", "helper"
[[nodiscard]] std::optional<Role> parse_role(std::string_view text);

// A client that is paired, or one of the staff of who keeps many homes.
struct Identity {
  std::int64_t device = 0;  // its number, never given twice in one home; of staff below 0
  std::string name;         // "Anna's phone"
  Role role = Role::kDevice;

  // Staff have an account in place of a device. Its number below zero is no paired device's.
  [[nodiscard]] static std::int64_t device_of_account(std::int64_t account) { return -account; }
  [[nodiscard]] bool is_account() const { return device < 0; }

  bool operator==(const Identity&) const = default;
};

// Why somebody is not let in: a device not paired, one of the staff not signed in.
struct Refusal {
  int status = 401;         // of the answer; 429: wait, nothing was tried
  std::string message;      // for people
  std::int64_t wait_s = 0;  // with 429
  std::string key = {};     // by which pages have their own words for it; may be empty
};

// Whether `who` may do what needs `role`; nothing needed: everyone may.
[[nodiscard]] inline bool may(const std::optional<Identity>& who, std::optional<Role> role) {
  return !role || (who && who->role >= *role);
}

}  // namespace roomwise::service
