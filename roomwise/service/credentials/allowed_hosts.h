#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::service {

// The names by which strangers may call this computer. A page of another site can have its own name
// lead to an address in the home ("DNS rebinding"), so that a browser takes the computer's answers
// for that site's; its requests then still bear that name. Addresses are always allowed: nobody
// else can have a name lead there.
class AllowedHosts {
 public:
  // `names`: host names and addresses, as host_names() gives them. Each must be is_host_name().
  [[nodiscard]] static Expected<AllowedHosts> of(const std::vector<std::string>& names);

  // Whether the header Host, "flat.local:8443", names this computer.
  [[nodiscard]] bool allows(std::string_view host_header) const;

 private:
  std::set<std::string> names_;  // in small letters, without the root's full stop
};

// Whether it is an IPv4 or IPv6 address, without brackets; one of IPv6 may have a zone,
// "fe80::1%eth0", which may be any text.
[[nodiscard]] bool is_address(std::string_view text);
[[nodiscard]] std::string_view without_zone(std::string_view address);
// A host name or an address, without a port: letters, digits, '.', '-', '_' and ':'.
[[nodiscard]] bool is_host_name(std::string_view text);

}  // namespace roomwise::service
