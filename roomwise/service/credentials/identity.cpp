#include "roomwise/service/credentials/identity.h"

namespace roomwise::service {

std::string_view to_string(Role role) {
  return role == Role::kHelper ? "helper" : "device";
}

std::optional<Role> parse_role(std::string_view text) {
  for (const Role role : {Role::kDevice, Role::kHelper}) {
    if (text == to_string(role)) return role;
  }
  return std::nullopt;
}

}  // namespace roomwise::service
