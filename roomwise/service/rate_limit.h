#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace roomwise::service {

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
