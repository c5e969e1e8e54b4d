#include "roomwise/recording/personal_files.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"

namespace roomwise::recording {
namespace {

using image::PersonalData;
using roomwise::testing::ScratchFolder;

PersonalData facts_in(const char* text) {
  return personal_data_of_json(nlohmann::json::parse(text));
}

TEST(PersonalFiles, AreToldByTheNamesOfMembers) {
  EXPECT_EQ(facts_in(R"({"latitude": 50.1})"), (PersonalData{true, false, false}));
  EXPECT_EQ(facts_in(R"({"scan": [{"Device Model": "iPhone 15"}]})"),
            (PersonalData{false, true, false}));
  EXPECT_EQ(facts_in(R"({"ownerName": "Jane"})"), (PersonalData{false, false, true}));
  EXPECT_FALSE(facts_in(R"({"latitude": 0, "hasGPS": false, "device": "", "owner": null,
                            "time": 3, "numFaces": 4, "modifiedStatusRefinedModel": 1})")
                   .any())
      << "what is empty says nothing";
}

TEST(PersonalFiles, OfAFolderLoseThatAlone) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "a/b");
  const auto write = [&](const char* name, const auto& content) {
    EXPECT_OK(write_file(folder / name, content));
  };
  const Bytes plain = image::encode_jpeg(image::ColorImage(8, 6), 90);
  write("a/b/frame.json",
        std::string_view(R"({"time":104137.33988787502,"latitude":50.1,"at":[{"hasGPS":true}]})"));
  write("a/plain.json", std::string_view("{ \"time\": 1 }\n"));
  write("a/cut.json", std::string_view(R"({"latitude": 50.1)"));
  write("a/deep.json",
        std::string(100'000, '[') + R"({"latitude": 50.1})" + std::string(100'000, ']'));
  write("a/b/0.jpg", image::testing::with_exif(plain, image::testing::exif_with_place(1)));
  write("a/odometry.csv", std::string_view("timestamp\n"));
  write("a/cut.jpg", std::string_view("no picture"));
  ASSERT_OK(leave_out_personal_data(folder.path()));
  const auto text_of = [&](const char* name) { return read_text_file(folder / name).value(); };
  EXPECT_EQ(text_of("a/b/frame.json"), R"({"time":104137.33988787502,"at":[{}]})");
  EXPECT_EQ(text_of("a/plain.json"), "{ \"time\": 1 }\n") << "as it was";
  EXPECT_EQ(text_of("a/cut.json"), "") << "nobody knows what it says";
  EXPECT_EQ(text_of("a/deep.json"), "");
  EXPECT_EQ(read_file(folder / "a/b/0.jpg").value(), plain);
  EXPECT_EQ(text_of("a/odometry.csv"), "timestamp\n");
  EXPECT_EQ(text_of("a/cut.jpg"), "no picture");
}

TEST(PersonalFiles, AreToldByWhatTheyHoldHoweverTheyAreCalled) {
  const ScratchFolder folder;
  const Bytes plain = image::encode_jpeg(image::ColorImage(8, 6), 90);
  const Bytes tells = image::testing::with_exif(plain, image::testing::exif_with_place(1));
  for (const char* name : {"a.PNG", "b.WEBP", "c.Jpg", "d.heic", "e", "f.JSON"}) {
    EXPECT_OK(write_file(folder / name, tells));
  }
  EXPECT_OK(write_file(folder / "g.JSON", std::string_view(R"({"latitude":50.1,"time":1})")));
  for (const char* name :
       {"0.heic", "1.plist", "2.xml", "3.nmea", "4.xmp", "5", "GPS.csv", "location.txt"}) {
    EXPECT_OK(write_file(folder / name, std::string_view("latitude, 50.1")));
  }
  ASSERT_OK(leave_out_personal_data(folder.path()));
  for (const char* name : {"a.PNG", "b.WEBP", "c.Jpg", "d.heic", "e", "f.JSON"}) {
    EXPECT_EQ(read_file(folder / name).value(), plain) << name;
  }
  EXPECT_EQ(read_text_file(folder / "g.JSON").value(), R"({"time":1})");
  for (const char* name :
       {"0.heic", "1.plist", "2.xml", "3.nmea", "4.xmp", "5", "GPS.csv", "location.txt"}) {
    EXPECT_FALSE(std::filesystem::exists(folder / name)) << name << ": no reader needs it";
  }
}

}  // namespace
}  // namespace roomwise::recording
