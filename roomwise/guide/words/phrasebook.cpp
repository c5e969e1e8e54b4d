#include "roomwise/guide/words/phrasebook.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "roomwise/guide/grammar/folded_words.h"

namespace roomwise::guide {
namespace {

using nlohmann::json;

constexpr std::string_view kBelowTwo = "below 2";
constexpr unsigned kLatinSupplement = 0xC3;  // first byte of UTF-8's "À" to "ÿ"

// One UTF-8 text with letters from A to Z and from À to Þ made small.
std::string lower(std::string_view text) {
  std::string result(text);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto byte = static_cast<unsigned char>(result[i]);
    const bool follows = i > 0 && static_cast<unsigned char>(result[i - 1]) == kLatinSupplement;
    if ((byte >= 'A' && byte <= 'Z') || (follows && byte >= 0x80 && byte <= 0x9E)) {
      result[i] = static_cast<char>(byte + 0x20);
    }
  }
  return result;
}

void make_first_a_capital(std::string& text) {
  if (text.empty()) return;
  const auto byte = static_cast<unsigned char>(text[0]);
  if (byte >= 'a' && byte <= 'z') text[0] = static_cast<char>(byte - 0x20);
  if (byte != kLatinSupplement || text.size() < 2) return;
  const auto second = static_cast<unsigned char>(text[1]);
  if (second >= 0xA0 && second <= 0xBE) text[1] = static_cast<char>(second - 0x20);
}

bool is_proper(std::string_view name) {
  return lower(name.substr(0, 2)) != name.substr(0, 2) || name.find('\'') != std::string_view::npos;
}

// "bedroom 2" -> "bedroom", " 2".
std::pair<std::string_view, std::string_view> without_number(std::string_view name) {
  const std::size_t end = name.find_last_not_of("0123456789");
  const bool has_number = end != std::string_view::npos && end > 0 && end + 1 < name.size();
  if (!has_number || name[end] != ' ') return {name, {}};
  return {name.substr(0, end), name.substr(end)};
}

std::string replaced(const std::string& pattern, std::string_view sign, const std::string& by) {
  std::string result = pattern;
  if (const std::size_t place = result.find(sign); place != std::string::npos) {
    result.replace(place, sign.size(), by);
  }
  return result;
}

Nouns nouns(Noun::Kind kind, const std::vector<std::string>& names) {
  Nouns result;
  for (const std::string& name : names) result.push_back({kind, name});
  return result;
}

}  // namespace

Nouns thing(const std::string& name) {
  return {{Noun::Kind::kThing, name}};
}
Nouns thing_list(const std::vector<std::string>& names) {
  return nouns(Noun::Kind::kThing, names);
}
Nouns room(const std::string& name) {
  return {{Noun::Kind::kRoom, name}};
}
Nouns room_list(const std::vector<std::string>& names) {
  return nouns(Noun::Kind::kRoom, names);
}

Expected<Phrasebook> Phrasebook::parse(std::string_view text,
                                       std::span<const objects::Kind> kinds) {
  Phrasebook book;
  try {
    const json file = json::parse(text);
    file.at("language").get_to(book.language_);
    file.at("name").get_to(book.name_);
    file.at("messages").get_to(book.messages_);
    file.at("forms").get_to(book.forms_);
    file.at("counts").get_to(book.counts_);
    file.at("singular").get_to(book.singular_);
    file.at("decimal").get_to(book.decimal_);
    file.at("months").get_to(book.months_);
    file.at("and").get_to(book.and_);
    book.and_before_ = file.value("and_before", book.and_before_);
    file.at("rooms").get_to(book.rooms_);
    file.at("goals").get_to(book.things_);
    auto grammar = Grammar::parse(file.at("questions"));
    if (!grammar) {
      return fail("messages of language \"{}\": {}", book.language_, grammar.error().message);
    }
    book.grammar_ = *std::move(grammar);
  } catch (const json::exception& error) {
    return fail("messages of language \"{}\": {}", book.language_, error.what());
  }
  for (const objects::Kind& kind : kinds) {
    const auto called = kind.called.find(book.language_);
    if (called != kind.called.end()) book.things_.insert({kind.name, called->second});
  }
  if (auto valid = book.validate(); !valid) {
    return Unexpected(std::move(valid).error().with_context(
        fmt::format("messages of language \"{}\"", book.language_)));
  }
  return book;
}

Expected<void> Phrasebook::validate() const {
  for (const auto& [message, text] : messages_) {
    if (std::ranges::count(text, '{') != std::ranges::count(text, '}')) {
      return fail("message \"{}\": a brace is not closed", message);
    }
    for (const Segment& piece : segments_of(text)) {
      const bool is_known = forms_.contains(piece.form) || counts_.contains(piece.form);
      if (!piece.form.empty() && !is_known) {
        return fail("message \"{}\": there is no form \"{}\"", message, piece.form);
      }
    }
  }
  for (const auto& [form, patterns] : forms_) {
    for (const char* unknown : {"proper", "other"}) {
      if (!patterns.contains(unknown)) return fail("form \"{}\" lacks \"{}\"", form, unknown);
    }
    for (const auto& [word_class, pattern] : patterns) {
      if (pattern.find("{}") == std::string::npos) {
        return fail("form \"{}\", \"{}\": there is no {{}}", form, word_class);
      }
    }
  }
  if (months_.size() != 12 || std::ranges::count(months_, std::string()) > 0) {
    return fail("months: expected twelve names");
  }
  for (const auto& [unit, numbers] : counts_) {
    if (!numbers.contains("one") || !numbers.contains("other")) {
      return fail("count \"{}\" lacks \"one\" or \"other\"", unit);
    }
  }
  if (singular_ != "1" && singular_ != kBelowTwo) {
    return fail("singular is \"{}\"; expected \"1\" or \"{}\"", singular_, kBelowTwo);
  }
  for (const Words* words : {&things_, &rooms_}) {
    for (const auto& [word, description] : *words) {
      ROOMWISE_RETURN_IF_ERROR(validate(word, description));
    }
  }
  return {};
}

Expected<void> Phrasebook::validate(const std::string& word, const Word& description) const {
  if (description.name.empty()) return fail("word \"{}\" has no name", word);
  for (const auto& [form, patterns] : forms_) {
    // Rooms are not counted.
    if (form == "plural" && rooms_.contains(word)) continue;
    if (!patterns.contains(description.word_class) && !description.forms.contains(form)) {
      return fail("word \"{}\": neither it nor its class \"{}\" has the form \"{}\"", word,
                  description.word_class, form);
    }
  }
  for (const auto& [form, text] : description.forms) {
    if (!forms_.contains(form)) return fail("word \"{}\": there is no form \"{}\"", word, form);
  }
  return {};
}

std::vector<Phrasebook::Segment> Phrasebook::segments_of(std::string_view text) {
  std::vector<Segment> pieces;
  while (!text.empty()) {
    const std::size_t open = std::min(text.find('{'), text.size());
    const std::size_t close = std::min(text.find('}', open), text.size());
    Segment piece{std::string(text.substr(0, open)), {}, {}};
    if (open < text.size()) {
      const std::string_view inside = text.substr(open + 1, close - open - 1);
      const std::size_t space = inside.find(' ');
      const bool has_form = space != std::string_view::npos;
      piece.form = has_form ? inside.substr(0, space) : "";
      piece.value = has_form ? inside.substr(space + 1) : inside;
    }
    pieces.push_back(std::move(piece));
    text.remove_prefix(std::min(close + 1, text.size()));
  }
  return pieces;
}

std::set<std::string> Phrasebook::messages() const {
  std::set<std::string> names;
  for (const auto& [message, text] : messages_) names.insert(message);
  return names;
}

std::set<std::string> Phrasebook::values_of(const std::string& message) const {
  const auto found = messages_.find(message);
  if (found == messages_.end()) throw std::invalid_argument("no message " + message);
  std::set<std::string> values;
  for (const Segment& piece : segments_of(found->second)) {
    if (!piece.value.empty()) values.insert(piece.value);
  }
  return values;
}

std::string Phrasebook::text(const std::string& message, const Values& values) const {
  const auto found = messages_.find(message);
  if (found == messages_.end()) throw std::invalid_argument("no message " + message);
  std::string result;
  for (const Segment& piece : segments_of(found->second)) {
    result += piece.words;
    if (piece.value.empty()) continue;
    const auto value = values.find(piece.value);
    if (value == values.end()) {
      throw std::invalid_argument("message " + message + " needs a value " + piece.value);
    }
    if (const auto* const nouns = std::get_if<Nouns>(&value->second)) {
      result += list(piece.form, *nouns);
      continue;
    }
    const auto& as_it_is = std::get<std::string>(value->second);
    result += counts_.contains(piece.form) ? count(piece.form, std::stod(as_it_is)) : as_it_is;
  }
  make_first_a_capital(result);
  return result;
}

const std::string& Phrasebook::month(int number) const {
  return months_.at(static_cast<std::size_t>(number - 1));
}

std::string Phrasebook::count(const std::string& unit, double number) const {
  const auto& texts = counts_.at(unit);
  const double tenths = std::round(number * 10);
  const bool is_whole = std::fmod(tenths, 10) == 0;
  std::string digits = is_whole ? fmt::format("{:.0f}", tenths / 10)
                                : replaced(fmt::format("{:.1f}", tenths / 10), ".", decimal_);
  // A number whose word has a gender is written out: voices read "1 marche" as "un marche".
  const auto exactly_one = texts.find("=1");
  if (tenths == 10 && exactly_one != texts.end()) return exactly_one->second;
  const bool is_one = tenths == 10 || (singular_ == kBelowTwo && tenths >= 0 && tenths < 20);
  // Where 1.5 is singular, so is its text, but for the number in it.
  const std::string& text = texts.at(is_one ? "one" : "other");
  return replaced(text, "{n}", digits);
}

const Phrasebook::Words& Phrasebook::words_of(Noun::Kind kind) const {
  return kind == Noun::Kind::kThing ? things_ : rooms_;
}

std::set<std::string> Phrasebook::words(Noun::Kind kind) const {
  std::set<std::string> names;
  for (const auto& [word, description] : words_of(kind)) names.insert(word);
  return names;
}

std::vector<std::string> Phrasebook::words_for(Noun::Kind kind, std::string_view called) const {
  const std::string wanted = lower(called);
  const auto is_wanted = [&](const std::string& other) { return lower(other) == wanted; };
  std::vector<std::string> exact;
  std::vector<std::string> by_name;
  std::vector<std::string> by_other_names;
  for (const auto& [word, description] : words_of(kind)) {
    const auto plural = description.forms.find("plural");
    const bool is_plural = plural != description.forms.end() && is_wanted(plural->second);
    if (is_wanted(word)) {
      exact.push_back(word);
    } else if (is_wanted(description.name) || is_plural) {
      by_name.push_back(word);
    } else if (std::ranges::any_of(description.also, is_wanted)) {
      by_other_names.push_back(word);
    }
  }
  exact.insert(exact.end(), by_name.begin(), by_name.end());
  exact.insert(exact.end(), by_other_names.begin(), by_other_names.end());
  return exact;
}

Phrasebook::Called Phrasebook::spoken_names(const Noun& noun) const {
  const Word* const word = find(noun);
  if (word == nullptr) return {{noun.name}, {}};
  Called called{{word->name}, word->also};
  const auto plural = word->forms.find("plural");
  if (plural != word->forms.end()) called.names.push_back(plural->second);
  return called;
}

// A home's name for something is known where it is a word or a word's name here; what else people
// call it is not: a helper who writes "couch" is to hear "couch".
const Phrasebook::Word* Phrasebook::find(const Noun& noun) const {
  const std::string wanted = lower(noun.name);
  const Words& words = words_of(noun.kind);
  for (const auto& [word, description] : words) {
    if (lower(word) == wanted) return &description;
  }
  for (const auto& [word, description] : words) {
    if (lower(description.name) == wanted) return &description;
  }
  return nullptr;
}

// "my blue mug".
bool Phrasebook::begins_with_determiner(const std::string& name) const {
  const std::vector<std::string> words = folded_words(name);
  return words.size() > 1 && grammar_.is_determiner(words.front());
}

std::string Phrasebook::in_form(const std::string& form, const Noun& noun) const {
  const auto [name, number] = without_number(noun.name);
  const Word* word = find({noun.kind, std::string(name)});
  if (word == nullptr) {
    if (form.empty()) return noun.name;
    const bool needs_no_article = is_proper(noun.name) || begins_with_determiner(noun.name);
    return replaced(forms_.at(form).at(needs_no_article ? "proper" : "other"), "{}", noun.name);
  }
  const std::string spoken = word->name + std::string(number);
  if (form.empty()) return spoken;
  const auto own = word->forms.find(form);
  if (own != word->forms.end()) return own->second + std::string(number);
  const auto& patterns = forms_.at(form);
  const auto numbered = patterns.find(word->word_class + "-numbered");
  const bool is_numbered = !number.empty() && numbered != patterns.end();
  return replaced(is_numbered ? numbered->second : patterns.at(word->word_class), "{}", spoken);
}

// Spanish "y" becomes "e" before its own sound. Longer beginnings come later, and count.
const std::string& Phrasebook::and_for(const std::string& next) const {
  const std::string* fitting = &and_;
  for (const auto& [beginning, word] : and_before_) {
    if (lower(next).starts_with(beginning)) fitting = &word;
  }
  return *fitting;
}

std::string Phrasebook::list(const std::string& form, const Nouns& nouns) const {
  std::string result;
  for (std::size_t i = 0; i < nouns.size(); ++i) {
    const std::string noun = in_form(form, nouns[i]);
    if (i > 0) result += i + 1 < nouns.size() ? ", " : " " + and_for(noun) + " ";
    result += noun;
  }
  return result;
}

}  // namespace roomwise::guide
