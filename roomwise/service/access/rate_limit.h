#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace roomwise::service {

// Whose limits hold for what comes from that address: its own, but of IPv6 those of its network of
// 64 bits, out of which one computer may take as many addresses as it likes. "2001:db8:1:2::7"
// counts as "2001:db8:1:2::/64"; what is no address, as itself.
[[nodiscard]] std::string peer_key(std::string_view address);

// Token buckets: each key may do `burst` things at once and then `rate` a second. Holds a bounded
// number of keys. Not thread-safe.
class RateLimit {
 public:
  RateLimit(double burst, double rate) : burst_(burst), rate_(rate) {}

  // Whether the key may do one more thing now, or `amount` of them.
  [[nodiscard]] bool take(const std::string& key, double now_s, double amount = 1);
  // That the last one counts no more.
  void give_back(const std::string& key, double amount = 1);
  [[nodiscard]] std::size_t keys() const { return buckets_.size(); }

 private:
  struct Bucket {
    double left = 0;
    double at_s = 0;
  };
  [[nodiscard]] double left(const Bucket& bucket, double now_s) const;

  double burst_;
  double rate_;
  std::map<std::string, Bucket> buckets_;
};

}  // namespace roomwise::service
