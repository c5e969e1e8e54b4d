#include "roomwise/service/credentials/allowed_hosts.h"

#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::service {
namespace {

TEST(AllowedHostsTest, NamesAreThoseOfTheListAndAddressesAlwaysAreAllowed) {
  const AllowedHosts hosts = AllowedHosts::of({"localhost", "Flat.local", "127.0.0.1"}).value();
  for (const char* ours : {"localhost", "LOCALHOST:8443", "flat.local", "flat.local.:8443",
                           "127.0.0.1:8443", "192.168.7.9", "[::1]:8443", "[fe80::1%25eth0]"}) {
    EXPECT_TRUE(hosts.allows(ours)) << ours;
  }
  for (const char* foreign :
       {"", "evil.example", "flat.local.evil.example:8443", "xflat.local", "local", "[", "1.2.3",
        "127.0.0.1.evil.example", "[evil.example]", "127.0.0.1%1"}) {
    EXPECT_FALSE(hosts.allows(foreign)) << foreign;
  }
}

TEST(AllowedHostsTest, WhatIsNoNameIsRefusedInWords) {
  for (const char* bad : {"", "https://flat.local", "flat.local:8443", "a b", "*.local"}) {
    EXPECT_ERROR(AllowedHosts::of({bad}), "without 'https://' and without a port");
  }
}

}  // namespace
}  // namespace roomwise::service
