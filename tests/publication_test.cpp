#include "ccvt/publication.h"

#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "support/files.h"
#include "support/message.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

unsigned mode_of(const fs::path& path) {
  struct stat file = {};
  REQUIRE(::stat(path.c_str(), &file) == 0);
  return file.st_mode & 07777U;
}

/// Names in the directory that are those of unfinished files.
std::size_t unfinished_in(const fs::path& directory) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    const bool is_one = name.size() == 27 && name.rfind(".ccvt-", 0) == 0 &&
                        name.substr(22) == ".part" &&
                        std::all_of(name.begin() + 6, name.begin() + 22,
                                    [](unsigned char c) { return std::isxdigit(c) != 0; });
    count += is_one ? 1 : 0;
  }
  return count;
}

}  // namespace

TEST_SUITE_BEGIN("publication");

TEST_CASE("two threads that write one file: each file that appears is whole, none is lost") {
  const TemporaryDirectory directory;
  const fs::path target = directory / "p.txt";
  // Of different lengths, and long enough to be seen half way.
  const std::vector<std::string> texts = {std::string(300'000, 'a'), std::string(200'000, 'b')};
  write_text(target, texts[0]);
  std::atomic<int> failures = 0;
  std::atomic<int> writing = 2;
  std::vector<std::thread> writers;
  for (const std::string& text : texts) {
    writers.emplace_back([&] {
      for (int i = 0; i < 60; ++i) {
        try {
          write_text(target, text);
        } catch (...) {
          ++failures;
        }
      }
      --writing;
    });
  }
  int damaged = 0;
  while (writing > 0) {
    const std::string seen = get(target);
    damaged += seen == texts[0] || seen == texts[1] ? 0 : 1;
  }
  for (std::thread& writer : writers) writer.join();
  CHECK(failures == 0);
  CHECK(damaged == 0);
  CHECK(directory.entries() == 1);
}

TEST_CASE("a writer leaves the unfinished file of another alone") {
  const TemporaryDirectory directory;
  Publication together;
  write_text(directory / "a.txt", "first");
  std::thread([&] { write_text(directory / "a.txt", "second"); }).join();
  CHECK(get(directory / "a.txt") == "second");
  together.publish();
  CHECK(get(directory / "a.txt") == "first");
  CHECK(directory.entries() == 1);
}

TEST_CASE("a symbolic link stays, and what it leads to is replaced") {
  const TemporaryDirectory directory;
  fs::create_directories(directory / "far/away");
  fs::create_directory(directory / "links");
  put(directory / "far/away/o.csv", "old");
  fs::create_symlink("../far/away/o.csv", directory / "links/relative.csv");
  fs::create_symlink(directory / "links/relative.csv", directory / "links/chain.csv");
  fs::create_symlink("../far/new.csv", directory / "links/dangling.csv");
  fs::create_symlink("circle.csv", directory / "links/circle.csv");
  fs::create_symlink("../far", directory / "links/folder.csv");
  fs::create_symlink("../none/o.csv", directory / "links/nowhere.csv");
  fs::create_symlink("/dev/null", directory / "links/device.csv");

  const std::vector<Index> owners = {1, 2};
  for (const char* const name : {"links/relative.csv", "links/chain.csv"}) {
    put(directory / "far/away/o.csv", "old");
    Publication together;
    write_owners(directory / name, owners);
    CHECK(unfinished_in(directory / "far/away") == 1);  // where a rename can reach the target
    CHECK(unfinished_in(directory / "links") == 0);
    together.publish();
    CHECK(get(directory / "far/away/o.csv") == "1\n2\n");
    CHECK(fs::is_symlink(directory / name));
    CHECK(output_target(directory / name).filename() == "o.csv");
  }
  write_owners(directory / "links/dangling.csv", owners);
  CHECK(fs::is_symlink(directory / "links/dangling.csv"));
  CHECK(get(directory / "far/new.csv") == "1\n2\n");

  const auto message = [&](const std::string& name) {
    return message_of([&] { write_owners(directory / name, owners); });
  };
  CHECK(contains(message("links/circle.csv"), "symbolic links"));
  CHECK(contains(message("links/folder.csv"), "directory"));
  CHECK(contains(message("links/nowhere.csv"), "there is no directory"));
  CHECK(contains(message("links/device.csv"), "is not a regular file"));
  CHECK(contains(message_of([&] { output_target(directory / "links/circle.csv"); }), "IoError: "));
  CHECK(output_target("o.csv") == "o.csv");
  CHECK(fs::is_empty(directory / "far/away") == false);
  CHECK(unfinished_in(directory / "links") + unfinished_in(directory / "far") == 0);
}

TEST_CASE("the new file has the permissions of the old one, else what the umask leaves") {
  const TemporaryDirectory directory;
  const mode_t before = ::umask(027);
  write_text(directory / "new.txt", "1");
  CHECK(mode_of(directory / "new.txt") == 0640);
  for (const unsigned mode : {0600U, 0604U, 0666U, 0755U}) {
    ::chmod((directory / "new.txt").c_str(), mode);
    Publication together;
    write_text(directory / "new.txt", "2");
    CHECK(mode_of(together.unpublished(directory / "new.txt")) == mode);  // from the first moment
    together.publish();
    CHECK(mode_of(directory / "new.txt") == mode);
  }
  ::umask(before);
}

TEST_CASE("files of one Publication appear together, in the order written") {
  const TemporaryDirectory directory;
  put(directory / "b.txt", "old");
  {
    Publication together;
    write_text(directory / "a.txt", "A");
    write_text(directory / "b.txt", "B");
    CHECK(!fs::exists(directory / "a.txt"));
    CHECK(get(directory / "b.txt") == "old");
    CHECK(get(together.unpublished(directory / "b.txt")) == "B");
    CHECK(contains(message_of([&] { (void)together.unpublished("c.txt"); }), "c.txt"));
    CHECK(unfinished_in(directory.path()) == 2);
  }  // never published: removed
  CHECK(get(directory / "b.txt") == "old");
  CHECK(directory.entries() == 1);

  Publication together;
  write_text(directory / "a.txt", "A");
  {
    Publication inner;
    write_text(directory / "b.txt", "B");
    inner.publish();  // which leaves it to the outer one
  }
  CHECK(get(directory / "b.txt") == "old");
  fs::remove(directory / "b.txt");
  fs::create_directory(directory / "b.txt");
  write_text(directory / "c.txt", "C");
  const std::string message = message_of([&] { together.publish(); });
  CHECK(message == "IoError: " + (directory / "b.txt").string() +
                       ": cannot be written: Is a directory; written before it: " +
                       (directory / "a.txt").string() +
                       "; not written either: " + (directory / "c.txt").string());
  CHECK(get(directory / "a.txt") == "A");
  CHECK(directory.entries() == 2);
}

TEST_CASE("a codebook's two files appear together") {
  const TemporaryDirectory directory;
  put(directory / "words.csv", "old");
  const Codebook codebook(Eigen::MatrixXd::Identity(2, 3), Eigen::VectorXd::Zero(3));
  const std::string message =
      message_of([&] { codebook.save(directory / "words.csv", directory / "none/w.csv"); });
  CHECK(contains(message, "none/w.csv"));
  CHECK(get(directory / "words.csv") == "old");
  CHECK(directory.entries() == 1);
  codebook.save(directory / "words.csv", directory / "w.csv");
  CHECK(directory.entries() == 2);
}

TEST_CASE("unfinished files can be removed in a signal handler, but not by a child") {
  const TemporaryDirectory directory;
  Publication together;
  write_text(directory / "a.txt", "A");
  write_text(directory / "b.txt", "B");
  const pid_t child = ::fork();
  if (child == 0) {
    remove_unfinished_files();
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
  CHECK(unfinished_in(directory.path()) == 2);
  remove_unfinished_files();
  CHECK(directory.entries() == 0);
  CHECK(contains(message_of([&] { together.publish(); }), "a.txt: cannot be written"));
  write_text(directory / "c.txt", "C");
  together.publish();
  remove_unfinished_files();  // knows no published file any more
  CHECK(get(directory / "c.txt") == "C");
}

TEST_SUITE_END();

}  // namespace ccvt::test
