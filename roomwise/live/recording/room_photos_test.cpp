#include "roomwise/live/recording/room_photos.h"

#include <gmock/gmock.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/edits/undo_edit.h"

namespace roomwise::live {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Bytes photo(std::uint8_t level, int side_px = 200) {
  return image::encode_png(image::ColorImage(side_px, side_px, {level, level, level}));
}

class RoomPhotosFolder : public ::testing::Test {
 protected:
  void SetUp() override { make_rooms({"kitchen", "hall", "bath"}); }
  void make_rooms(const std::vector<std::string>& names) {
    std::vector<rooms::Room> rooms;
    for (const std::string& name : names) rooms.push_back({name, "kitchen"});
    ASSERT_OK(flat.replace_rooms(rooms));
  }
  Expected<void> rename(const std::string& room, const std::string& new_name) {
    ROOMWISE_RETURN_IF_ERROR(photos.begin_rename(room, new_name));
    make_rooms({new_name});
    return photos.settle(flat);
  }
  testing::ScratchFolder folder;
  RoomPhotos photos{folder / "photos"};
  home::Home flat = home::Home::create(folder / "a.home").value();
};

TEST_F(RoomPhotosFolder, AreCountedByRoomAndKeptWhenTheComputerStops) {
  EXPECT_THAT(photos.counts().value(), IsEmpty());
  EXPECT_EQ(photos.add("kitchen", photo(10)).value(), 1U);
  EXPECT_EQ(photos.add("kitchen", photo(20)).value(), 2U);
  EXPECT_EQ(photos.add("kitchen", photo(20)).value(), 2U) << "the same again";
  EXPECT_EQ(photos.add("bath/toilet", photo(10)).value(), 1U);
  const RoomPhotos later(folder / "photos");
  EXPECT_THAT(later.counts().value(),
              ElementsAre(RoomPhotos::Count{"bath/toilet", 1}, RoomPhotos::Count{"kitchen", 2}));
  EXPECT_EQ(later.all()->size(), 3U);
}

TEST_F(RoomPhotosFolder, KeepNothingOfWhereAndByWhomTheyWereTaken) {
  const Bytes plain = image::encode_jpeg(image::ColorImage(200, 200), 90);
  const Bytes sent = image::testing::with_exif(plain, image::testing::exif_with_place(1));
  EXPECT_EQ(photos.add("kitchen", sent).value(), 1U);
  EXPECT_EQ(photos.add("kitchen", sent).value(), 1U) << "the same again";
  EXPECT_EQ(read_file(photos.all()->front().path).value(), plain);
}

TEST_F(RoomPhotosFolder, WhatIsNoPhotoIsRefused) {
  EXPECT_ERROR(photos.add("kitchen", Bytes{1, 2, 3}), "neither a JPEG");
  EXPECT_ERROR(photos.add("kitchen", photo(1, 100)), "at least 160 a side");
  EXPECT_FALSE(photos.add("", photo(1)));
  for (const char* unfit : {"\x1b[31mkitchen", "\u202ekitchen", "\u200b", "kit\u0085chen", "…"}) {
    EXPECT_FALSE(photos.add(unfit, photo(1))) << unfit;
  }
  EXPECT_THAT(photos.counts().value(), IsEmpty());
}

TEST_F(RoomPhotosFolder, TakeNoMoreOfTheDiskThanIsKeptForThem) {
  const std::uint64_t one = photo(1).size();
  RoomPhotos few(folder / "few", {.max_bytes = 2 * one + 100, .reserve_bytes = 0});
  ASSERT_OK(few.add("kitchen", photo(1)));
  ASSERT_OK(few.add("hall", photo(2)));
  ASSERT_OK(few.set_aside("hall"));
  const auto third = few.add("kitchen", photo(3));
  EXPECT_ERROR(third, "take photos of a room away");
  EXPECT_EQ(third.error().code, ErrorCode::kDiskFull);
  EXPECT_EQ(few.add("kitchen", photo(1)).value(), 1U) << "it is there";
  EXPECT_EQ(few.all()->size(), 1U) << "nothing is left of what was refused";
  ASSERT_OK(few.forget_set_aside());
  EXPECT_EQ(few.add("kitchen", photo(3)).value(), 2U);
  EXPECT_ERROR(few.add("kitchen", photo(4)), "take photos of a room away");
  ASSERT_OK(few.remove("kitchen"));
  EXPECT_EQ(few.add("hall", photo(4)).value(), 1U);
  RoomPhotos later(folder / "few", {.max_bytes = one + 100, .reserve_bytes = 0});
  EXPECT_ERROR(later.add("hall", photo(5)), "take photos of a room away");  // with those of before
}

TEST_F(RoomPhotosFolder, LeaveSomeOfTheDiskFree) {
  std::uint64_t free = 1'000'000;
  RoomPhotos careful(folder / "careful", {.reserve_bytes = 900'000, .free_bytes = [&](const auto&) {
                                            return Expected<std::uint64_t>(free);
                                          }});
  EXPECT_EQ(careful.add("kitchen", photo(1)).value(), 1U);
  free = 900'001;
  EXPECT_ERROR(careful.add("kitchen", photo(2)), "free some space");
  EXPECT_EQ(careful.all()->size(), 1U);
}

TEST_F(RoomPhotosFolder, AreRenamedAndRemovedWithTheirRoom) {
  EXPECT_TRUE(photos.add("kitchen", photo(1)));
  EXPECT_TRUE(photos.add("hall", photo(2)));
  ASSERT_OK(rename("kitchen", "galley"));
  ASSERT_OK(rename("nowhere", "anywhere"));
  EXPECT_ERROR(rename("galley", "hall"), "already");
  EXPECT_THAT(photos.counts().value(),
              ElementsAre(RoomPhotos::Count{"galley", 1}, RoomPhotos::Count{"hall", 1}));
  ASSERT_OK(photos.remove("galley"));
  EXPECT_THAT(photos.counts().value(), ElementsAre(RoomPhotos::Count{"hall", 1}));
  ASSERT_OK(photos.remove_all());
  EXPECT_FALSE(std::filesystem::exists(folder / "photos"));
}

TEST_F(RoomPhotosFolder, ANameThatARoomGaveUpCanBeGivenAgain) {
  EXPECT_TRUE(photos.add("kitchen", photo(1)));
  ASSERT_OK(rename("kitchen", "galley"));
  EXPECT_TRUE(photos.add("kitchen", photo(2)));
  EXPECT_EQ(photos.add("galley", photo(3)).value(), 2U);
  EXPECT_THAT(photos.counts().value(),
              ElementsAre(RoomPhotos::Count{"galley", 2}, RoomPhotos::Count{"kitchen", 1}));
  ASSERT_OK(photos.remove("galley"));
  EXPECT_THAT(photos.counts().value(), ElementsAre(RoomPhotos::Count{"kitchen", 1}));
}

// As where the computer stops between the change of the home and that of the photos.
TEST_F(RoomPhotosFolder, FollowTheRoomsThatTheHomeHas) {
  for (const std::string room : {"kitchen", "hall", "bath"}) {
    EXPECT_TRUE(photos.add(room, photo(1)));
  }
  ASSERT_OK(photos.begin_rename("kitchen", "galley"));
  ASSERT_OK(photos.begin_rename("hall", "corridor"));
  ASSERT_OK(photos.set_aside("bath"));
  EXPECT_THAT(photos.counts().value(),
              ElementsAre(RoomPhotos::Count{"hall", 1}, RoomPhotos::Count{"kitchen", 1}));
  ASSERT_OK(pipeline::rename_room(flat, {}, "kitchen", "galley"));
  const home::EditId removal = pipeline::remove_room(flat, {}, "bath").value();
  RoomPhotos later(folder / "photos");
  ASSERT_OK(later.settle(flat));
  EXPECT_THAT(later.counts().value(),
              ElementsAre(RoomPhotos::Count{"galley", 1}, RoomPhotos::Count{"hall", 1}));
  ASSERT_OK(pipeline::undo_edit(flat, removal));
  ASSERT_OK(pipeline::rename_room(flat, {}, "hall", "corridor"));
  ASSERT_OK(later.settle(flat));
  EXPECT_THAT(later.counts().value(),
              ElementsAre(RoomPhotos::Count{"bath", 1}, RoomPhotos::Count{"galley", 1},
                          RoomPhotos::Count{"hall", 1}))
      << "a name that was dropped is not given later";
}

TEST_F(RoomPhotosFolder, ThereAreEnoughAtSomeNumber) {
  for (std::size_t i = 0; i < RoomPhotos::kMaxPerRoom; ++i) {
    EXPECT_TRUE(photos.add("hall", photo(static_cast<std::uint8_t>(i))));
  }
  EXPECT_ERROR(photos.add("hall", photo(200)), "which is enough");
}

}  // namespace
}  // namespace roomwise::live
