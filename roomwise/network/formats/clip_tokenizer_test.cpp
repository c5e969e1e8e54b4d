#include "roomwise/network/formats/clip_tokenizer.h"

#include <gmock/gmock.h>
#include <zlib.h>

#include <cstdlib>
#include <fstream>

#include "roomwise/base/testing/testing.h"

namespace roomwise::network {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

class ClipTokenizerTest : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name) << text;
    return folder_.path() / name;
  }

  roomwise::testing::ScratchFolder folder_;
};

// A made list: 256 bytes, the same at a word's end, then these, then the marks.
constexpr const char* kMerges =
    "#version: 0.2\n"
    "t h\n"       // 512
    "th e</w>\n"  // 513
    "c a\n"       // 514
    "ca t</w>\n"  // 515
    "a t</w>\n"   // 516
    "Ã ¼\n"       // 517: the two bytes of ü
    "h a\n";      // 518, marks 519 and 520

// The number of a byte that can be seen as a character of ASCII, within a word; 256 more at its
// end.
std::int64_t byte(char letter) {
  return letter - '!';
}
std::int64_t last(char letter) {
  return 256 + byte(letter);
}

TEST_F(ClipTokenizerTest, JoinsPairsInTheOrderOfTheList) {
  const auto tokenizer = ClipTokenizer::read(write("merges.txt", kMerges));
  ASSERT_OK(tokenizer);
  EXPECT_EQ(tokenizer->size(), 521U);
  EXPECT_THAT(*tokenizer->encode("the cat"), ElementsAre(513, 515));
  // "t h" comes before "h a", wherever in the word both could be.
  EXPECT_THAT(*tokenizer->encode("that"), ElementsAre(512, 516));
  EXPECT_THAT(*tokenizer->encode("hath"), ElementsAre(518, byte('t'), last('h')));
  EXPECT_THAT(*tokenizer->encode("a"), ElementsAre(last('a')));
  EXPECT_THAT(*tokenizer->encode("ththe"), ElementsAre(512, 513));
}

TEST_F(ClipTokenizerTest, PartsWords) {
  const auto tokenizer = ClipTokenizer::read(write("merges.txt", kMerges));
  ASSERT_OK(tokenizer);
  EXPECT_THAT(*tokenizer->encode("  THE \t\n Cat\xC2\xA0the "), ElementsAre(513, 515, 513));
  EXPECT_THAT(*tokenizer->encode("the42"), ElementsAre(513, last('4'), last('2')));
  EXPECT_THAT(*tokenizer->encode("a!?a"), ElementsAre(last('a'), byte('!'), last('?'), last('a')));
  EXPECT_THAT(*tokenizer->encode("cat's"), ElementsAre(515, byte('\''), last('s')));
  EXPECT_THAT(*tokenizer->encode("cat'x"), ElementsAre(515, last('\''), last('x')));
  EXPECT_THAT(*tokenizer->encode("x'll"), ElementsAre(last('x'), byte('\''), byte('l'), last('l')));
  EXPECT_THAT(*tokenizer->encode(""), ElementsAre());
}

TEST_F(ClipTokenizerTest, LettersBeyondAsciiAreBytes) {
  const auto tokenizer = ClipTokenizer::read(write("merges.txt", kMerges));
  ASSERT_OK(tokenizer);
  // Both cases: U+00DC and U+00FC, within a word.
  EXPECT_THAT(*tokenizer->encode("\xC3\xBC"
                                 "a"),
              ElementsAre(517, last('a')));
  EXPECT_THAT(*tokenizer->encode("\xC3\x9C"
                                 "a"),
              ElementsAre(517, last('a')));
  // No UTF-8: U+FFFD, three bytes.
  EXPECT_EQ(tokenizer->encode("\xFF")->size(), 3U);
  EXPECT_EQ(tokenizer->encode("\xC3")->size(), 3U);
}

// As Unicode has letters, numbers and spaces, whatever the system's locales say.
TEST_F(ClipTokenizerTest, PartsWordsByUnicode) {
  const auto tokenizer = ClipTokenizer::read(write("merges.txt", kMerges));
  ASSERT_OK(tokenizer);
  const auto with = [&](const std::string& between) {
    return tokenizer->encode("a" + between + "a").value();
  };
  // No-break and figure spaces, the next line, and what U+001C only separates for computers.
  for (const char* space : {"\u00A0", "\u2007", "\u202F", "\u0085", "\u3000"})
    EXPECT_THAT(with(space), ElementsAre(last('a'), last('a'))) << space;
  EXPECT_EQ(with("\x1C").size(), 3U);
  // Numbers stand alone: two digits in Arabic (of two bytes each) and Devanagari, one of Rome's.
  EXPECT_GE(with("\u0663\u0664")[2], 256);
  EXPECT_GE(with("\u0969\u096A")[3], 256);
  for (const char* number : {"\u0663", "\u0969", "\u00BD", "\u2167"}) {
    EXPECT_EQ(with(number).front(), last('a')) << number;
    EXPECT_GE(with(number).back(), 256) << number;
  }
  // A vowel sign is no letter, an accent neither.
  EXPECT_EQ(with("\u093F").front(), last('a'));
  EXPECT_EQ(with("\u0301").front(), last('a'));
  // Small letters as words have them: a sigma at the end.
  EXPECT_EQ(*tokenizer->encode("\u0391\u03A3"), *tokenizer->encode("\u03B1\u03C2"));
}

TEST_F(ClipTokenizerTest, RefusesEndlessTexts) {
  const auto tokenizer = ClipTokenizer::read(write("merges.txt", kMerges));
  ASSERT_OK(tokenizer);
  const std::string longest(ClipTokenizer::kMaxBytes, 'x');
  EXPECT_EQ(tokenizer->encode(longest)->size(), longest.size());
  EXPECT_ERROR(tokenizer->encode(longest + "x"), "a text of 1025 bytes is too long");
  EXPECT_ERROR(tokenizer->tokens(longest + "x", 77), "it may have 1024");
}

TEST_F(ClipTokenizerTest, FillsUpAndCutsOff) {
  const auto tokenizer = ClipTokenizer::read(write("merges.txt", kMerges));
  ASSERT_OK(tokenizer);
  EXPECT_THAT(*tokenizer->tokens("the cat", 6), ElementsAre(519, 513, 515, 520, 0, 0));
  EXPECT_THAT(*tokenizer->tokens("the cat", 6, 520), ElementsAre(519, 513, 515, 520, 520, 520));
  EXPECT_THAT(*tokenizer->tokens("the cat the cat", 4), ElementsAre(519, 513, 515, 520));
  EXPECT_THAT(*tokenizer->tokens("", 2), ElementsAre(519, 520));
}

TEST_F(ClipTokenizerTest, ReadsPackedListsAndOtherNumbers) {
  const fs::path packed = folder_.path() / "merges.txt.gz";
  gzFile file = gzopen(packed.c_str(), "wb");
  gzputs(file, kMerges);
  gzclose(file);
  const auto tokenizer = ClipTokenizer::read(packed);
  ASSERT_OK(tokenizer);
  EXPECT_THAT(*tokenizer->encode("the cat"), ElementsAre(513, 515));
  fs::resize_file(packed, fs::file_size(packed) - 12);
  EXPECT_ERROR(ClipTokenizer::read(packed), "is damaged");

  const fs::path merges = write("merges.txt", "#version: 0.2\n");
  std::string json = "{\"<|startoftext|>\": 7, \"<|endoftext|>\": 8";
  EXPECT_ERROR(ClipTokenizer::read(merges, write("vocab.json", json + "}")),
               "vocab.json: has no number for ");
  EXPECT_ERROR(ClipTokenizer::read(merges, write("vocab.json", "[1]")),
               "expected a number for each piece");
  EXPECT_ERROR(ClipTokenizer::read(merges, write("vocab.json", "{\"a\": -1}")),
               "expected a number for \"a\"");
}

TEST_F(ClipTokenizerTest, RefusesOtherFiles) {
  EXPECT_ERROR(ClipTokenizer::read(folder_.path() / "none.txt"), "none.txt: cannot be opened");
  EXPECT_ERROR(ClipTokenizer::read(write("a.txt", "t h\n")), "first line says \"#version\"");
  EXPECT_ERROR(ClipTokenizer::read(write("b.txt", "#version\nt h\nalone\n")),
               "b.txt: line 3: expected two pieces");
  EXPECT_ERROR(ClipTokenizer::read(write("c.txt", "#version\nt h e\n")), "line 2");
}

// What others say of the published list: the example of OpenAI's CLIP ("a diagram", "a dog", "a
// cat"), and tests of other readers, made with Hugging Face's CLIPTokenizer.
TEST_F(ClipTokenizerTest, GivesTheNumbersThatArePublished) {
  const char* folder = std::getenv("ROOMWISE_MODELS");
  fs::path merges;
  for (const char* name : {"bpe_simple_vocab_16e6.txt.gz", "bpe_simple_vocab_16e6.txt"}) {
    if (folder != nullptr && fs::exists(fs::path(folder) / name)) merges = fs::path(folder) / name;
  }
  if (merges.empty()) GTEST_SKIP() << "no bpe_simple_vocab_16e6.txt in the folder of networks";
  const auto tokenizer = ClipTokenizer::read(merges);
  ASSERT_OK(tokenizer);
  EXPECT_EQ(tokenizer->size(), 49408U);
  const std::vector<std::pair<std::string, std::vector<std::int64_t>>> published{
      {"a diagram", {320, 22697}},
      {"a dog", {320, 1929}},
      {"a photo of a cat", {320, 1125, 539, 320, 2368}},
      {"Hello,   WORLD!", {3306, 267, 1002, 256}},
      {"mobileclip", {9451, 944, 8546}},
      {"hatbox", {3447, 2063}},
      {"birthday cake 2024", {1166, 2972, 273, 271, 273, 275}},
      {"don't stop 42 times", {847, 713, 1691, 275, 273, 1661}},
      {"hello-world, 3.14 (test)", {3306, 268, 1002, 267, 274, 269, 272, 275, 263, 1628, 264}},
      {"caf\u00e9 \u00fcber na\u00efve", {15304, 6522, 1516, 1097, 35689, 563}},
      {"35mm photography", {274, 276, 2848, 2108}},
      {"\U0001F600 red car", {7334, 736, 1615}},
  };
  for (const auto& [text, numbers] : published)
    EXPECT_EQ(*tokenizer->encode(text), numbers) << text;
  EXPECT_EQ(tokenizer->begin(), 49406);
  EXPECT_EQ(tokenizer->end(), 49407);
}

}  // namespace
}  // namespace roomwise::network
