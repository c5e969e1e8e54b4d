#include "roomwise/download/https_download.h"

#include <curl/curl.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>

namespace roomwise::download {
namespace {

namespace fs = std::filesystem;

struct Closer {
  void operator()(CURL* curl) const { curl_easy_cleanup(curl); }
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
// What an earlier try left: only with an ETag, and from the same address, can it be gone on from.
struct Rest {
  std::uint64_t bytes = 0;
  std::string etag;
};

Expected<Rest> find_rest(const std::string& url, const PartFile& part) {
  ROOMWISE_TRY(const std::uint64_t bytes, part.bytes());
  const std::string origin = part.origin();
  const std::size_t line = origin.find('\n');
  if (bytes == 0 || line == std::string::npos || origin.substr(0, line) != url) return Rest{};
  return Rest{bytes, origin.substr(line + 1)};
}

std::optional<std::uint64_t> number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// What "Content-Range: bytes FIRST-LAST/WHOLE" says of an answer.
struct Range {
  std::uint64_t first = 0;
  std::uint64_t whole = 0;  // bytes of the file
};

// Nothing where it says no such thing. Without the length of the file ("/*") nobody could tell
// whether the answer is the rest of it.
std::optional<Range> parse_range(std::string_view text) {
  if (!text.starts_with("bytes ")) return std::nullopt;
  text.remove_prefix(6);
  const std::size_t dash = text.find('-');
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos || dash > slash) return std::nullopt;
  const auto first = number(text.substr(0, dash));
  const auto last = number(text.substr(dash + 1, slash - dash - 1));
  const auto whole = number(text.substr(slash + 1));
  if (!first || !last || !whole || *last < *first || *last >= *whole) return std::nullopt;
  return Range{*first, *whole};
}

// One request and what comes back. Its callbacks are C's; what goes wrong in them is kept and ends
// the transfer.
class Transfer {
 public:
  Transfer(const std::string& url, PartFile& part, const ExpectedFile& expected, Progress& progress,
           const DownloadOptions& options, Rest rest)
      : url_(url),
        part_(part),
        expected_(expected),
        progress_(progress),
        options_(options),
        rest_(std::move(rest)) {}

  // Gives the number of bytes that were there before.
  Expected<std::uint64_t> run() {
    const std::unique_ptr<CURL, Closer> curl(curl_easy_init());
    if (!curl) return fail("{}: libcurl cannot be set up", url_);
    curl_ = curl.get();
    const auto headers = set_up();
    progress_.begin("fetching " + part_.path().stem().string(), expected_.bytes);
    const CURLcode code = curl_easy_perform(curl_);
    progress_.end();
    long status = 0;
    curl_easy_getinfo(curl_, CURLINFO_RESPONSE_CODE, &status);
    status_ = status;
    ROOMWISE_RETURN_IF_ERROR(part_.flush_to_disk());
    ROOMWISE_RETURN_IF_ERROR(taken_);
    if (code != CURLE_OK) return describe(code);
    if (!begun_) ROOMWISE_RETURN_IF_ERROR(begin_body());  // an empty file
    if (range_ && received_ < range_->whole) {
      return fail(
          "{}: the server has sent no more than the first {} of {} bytes so far; try again: it "
          "goes "
          "on from there",
          url_, received_, range_->whole);
    }
    return resumed_from_;
  }

  // The server has nothing after what is here: the file became shorter, or all is here.
  [[nodiscard]] bool range_was_refused() const { return status_ == 416; }

 private:
  std::unique_ptr<curl_slist, Closer> set_up() {
    std::unique_ptr<curl_slist, Closer> headers;
    curl_easy_setopt(curl_, CURLOPT_URL, url_.c_str());
    curl_easy_setopt(curl_, CURLOPT_PROTOCOLS_STR, "https");
    curl_easy_setopt(curl_, CURLOPT_REDIR_PROTOCOLS_STR, "https");
    curl_easy_setopt(curl_, CURLOPT_FOLLOWLOCATION, 1L);
    curl_easy_setopt(curl_, CURLOPT_MAXREDIRS, 8L);
    curl_easy_setopt(curl_, CURLOPT_SSLVERSION, static_cast<long>(CURL_SSLVERSION_TLSv1_2));
    curl_easy_setopt(curl_, CURLOPT_FAILONERROR, 1L);
    curl_easy_setopt(curl_, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl_, CURLOPT_USERAGENT, "roomwise");
    curl_easy_setopt(curl_, CURLOPT_ERRORBUFFER, message_);
    curl_easy_setopt(curl_, CURLOPT_CONNECTTIMEOUT, static_cast<long>(options_.connect_timeout_s));
    curl_easy_setopt(curl_, CURLOPT_LOW_SPEED_LIMIT, 1024L);
    curl_easy_setopt(curl_, CURLOPT_LOW_SPEED_TIME, static_cast<long>(options_.stall_timeout_s));
    if (!options_.certificates.empty()) {
      curl_easy_setopt(curl_, CURLOPT_CAINFO, options_.certificates.c_str());
      curl_easy_setopt(curl_, CURLOPT_CAPATH, nullptr);  // else the system's folder counts too
    }
    if (rest_.bytes > 0) {
      const std::string if_range = "If-Range: " + rest_.etag;
      headers.reset(curl_slist_append(nullptr, if_range.c_str()));
      curl_easy_setopt(curl_, CURLOPT_HTTPHEADER, headers.get());
      curl_easy_setopt(curl_, CURLOPT_RANGE, fmt::format("{}-", rest_.bytes).c_str());
    }
    curl_easy_setopt(curl_, CURLOPT_HEADERFUNCTION, &Transfer::on_header);
    curl_easy_setopt(curl_, CURLOPT_HEADERDATA, this);
    curl_easy_setopt(curl_, CURLOPT_WRITEFUNCTION, &Transfer::on_body);
    curl_easy_setopt(curl_, CURLOPT_WRITEDATA, this);
    curl_easy_setopt(curl_, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(curl_, CURLOPT_XFERINFOFUNCTION, &Transfer::on_progress);
    curl_easy_setopt(curl_, CURLOPT_XFERINFODATA, this);
    return headers;
  }

  static std::size_t on_header(char* text, std::size_t, std::size_t size, void* self) {
    static_cast<Transfer*>(self)->take_header({text, size});
    return size;
  }
  static std::size_t on_body(char* bytes, std::size_t, std::size_t size, void* self) {
    return static_cast<Transfer*>(self)->take_body(bytes, size) ? size : 0;
  }
  static int on_progress(void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    auto& transfer = *static_cast<Transfer*>(self);
    if (!transfer.progress_.interrupted()) return 0;
    transfer.taken_ = fail_with(
        ErrorCode::kInterrupted,
        "{}: interrupted; what has come stays in {}, and the same command goes on from there",
        transfer.url_, transfer.part_.path().string());
    return 1;
  }

  void take_header(std::string_view line) {
    while (!line.empty() && (line.back() == '\r' || line.back() == '\n')) line.remove_suffix(1);
    if (line.starts_with("HTTP/")) {  // of the next answer, after a redirection
      etag_.clear();
      range_.reset();
      return;
    }
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return;
    std::string name(line.substr(0, colon));
    std::ranges::transform(name, name.begin(), [](unsigned char c) {
      return static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
    });
    std::string_view value = line.substr(colon + 1);
    while (value.starts_with(' ')) value.remove_prefix(1);
    // A weak one ("W/...") says only that two files mean the same.
    if (name == "etag" && value.starts_with('"')) etag_ = value;
    if (name == "content-range") range_ = parse_range(value);
  }

  // Before the first byte of the answer's body: opens the file where it goes on.
  Expected<void> begin_body() {
    begun_ = true;
    long status = 0;
    curl_easy_getinfo(curl_, CURLINFO_RESPONSE_CODE, &status);
    if (status != 200 && status != 206) {
      return fail("{}: the server answers {}, which is no file", url_, status);
    }
    if (status == 200) {
      range_.reset();
    } else if (rest_.bytes == 0 || !range_ || range_->first != rest_.bytes) {
      part_.remove();
      return fail("{}: the server sends another part of the file than was asked for; try again",
                  url_);
    }
    resumed_from_ = range_ ? rest_.bytes : 0;
    received_ = resumed_from_;
    ROOMWISE_RETURN_IF_ERROR(check_announced_size());
    if (range_) return {};  // of the same file, so that its ETag stays as it is
    ROOMWISE_RETURN_IF_ERROR(part_.clear());
    return part_.set_origin(etag_.empty() ? "" : url_ + "\n" + etag_);
  }

  Expected<void> check_announced_size() {
    curl_off_t announced = -1;
    curl_easy_getinfo(curl_, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &announced);
    if (!range_ && announced < 0) return {};
    const std::uint64_t whole = range_ ? range_->whole : static_cast<std::uint64_t>(announced);
    if (expected_.bytes && whole != *expected_.bytes) {
      part_.remove();
      return fail("{}: the server has {} bytes; expected {}; it is another file", url_, whole,
                  *expected_.bytes);
    }
    if (whole > options_.max_bytes) return too_large();
    return {};
  }

  Unexpected too_large() {
    part_.remove();
    return fail("{}: the file is larger than {} bytes, the most that is fetched", url_,
                std::min(options_.max_bytes, expected_.bytes.value_or(options_.max_bytes)));
  }

  bool take_body(const char* bytes, std::size_t size) {
    taken_ = [&]() -> Expected<void> {
      if (!begun_) ROOMWISE_RETURN_IF_ERROR(begin_body());
      received_ += size;
      if (received_ > expected_.bytes.value_or(options_.max_bytes) ||
          received_ > options_.max_bytes) {
        return too_large();
      }
      if (range_ && received_ > range_->whole) {
        part_.remove();
        return fail("{}: the server sends more than the {} bytes that it has announced", url_,
                    range_->whole);
      }
      ROOMWISE_RETURN_IF_ERROR(part_.append({reinterpret_cast<const std::uint8_t*>(bytes), size}));
      progress_.advance(received_, "");
      return {};
    }();
    return taken_.has_value();
  }

  Unexpected describe(CURLcode code) const {
    const char* why = message_[0] != '\0' ? message_ : curl_easy_strerror(code);
    if (code == CURLE_OPERATION_TIMEDOUT || code == CURLE_PARTIAL_FILE ||
        code == CURLE_RECV_ERROR) {
      return fail(
          "{}: the connection broke or stalled after {} bytes ({}); try again: it goes on "
          "from there if the server lets it",
          url_, received_, why);
    }
    if (code == CURLE_UNSUPPORTED_PROTOCOL) {
      return fail("{}: leads to an address that is not https ({}); nothing is fetched from there",
                  url_, why);
    }
    return fail("{}: cannot be fetched: {}", url_, why);
  }

  const std::string& url_;
  PartFile& part_;
  const ExpectedFile& expected_;
  Progress& progress_;
  const DownloadOptions& options_;
  Rest rest_;
  CURL* curl_ = nullptr;
  char message_[CURL_ERROR_SIZE] = {};
  Expected<void> taken_;
  long status_ = 0;
  bool begun_ = false;
  std::string etag_;
  std::optional<Range> range_;  // where the answer is a part of the file
  std::uint64_t resumed_from_ = 0;
  std::uint64_t received_ = 0;
};

// Whether nothing is left to fetch, but a name to give. Only a digest tells.
bool is_whole(PartFile& part, const ExpectedFile& expected) {
  return !expected.sha256_begin.empty() && part.flush_to_disk() &&
         check_file(part.path(), expected);
}

// Gives the number of bytes that were there before.
Expected<std::uint64_t> complete(const std::string& url, PartFile& part,
                                 const ExpectedFile& expected, Progress& progress,
                                 const DownloadOptions& options) {
  ROOMWISE_TRY(const std::uint64_t left, part.bytes());
  if (left == expected.bytes && is_whole(part, expected)) return left;
  ROOMWISE_TRY(const Rest rest, find_rest(url, part));
  Transfer transfer(url, part, expected, progress, options, rest);
  Expected<std::uint64_t> resumed = transfer.run();
  if (resumed || rest.bytes == 0 || !transfer.range_was_refused()) return resumed;
  if (is_whole(part, expected)) return left;
  ROOMWISE_RETURN_IF_ERROR(part.clear());
  return Transfer(url, part, expected, progress, options, {}).run();
}

}  // namespace

Expected<void> DownloadOptions::validate() const {
  if (max_bytes == 0) return fail("max_bytes is 0; expected more");
  if (connect_timeout_s < 1)
    return fail("connect_timeout_s is {}; expected 1 or more", connect_timeout_s);
  if (stall_timeout_s < 1)
    return fail("stall_timeout_s is {}; expected 1 or more", stall_timeout_s);
  return {};
}

Expected<FetchedFile> download(const std::string& url, const fs::path& target,
                               const ExpectedFile& expected, Progress& progress,
                               const DownloadOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  if (!url.starts_with("https://")) {
    return fail("{}: is not an https address; nothing is fetched unprotected", url);
  }
  static const CURLcode kReady = curl_global_init(CURL_GLOBAL_DEFAULT);
  if (kReady != CURLE_OK) return fail("libcurl cannot be set up: {}", curl_easy_strerror(kReady));

  ROOMWISE_TRY(PartFile part, PartFile::open(target));
  ROOMWISE_TRY(const std::uint64_t resumed_from, complete(url, part, expected, progress, options));
  ROOMWISE_TRY(FetchedFile fetched, part.accept(expected, options.before_naming));
  fetched.resumed_from = resumed_from;
  return fetched;
}

}  // namespace roomwise::download
