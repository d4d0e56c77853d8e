#include "cli/standard_streams.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): <cstdlib> lacks POSIX's mkstemps()
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "cli/signals.h"
#include "cli/streams.h"

namespace ccvt::cli {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = ":-";
constexpr std::array<std::string_view, 3> kTextFiles = {".csv", ".txt", ".svg"};
/// These are read and written here and there, or have their data in another file.
constexpr std::array<std::string_view, 2> kNoStreams = {".hdf5", ".nhdr"};

std::string name_of(Stream stream) {
  return stream == Stream::input ? "standard input" : "standard output";
}

[[noreturn]] void fail(const std::string& what, int error) {
  throw IoError(what + ": " + std::generic_category().message(error));
}

/// An empty file in the directory for such, which is removed at the end.
class StandIn {
 public:
  StandIn(Stream stream, std::string option, const std::string& extension)
      : option_(std::move(option)), stream_(stream) {
    std::error_code error;
    const fs::path directory = fs::temp_directory_path(error);
    if (error) fail(name_of(stream) + ": there is no directory for temporary files", error.value());
    std::string name = (directory / "ccvt-XXXXXX").string() + extension;
    const SignalsBlocked until_named;  // else one that comes now would leave the file behind
    // Nobody else may read it.
    const int file = ::mkstemps(name.data(), static_cast<int>(extension.size()));
    if (file < 0) fail(name_of(stream) + ": cannot be kept in " + directory.string(), errno);
    ::close(file);
    path_ = name;
    unlink_at_end(slot(), path_);
  }
  StandIn(const StandIn&) = delete;
  StandIn& operator=(const StandIn&) = delete;
  ~StandIn() {
    ::unlink(path_.c_str());
    unlink_at_end(slot(), "");
  }

  [[nodiscard]] const fs::path& path() const { return path_; }
  [[nodiscard]] std::string directory() const { return path_.parent_path().string(); }
  [[nodiscard]] const std::string& option() const { return option_; }

 private:
  [[nodiscard]] std::size_t slot() const { return stream_ == Stream::input ? 0 : 1; }

  std::string option_;
  fs::path path_;
  Stream stream_;
};

std::optional<StandIn>& of(Stream stream) {
  static std::optional<StandIn> input;
  static std::optional<StandIn> output;
  return stream == Stream::input ? input : output;
}

/// The program that knows files only; empty: this one knows streams.
std::string& refusing() {
  static std::string program;
  return program;
}

/// "csv:-, npy:- or txt:-": what may be a stream.
std::string list_of_streams(io::Extensions extensions) {
  std::vector<std::string> names;
  for (const std::string_view extension : extensions) {
    if (io::is_among(kNoStreams, extension)) continue;
    names.push_back(std::string(extension.substr(1)) + std::string(kMark));
  }
  return io::list_of(names, " or ");
}

std::string extension_of_stream(const std::string& option, const std::string& text,
                                io::Extensions extensions) {
  if (text == "-") {
    if (extensions.empty()) return "";
    return std::string(io::is_among(extensions, ".csv") ? ".csv" : extensions.front());
  }
  std::string extension = "." + text.substr(0, text.size() - kMark.size());
  if (extensions.empty()) {
    throw InvalidInput(option + ": '" + text + "' names a format, but there is one only; say -");
  }
  if (io::is_among(kNoStreams, extension)) {
    throw InvalidInput(option + ": '" + text + "' cannot be a stream: " + extension +
                       (extension == ".hdf5" ? " is not read and written from its start to its end"
                                             : " has its data in another file") +
                       "; name a file");
  }
  if (io::is_among(extensions, extension)) return extension;
  throw InvalidInput(option + ": '" + text + "' has an unknown format; must be " +
                     list_of_streams(extensions));
}

/// Throws where it is closed: then it can be opened the wrong way only, see fill_closed_streams().
void check_open(const std::string& option, Stream stream) {
  const bool input = stream == Stream::input;
  const int flags = ::fcntl(input ? STDIN_FILENO : STDOUT_FILENO, F_GETFL);
  if (flags == -1 || (flags & O_ACCMODE) == (input ? O_WRONLY : O_RDONLY)) {
    throw InvalidInput(option + ": " + name_of(stream) + " is closed");
  }
}

/// Throws unless standard output takes a file of this kind.
void check_standard_output(const std::string& option, const std::string& extension,
                           io::Extensions extensions) {
  const bool text = extension.empty() || io::is_among(kTextFiles, extension);
  if (text || ::isatty(STDOUT_FILENO) == 0) return;
  throw InvalidInput(option + ": " + extension +
                     " is not for a terminal; redirect standard output" +
                     (io::is_among(extensions, ".csv") ? ", or say csv:-" : ""));
}

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Close>;

constexpr std::size_t kBlock = std::size_t{1} << 16;

/// Whether the read or write that just failed is to be made again, once `stream` is ready for it:
/// whoever shares the stream may have made it one that does not wait.
bool is_to_be_retried(int stream, short events) {
  if (errno == EINTR) return true;
  if (errno != EAGAIN) return false;
  pollfd ready = {stream, events, 0};
  ::poll(&ready, 1, -1);
  return true;
}

/// Of at most `block.size()` bytes; 0 at the end.
std::size_t read_standard_input(std::span<char> block) {
  for (;;) {
    const ssize_t got = ::read(STDIN_FILENO, block.data(), block.size());
    if (got >= 0) return static_cast<std::size_t>(got);
    if (!is_to_be_retried(STDIN_FILENO, POLLIN)) {
      fail(name_of(Stream::input) + ": cannot be read", errno);
    }
  }
}

void write_standard_output(std::span<const char> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (sent >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
    } else if (!is_to_be_retried(STDOUT_FILENO, POLLOUT)) {
      fail_to_print();
    }
  }
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

}  // namespace

void refuse_streams(const std::string& program) { refusing() = program; }

bool streams_are_refused() { return !refusing().empty(); }

std::string program_name() { return streams_are_refused() ? refusing() : "ccvt"; }

bool names_stream(const std::string& text) {
  return text == "-" || (text.ends_with(kMark) && text.size() > kMark.size() &&
                         text.find('/') == std::string::npos);
}

fs::path stand_in(const std::string& option, const std::string& text, Stream stream,
                  io::Extensions extensions) {
  if (streams_are_refused()) {
    throw InvalidInput(option + ": '" + text + "' is a stream: " + refusing() +
                       " reads and writes files only");
  }
  std::optional<StandIn>& there = of(stream);
  if (there) {
    throw InvalidInput(option + ": " + name_of(stream) + " is that of " + there->option() +
                       " already; one file only may be a stream");
  }
  const std::string extension = extension_of_stream(option, text, extensions);
  check_open(option, stream);
  if (stream == Stream::output) check_standard_output(option, extension, extensions);
  return there.emplace(stream, option, extension).path();
}

fs::path file_of(const std::string& option, const std::string& text, Stream stream,
                 io::Extensions extensions) {
  if (!names_stream(text)) return text;
  return stand_in(option, text, stream, extensions);
}

bool is_from_stream(const fs::path& file) {
  const std::optional<StandIn>& input = of(Stream::input);
  return input && input->path() == file;
}

void receive_standard_input() {
  static bool received = false;
  const std::optional<StandIn>& input = of(Stream::input);
  if (!input || std::exchange(received, true)) return;
  const std::string kept = name_of(Stream::input) + ": cannot be kept in " + input->directory();
  File file(std::fopen(input->path().c_str(), "wb"));
  if (!file) fail(kept, errno);
  std::array<char, kBlock> block;
  while (const std::size_t got = read_standard_input(block)) {
    if (std::fwrite(block.data(), 1, got, file.get()) < got) fail(kept, errno);
  }
  if (std::fclose(file.release()) != 0) fail(kept, errno);
}

void send_standard_output(const Publication& outputs) {
  const std::optional<StandIn>& output = of(Stream::output);
  if (!output) return;
  const File file(std::fopen(outputs.unpublished(output->path()).c_str(), "rb"));
  std::array<char, kBlock> block;
  while (file) {
    const std::size_t got = std::fread(block.data(), 1, block.size(), file.get());
    if (got == 0) break;
    write_standard_output(std::span(block).first(got));
  }
  if (!file || std::ferror(file.get()) != 0) {
    fail("the copy of standard output in " + output->directory() + " cannot be read", errno);
  }
}

bool standard_output_is_taken() { return of(Stream::output).has_value(); }

std::string with_names_of_streams(std::string message) {
  for (const Stream stream : {Stream::input, Stream::output}) {
    const std::optional<StandIn>& there = of(stream);
    if (!there) continue;
    const std::string path = there->path().string();
    if (stream == Stream::output) {
      replace_all(message, path + ": cannot be written",
                  "the copy of standard output in " + there->directory() + " cannot be written");
    }
    replace_all(message, path, name_of(stream));
  }
  return message;
}

}  // namespace ccvt::cli
