#include "roomwise/evaluation/drawing/data_address.h"

#include <gtest/gtest.h>

#include <string_view>

namespace roomwise::evaluation {
namespace {

std::string of_text(std::string_view text) {
  return data_address("text/plain",
                      {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

TEST(DataAddress, HoldsBase64) {
  // The test vectors of RFC 4648.
  EXPECT_EQ(of_text(""), "data:text/plain;base64,");
  EXPECT_EQ(of_text("f"), "data:text/plain;base64,Zg==");
  EXPECT_EQ(of_text("fo"), "data:text/plain;base64,Zm8=");
  EXPECT_EQ(of_text("foo"), "data:text/plain;base64,Zm9v");
  EXPECT_EQ(of_text("foobar"), "data:text/plain;base64,Zm9vYmFy");
}

TEST(DataAddress, HoldsAJpeg) {
  const std::string address = jpeg_address(image::ColorImage(4, 3, {200, 10, 10}), 90);
  // A JPEG begins with FF D8 FF.
  EXPECT_TRUE(address.starts_with("data:image/jpeg;base64,/9j/")) << address.substr(0, 40);
}

}  // namespace
}  // namespace roomwise::evaluation
