#include "roomwise/service/credentials/allowed_hosts.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace roomwise::service {
namespace {

std::string small(std::string_view name) {
  if (name.ends_with('.')) name.remove_suffix(1);
  std::string text(name);
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "flat.local:8443" to "flat.local", "[::1]:8443" to "::1".
std::string_view without_port(std::string_view host) {
  if (host.starts_with('[')) return host.substr(1, std::min(host.find(']'), host.size()) - 1);
  return host.substr(0, std::min(host.find(':'), host.size()));
}

}  // namespace

bool is_address(std::string_view text) {
  std::array<unsigned char, 16> ignored{};
  const std::string address(without_zone(text));
  if (::inet_pton(AF_INET6, address.c_str(), ignored.data()) == 1) return true;
  return address == text && ::inet_pton(AF_INET, address.c_str(), ignored.data()) == 1;
}

std::string_view without_zone(std::string_view address) {
  return address.substr(0, std::min(address.find('%'), address.size()));
}

bool is_host_name(std::string_view text) {
  if (is_address(text)) return true;
  return !text.empty() && text.size() < 254 && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_';
  });
}

Expected<AllowedHosts> AllowedHosts::of(const std::vector<std::string>& names) {
  AllowedHosts allowed;
  for (const std::string& name : names) {
    if (!is_host_name(name)) {
      return fail(
          "'{}' is no name of a computer; expected a name without 'https://' and without a port, "
          "for example flat.example.org",
          name);
    }
    allowed.names_.insert(small(name));
  }
  return allowed;
}

bool AllowedHosts::allows(std::string_view host_header) const {
  const std::string_view host = without_port(host_header);
  return is_address(host) || names_.contains(small(host));
}

}  // namespace roomwise::service
