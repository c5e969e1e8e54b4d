#include "roomwise/service/rate_limit.h"

#include <algorithm>

namespace roomwise::service {
namespace {
constexpr std::size_t kMaxKeys = 4096;
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
