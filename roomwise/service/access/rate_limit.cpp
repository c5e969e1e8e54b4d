#include "roomwise/service/access/rate_limit.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>

namespace roomwise::service {
namespace {
constexpr std::size_t kMaxKeys = 4096;

std::string address_text(int family, const unsigned char* bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  return ::inet_ntop(family, bytes, text.data(), text.size());
}
}  // namespace

std::string peer_key(std::string_view address) {
  // Behind '%' stands by which of this computer's networks it came.
  const std::string plain(address.substr(0, address.find('%')));
  in6_addr parsed{};
  if (::inet_pton(AF_INET6, plain.c_str(), &parsed) != 1) return std::string(address);
  std::array<unsigned char, 16> bytes{};
  std::copy_n(parsed.s6_addr, bytes.size(), bytes.begin());
  if (IN6_IS_ADDR_V4MAPPED(&parsed)) return address_text(AF_INET, bytes.data() + 12);
  std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
  return address_text(AF_INET6, bytes.data()) + "/64";
}

double RateLimit::left(const Bucket& bucket, double now_s) const {
  return std::min(burst_, bucket.left + rate_ * std::max(0.0, now_s - bucket.at_s));
}

bool RateLimit::take(const std::string& key, double now_s, double amount) {
  if (!buckets_.contains(key) && buckets_.size() >= kMaxKeys) {
    // Who has a full bucket again is as good as new; if all are in use, nobody new is served.
    std::erase_if(buckets_, [&](const auto& entry) { return left(entry.second, now_s) >= burst_; });
    if (buckets_.size() >= kMaxKeys) return false;
  }
  Bucket& bucket = buckets_.try_emplace(key, Bucket{burst_, now_s}).first->second;
  bucket = {left(bucket, now_s), now_s};
  if (bucket.left < amount) return false;
  bucket.left -= amount;
  return true;
}

void RateLimit::give_back(const std::string& key, double amount) {
  const auto found = buckets_.find(key);
  if (found == buckets_.end()) return;
  found->second.left = std::min(burst_, found->second.left + amount);
}

}  // namespace roomwise::service
