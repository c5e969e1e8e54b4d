// Pictures that a passphrase protects.

#include <csignal>
#include <fstream>
#include <string_view>

#include "roomwise/base/random.h"
#include "roomwise/home/picture_cipher.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::size_t kKeyframes = 4;
// The least that libsodium takes: a test tries passphrases often.
constexpr PassphraseCost kCheap{.passes = 1, .memory_bytes = 8192};

Passphrase phrase(std::string_view text) {
  return Passphrase::from(text).value();
}
OpenOptions with(std::string_view text) {
  return {std::make_shared<const Passphrase>(phrase(text))};
}

// A picture that occurs nowhere else.
Bytes unique_picture(std::uint64_t seed, std::size_t size) {
  RandomStream stream(seed, {size});
  Bytes bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(stream.index(256));
  return bytes;
}
KeyframeImages unique_images(KeyframeId id) {
  return {unique_picture(id, 3000), unique_picture(id, 9001)};
}
Bytes unique_depth_view(KeyframeId id) {
  return unique_picture(100 + id, 4000);
}
objects::KeyframeDetections unique_look(KeyframeId id) {
  objects::KeyframeDetections look = testing::sample_look(id);
  look.coarse_depth = image::DepthImage(40, 30);
  const Bytes bytes = unique_picture(id, look.coarse_depth.pixels().size_bytes());
  std::memcpy(look.coarse_depth.pixels().data(), bytes.data(), bytes.size());
  return look;
}

MapCommit unique_step(KeyframeId id) {
  MapCommit step = testing::sample_commit(1, 1, id);
  step.keyframes[0].images = unique_images(id);
  step.keyframes[0].depth_views[0].encoded_depth = unique_depth_view(id);
  return step;
}

void fill_with_unique_pictures(Home& home) {
  ROOMWISE_MUST(home.add_recording(testing::sample_recording()));
  ROOMWISE_MUST(home.add_network(testing::sample_network()));
  ROOMWISE_MUST(home.add_region_finder({"finder", "f1nd", {"couch", "bed"}}));
  for (KeyframeId id = 0; id < kKeyframes; ++id) {
    ROOMWISE_MUST(home.commit(unique_step(id)));
    ROOMWISE_MUST(home.put_detections(id, 1, unique_look(id)));
  }
}

class ProtectedHome : public ::testing::Test {
 protected:
  // Closed and not protected; its digest.
  std::string make() const {
    Home home = Home::create(path_).value();
    fill_with_unique_pictures(home);
    return home.content_digest().value();
  }
  std::string make_protected(std::string_view passphrase) const {
    std::string digest = make();
    Home home = Home::open(path_).value();
    EXPECT_EQ(home.protect(phrase(passphrase), kCheap).value(), 4 * kKeyframes);
    return digest;
  }
  static void expect_all_pictures(const Home& home) {
    const auto looks = home.detections(1);
    ASSERT_OK(looks);
    for (KeyframeId id = 0; id < kKeyframes; ++id) {
      EXPECT_EQ(home.images(id).value(), unique_images(id));
      EXPECT_EQ(looks->at(id).coarse_depth, unique_look(id).coarse_depth);
    }
    const auto views = home.depth_views();
    ASSERT_OK(views);
    for (const DepthView& view : *views) {
      EXPECT_EQ(home.depth_view_image(view.id).value(), unique_depth_view(view.keyframe));
    }
  }
  // How many pieces of sixteen bytes of the pictures stand in the home's files.
  [[nodiscard]] std::size_t plain_pieces() const {
    std::string files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      files += read_text_file(entry.path()).value();
    }
    std::size_t found = 0;
    const auto count = [&](std::span<const std::uint8_t> bytes) {
      constexpr std::size_t kPiece = 16;
      for (std::size_t i = 0; i + kPiece <= bytes.size(); i += 256) {
        const std::string_view piece(reinterpret_cast<const char*>(&bytes[i]), kPiece);
        if (files.find(piece) != std::string::npos) ++found;
      }
    };
    for (KeyframeId id = 0; id < kKeyframes; ++id) {
      count(unique_images(id).color);
      count(unique_images(id).depth);
      count(unique_depth_view(id));
      count(unique_picture(id, 40 * 30 * 2));
    }
    return found;
  }
  void run_sql(const std::string& sql) const {
    Database database = Database::open(path_, Database::Access::kReadWrite).value();
    ASSERT_OK(database.run_script(sql));
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a.home";
};

TEST_F(ProtectedHome, HoldsTheSameAndShowsItToWhoHasThePassphrase) {
  const std::string digest = make_protected("open sesame");
  for (const bool writes : {false, true}) {
    const auto home = writes ? Home::open(path_, with("open sesame"))
                             : Home::open_read_only(path_, with("open sesame"));
    ASSERT_OK(home);
    EXPECT_TRUE(home->is_protected());
    EXPECT_FALSE(home->is_locked());
    expect_all_pictures(*home);
    EXPECT_OK(home->verify());
    EXPECT_EQ(home->content_digest().value(), digest);
  }
}

TEST_F(ProtectedHome, LeavesNothingOfThePicturesInTheFiles) {
  make();
  EXPECT_GT(plain_pieces(), 200U) << "the search finds what is there";
  {
    Home home = Home::open(path_).value();
    ASSERT_OK(home.protect(phrase("open sesame"), kCheap));
    EXPECT_EQ(plain_pieces(), 0U) << "while it is open, with its log";
  }
  EXPECT_EQ(plain_pieces(), 0U);
}

TEST_F(ProtectedHome, WithoutItsPassphraseAnswersAllButPictures) {
  make_protected("open sesame");
  Home home = Home::open(path_).value();
  EXPECT_TRUE(home.is_locked());
  EXPECT_THAT(home.keyframes().value(), SizeIs(kKeyframes));
  EXPECT_THAT(home.frames(1).value(), SizeIs(10));
  EXPECT_OK(home.confirmed_objects());
  EXPECT_OK(home.rooms());
  EXPECT_OK(home.instances());
  EXPECT_OK(home.verify());
  EXPECT_TRUE(home.settings()->empty()) << "how it is protected is no setting of the map";
  EXPECT_OK(home.replace_rooms(std::vector<rooms::Room>{{"hall", "corridor"}}));
  const char* why = "a.home: its pictures are protected by a passphrase; give the file";
  EXPECT_ERROR(home.images(0), why);
  EXPECT_ERROR(home.detections(1), why);
  EXPECT_ERROR(home.content_digest(), why);
  EXPECT_ERROR(home.commit(unique_step(kKeyframes)), why);
  EXPECT_ERROR(home.put_detections(0, 1, unique_look(0)), why);
  EXPECT_ERROR(home.protect(phrase("mine"), kCheap), why);
  EXPECT_ERROR(home.unprotect(phrase("mine"), kCheap), why);
  EXPECT_ERROR(home.put_setting(kProtectionSetting, "{}"), "no setting of a map");
}

TEST_F(ProtectedHome, RefusesAnotherPassphrase) {
  make_protected("open sesame");
  EXPECT_ERROR(Home::open(path_, with("open sesamE")), "a.home: the passphrase is wrong");
  EXPECT_ERROR(Home::open_read_only(path_, with("x")), "a.home: the passphrase is wrong");
}

TEST_F(ProtectedHome, APassphraseForAHomeWithoutProtectionIsAMistake) {
  make();
  EXPECT_ERROR(Home::open(path_, with("open sesame")),
               "a passphrase was given, but its pictures are not protected; protect them by: "
               "roomwise protect");
  EXPECT_ERROR(Home::open_read_only(path_, with("open sesame")), "are not protected");
}

TEST_F(ProtectedHome, ThatIsNewSealsItsPicturesFromTheStart) {
  {
    Home home = Home::create(path_, with("open sesame")).value();
    fill_with_unique_pictures(home);
    expect_all_pictures(home);
    EXPECT_EQ(plain_pieces(), 0U) << "nor in its log";
  }
  EXPECT_EQ(plain_pieces(), 0U);
  const Home home = Home::open_read_only(path_, with("open sesame")).value();
  expect_all_pictures(home);
  ScratchFolder elsewhere;
  Home plain = Home::create(elsewhere / "b.home").value();
  fill_with_unique_pictures(plain);
  EXPECT_EQ(home.content_digest().value(), plain.content_digest().value());
}

TEST_F(ProtectedHome, SealsWhatIsAddedLater) {
  make();
  {
    Home home = Home::open(path_).value();
    ASSERT_OK(home.remove_recording(1));
    ASSERT_OK(home.erase_removed());
    ASSERT_OK(home.protect(phrase("open sesame"), kCheap));
  }
  Home home = Home::open(path_, with("open sesame")).value();
  ASSERT_OK(home.add_recording(testing::sample_recording()));
  for (KeyframeId id = 0; id < kKeyframes; ++id) {
    ASSERT_OK(home.commit(unique_step(id)));
    ASSERT_OK(home.put_detections(id, 1, unique_look(id)));
  }
  expect_all_pictures(home);
  EXPECT_EQ(plain_pieces(), 0U);
}

TEST_F(ProtectedHome, SealsPicturesAnewWhoseKeyframesGetOtherNumbers) {
  make_protected("open sesame");
  {
    Home home = Home::open(path_, with("open sesame")).value();
    ASSERT_EQ(home.add_recording(testing::sample_recording()).value(), 2);
    MapCommit step = unique_step(0);
    step.recording = 2;
    step.keyframes[0].id = kKeyframes;
    step.frames.back().place->keyframe = kKeyframes;
    ASSERT_OK(home.commit(step));
    ASSERT_OK(home.remove_recording(1));
    EXPECT_EQ(home.images(0).value(), unique_images(0));
    ASSERT_OK(home.verify());
  }
  Home locked = Home::open(path_).value();
  EXPECT_FALSE(locked.images(0));
}

TEST_F(ProtectedHome, SealsPicturesAnewOfKeyframesBehindCulledOnes) {
  make_protected("open sesame");
  Home home = Home::open(path_, with("open sesame")).value();
  KeyframeCulling culling;
  culling.culled = {0};
  const auto frames = home.frames(1).value();
  for (const Frame& frame : frames) {
    if (frame.place && frame.place->keyframe == 0)
      culling.places.push_back({1, frame.index, {1, testing::sample_pose(2)}});
  }
  ASSERT_OK(home.cull_keyframes(culling));
  for (KeyframeId id = 0; id + 1 < kKeyframes; ++id)
    EXPECT_EQ(home.images(id).value(), unique_images(id + 1));
  const auto views = home.depth_views().value();
  ASSERT_THAT(views, SizeIs(kKeyframes - 1));
  for (const DepthView& view : views)
    EXPECT_EQ(home.depth_view_image(view.id).value(), unique_depth_view(view.keyframe + 1));
  ASSERT_OK(home.verify());
}

TEST_F(ProtectedHome, TakesAnotherPassphraseWithoutTouchingThePictures) {
  const std::string digest = make_protected("open sesame");
  const auto stored = [&] {
    return Database::open(path_, Database::Access::kReadOnly)
        ->get<Bytes>("SELECT depth FROM keyframe_images WHERE keyframe_id = 2")
        .value();
  };
  const Bytes before = stored();
  {
    Home home = Home::open(path_, with("open sesame")).value();
    EXPECT_EQ(home.protect(phrase("another"), kCheap).value(), 0U);
    expect_all_pictures(home);
  }
  EXPECT_EQ(stored(), before);
  EXPECT_ERROR(Home::open(path_, with("open sesame")), "the passphrase is wrong");
  const Home home = Home::open_read_only(path_, with("another")).value();
  expect_all_pictures(home);
  EXPECT_EQ(home.content_digest().value(), digest);
}

TEST_F(ProtectedHome, BecomesAPlainOneAgain) {
  const std::string digest = make_protected("open sesame");
  {
    Home home = Home::open(path_, with("open sesame")).value();
    EXPECT_EQ(home.unprotect(phrase("open sesame"), kCheap).value(), 4 * kKeyframes);
    expect_all_pictures(home);
    EXPECT_ERROR(home.unprotect(phrase("open sesame"), kCheap), "are not protected");
  }
  const Home home = Home::open_read_only(path_).value();
  EXPECT_FALSE(home.is_protected());
  expect_all_pictures(home);
  EXPECT_EQ(home.content_digest().value(), digest);
}

TEST_F(ProtectedHome, AReaderFromBeforeIsToldAndKeepsItFromBeingFinished) {
  make();
  Home writer = Home::open(path_).value();
  {
    const Home reader = Home::open_read_only(path_).value();
    // A reader that only has the file open keeps nothing back; one that is in the middle does.
    Statement reading =
        const_cast<Home&>(reader).database().prepare("SELECT color FROM keyframe_images").value();
    ASSERT_TRUE(reading.step().value());
    EXPECT_ERROR(writer.protect(phrase("open sesame"), kCheap), "another program reads the home");
  }
  const Home reader = Home::open_read_only(path_).value();
  ASSERT_OK(writer.protect(phrase("open sesame"), kCheap));
  EXPECT_EQ(plain_pieces(), 0U);
  EXPECT_ERROR(reader.images(0), "are protected by a passphrase");
}

// ---- pictures that somebody changed ----

TEST_F(ProtectedHome, RefusesPicturesThatWereChanged) {
  make_protected("open sesame");
  const Bytes whole = read_file(path_).value();
  const std::string wrong =
      "a.home: a picture of key-frame 1 was changed since it was sealed, or "
      "is another's";
  for (const std::string change : {
           // another key-frame's, the other kind
           "color = (SELECT color FROM keyframe_images WHERE keyframe_id = 2)",
           "color = depth",
           // a byte, whichever the random seal made it; the end, the beginning, only the mark
           "color = CAST(substr(color, 1, 2000) ||"
           " CASE substr(color, 2001, 1) WHEN x'00' THEN x'01' ELSE x'00' END ||"
           " substr(color, 2002) AS BLOB)",
           "color = substr(color, 1, length(color) - 1)",
           "color = substr(color, 1, 20)",
           "color = substr(color, 1, 8)",
           "color = x''",
           // one that was never sealed
           "color = x'ffd8ff'",
       }) {
    std::filesystem::remove(path_);
    ASSERT_OK(write_file(path_, whole));
    run_sql("UPDATE keyframe_images SET " + change + " WHERE keyframe_id = 1");
    const Home home = Home::open_read_only(path_, with("open sesame")).value();
    SCOPED_TRACE(change);
    EXPECT_ERROR(home.images(1), wrong);
    EXPECT_ERROR(home.verify(), wrong);
    EXPECT_ERROR(home.content_digest(), wrong);
    EXPECT_EQ(home.images(2).value(), unique_images(2));
  }
}

TEST_F(ProtectedHome, FindsADepthImageBetweenPicturesThatWasChanged) {
  make_protected("open sesame");
  EXPECT_OK(Home::open_read_only(path_, with("open sesame"))->verify());
  run_sql(
      "UPDATE keyframe_depth_views SET depth = substr(depth, 1, length(depth) - 1) "
      "WHERE keyframe_id = 1");
  const Home home = Home::open_read_only(path_, with("open sesame")).value();
  const HomeCheck found = home.check().value();
  EXPECT_FALSE(found.is_whole());
  ASSERT_EQ(found.lost_pictures.size(), 1U);
  EXPECT_EQ(found.lost_pictures.begin()->first, 1U);
  const auto views = home.depth_views().value();
  const auto view = std::ranges::find(views, KeyframeId{1}, &DepthView::keyframe);
  EXPECT_ERROR(home.verify(), fmt::format("depth image {} between pictures was changed", view->id));
  EXPECT_TRUE(Home::open_read_only(path_)->check()->is_whole()) << "it cannot be looked at";
}

TEST_F(ProtectedHome, FindsAThingWhosePicturesWereChanged) {
  make_protected("open sesame");
  Home writer = Home::open(path_, with("open sesame")).value();
  ASSERT_OK(testing::teach(writer, testing::sample_own_thing()));
  EXPECT_OK(Home::open_read_only(path_, with("open sesame"))->verify());
  run_sql("UPDATE own_thing_views SET mask = substr(mask, 1, length(mask) - 1)");
  const Home home = Home::open_read_only(path_, with("open sesame")).value();
  EXPECT_THAT(home.check()->lost_own_things, SizeIs(1));
  EXPECT_ERROR(home.verify(), "a thing that somebody taught");
  EXPECT_TRUE(Home::open_read_only(path_)->check()->is_whole()) << "it cannot be looked at";
}

TEST_F(ProtectedHome, RefusesAKeyThatWasChanged) {
  make_protected("open sesame");
  const Bytes whole = read_file(path_).value();
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::filesystem::remove(path_);
    EXPECT_OK(write_file(path_, whole));
    run_sql(fmt::format("UPDATE settings SET value = replace(value, '{}', '{}')", from, to));
    return Home::open_read_only(path_, with("open sesame"));
  };
  EXPECT_OK(changed("nothing", "else"));
  // Else plain pictures could be put among the sealed ones.
  EXPECT_ERROR(changed("\"sealed\"", "\"sealing\""), "the passphrase is wrong (or");
  EXPECT_ERROR(changed("\"passes\":1", "\"passes\":2"), "the passphrase is wrong (or");
  const char* unreadable = "a.home: is damaged: the key of its pictures cannot be read";
  EXPECT_ERROR(changed("\"passes\":1", "\"passes\":100000"), unreadable);
  EXPECT_ERROR(changed(":8192", ":81920000000000"), unreadable);
  EXPECT_ERROR(changed(":8192", ":-8192"), unreadable);
  EXPECT_ERROR(changed("\"salt\":\"", "\"salt\":\"zz"), unreadable);
  EXPECT_ERROR(changed("\"key\":\"", "\"other\":\""), unreadable);
  EXPECT_ERROR(changed("{", ""), unreadable);
}

// ---- killed on the way ----

// Runs `work` on the closed home, killed when `count` statements have begun; whether it was.
bool killed_at(const std::filesystem::path& path, const OpenOptions& options, int count,
               const std::function<bool(Home&)>& work) {
  const int status = testing::run_in_child([&] {
    Home home = Home::open(path, options).value();
    int left = count;
    const auto on_statement = [](unsigned, void* data, void*, void*) {
      if (--*static_cast<int*>(data) == 0) ::kill(::getpid(), SIGKILL);
      return 0;
    };
    sqlite3_trace_v2(home.database().handle(), SQLITE_TRACE_STMT, on_statement, &left);
    const bool done = work(home);
    sqlite3_trace_v2(home.database().handle(), 0, nullptr, nullptr);
    return done ? 3 : 4;
  });
  EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 3);
  return WIFSIGNALED(status);
}

class KilledWhileProtecting : public ProtectedHome {
 protected:
  void restore(const Bytes& whole) const {
    for (const char* suffix : {"", "-wal", "-shm", "-lock"}) {
      std::filesystem::remove(path_.string() + suffix);
    }
    ASSERT_OK(write_file(path_, whole));
  }
};

TEST_F(KilledWhileProtecting, LeavesAHomeThatProtectFinishes) {
  const std::string digest = make();
  const Bytes whole = read_file(path_).value();
  const auto protect = [](Home& home) {
    return home.protect(phrase("open sesame"), kCheap).has_value();
  };
  int statement = 1;
  bool was_between = false;
  for (; killed_at(path_, {}, statement, protect); ++statement) {
    const bool is_protected = Home::open_read_only(path_)->is_protected();
    const OpenOptions options = is_protected ? with("open sesame") : OpenOptions{};
    {
      auto home = Home::open(path_, options);
      ASSERT_OK(home);
      expect_all_pictures(*home);
      EXPECT_OK(home->verify());
      EXPECT_EQ(home->content_digest().value(), digest) << "killed at statement " << statement;
      const std::size_t sealed = home->protect(phrase("open sesame"), kCheap).value();
      was_between = was_between || (sealed > 0 && sealed < 4 * kKeyframes);
    }
    EXPECT_EQ(plain_pieces(), 0U) << "killed at statement " << statement;
    const Home home = Home::open_read_only(path_, with("open sesame")).value();
    expect_all_pictures(home);
    restore(whole);
  }
  EXPECT_GT(statement, 30);
  EXPECT_TRUE(was_between);
}

TEST_F(KilledWhileProtecting, LeavesAHomeThatRemovingFinishes) {
  const std::string digest = make_protected("open sesame");
  const Bytes whole = read_file(path_).value();
  const auto unprotect = [](Home& home) {
    return home.unprotect(phrase("open sesame"), kCheap).has_value();
  };
  int statement = 1;
  for (; killed_at(path_, with("open sesame"), statement, unprotect); ++statement) {
    if (Home::open_read_only(path_)->is_protected()) {
      Home home = Home::open(path_, with("open sesame")).value();
      expect_all_pictures(home);
      // What was begun can be finished, and it can be undone.
      ASSERT_OK(statement % 2 == 0 ? home.unprotect(phrase("open sesame"), kCheap)
                                   : home.protect(phrase("open sesame"), kCheap));
      EXPECT_EQ(home.is_protected(), statement % 2 == 1);
      expect_all_pictures(home);
      EXPECT_EQ(home.content_digest().value(), digest);
    }
    restore(whole);
  }
  EXPECT_GT(statement, 20);
}

// ---- passphrases ----

TEST(APassphrase, IsReadFromAFileWithoutItsLineEnd) {
  ScratchFolder folder;
  const auto read = [&](std::string_view content) {
    EXPECT_OK(write_file(folder / "phrase", content));
    return Passphrase::read(folder / "phrase");
  };
  EXPECT_TRUE(read("grün und blau\n").value() == phrase("grün und blau"));
  EXPECT_TRUE(read("grün und blau\r\n").value() == phrase("grün und blau"));
  EXPECT_TRUE(read(" two\nlines").value() == phrase(" two\nlines"));
  EXPECT_FALSE(read("a").value() == phrase("b"));
  EXPECT_FALSE(read("a").value() == phrase("ab"));
  EXPECT_ERROR(read(""), "phrase: the passphrase is empty");
  EXPECT_ERROR(read("\n"), "the passphrase is empty");
  EXPECT_OK(read(std::string(1024, 'x') + "\n"));
  EXPECT_ERROR(read(std::string(1025, 'x')), "longer than 1024 bytes");
  EXPECT_ERROR(read(std::string(5000, 'x')), "longer than 1024 bytes");
  EXPECT_ERROR(Passphrase::read(folder / "nothing"), "nothing: cannot be read");
  EXPECT_ERROR(Passphrase::read(folder.path()), "cannot be read");
}

TEST(ThePictureCipher, SealsTheSamePictureDifferentlyEachTime) {
  const PictureCipher cipher = PictureCipher::create();
  const Bytes picture = unique_picture(1, 100);
  const Bytes sealed = cipher.seal(1, PictureKind::kColor, picture);
  EXPECT_TRUE(is_sealed(sealed));
  EXPECT_NE(cipher.seal(1, PictureKind::kColor, picture), sealed);
  EXPECT_EQ(cipher.open(1, PictureKind::kColor, sealed).value(), picture);
  EXPECT_FALSE(cipher.open(2, PictureKind::kColor, sealed));
  EXPECT_FALSE(cipher.open(1, PictureKind::kDepth, sealed));
  EXPECT_FALSE(PictureCipher::create().open(1, PictureKind::kColor, sealed));
  for (std::size_t i = 0; i < sealed.size(); ++i) {
    Bytes changed = sealed;
    changed[i] ^= 1U;
    EXPECT_FALSE(cipher.open(1, PictureKind::kColor, changed)) << i;
    EXPECT_FALSE(cipher.open(1, PictureKind::kColor, std::span(sealed).first(i)));
  }
  EXPECT_EQ(cipher.open(3, PictureKind::kDepth, cipher.seal(3, PictureKind::kDepth, {})).value(),
            Bytes());
}

}  // namespace
}  // namespace roomwise::home
