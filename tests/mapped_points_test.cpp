#include "ccvt/mapped_points.h"

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/sampling.h"
#include "support/files.h"
#include "support/message.h"
#include "support/npy.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

Points<float> some_points(Index count, int dimension) {
  return sample_uniform<float>(Box::unit(dimension), count, 5, Distribution::white);
}

std::string fvecs_of(const Points<float>& points) {
  std::string bytes;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const auto x = points.col(p);
    bytes += number_bytes<std::int32_t>({static_cast<std::int32_t>(points.rows())});
    bytes += number_bytes<float>({x.begin(), x.end()});
  }
  return bytes;
}

/// Whether a mapped file, or one that cannot be, holds what read_points() reads.
template <class Scalar>
bool is_mapped(const fs::path& path, const ReadOptions& options = {}) {
  const MappedPoints<Scalar> points(path, options);
  const PointsView<Scalar> view = points.view();
  const auto read = read_points<Scalar>(path, options);
  REQUIRE(view.count == read.cols());
  REQUIRE(view.dimension == read.rows());
  for (Index p = 0; p < view.count; ++p) {
    for (int d = 0; d < view.dimension; ++d) CHECK(view[p][d] == read(d, p));
  }
  points.check_unchanged();
  CHECK(MappedPoints<Scalar>::can_map(path, options) == points.mapped());
  return points.mapped();
}

std::string message_when_mapped(const fs::path& path) {
  const std::string message = message_of([&] { MappedPoints<float>{path}; });
  CHECK(message == message_of([&] { read_points<float>(path); }));
  return message.substr(message.find(": ") + 2);
}

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE("points are mapped where the file has them as they are, and read elsewhere") {
  const TemporaryDirectory directory;
  const Points<float> points = some_points(37, 3);
  const fs::path fvecs = put(directory / "p.fvecs", fvecs_of(points));
  CHECK(is_mapped<float>(fvecs));
  CHECK_FALSE(is_mapped<double>(fvecs));
  CHECK_FALSE(is_mapped<float>(fvecs, {.columns = {"2", "1"}}));
  const fs::path single = directory / "s.npy";
  write_points(single, points);
  CHECK(is_mapped<float>(single));
  CHECK_FALSE(is_mapped<double>(single));
  const fs::path wide = directory / "d.npy";
  write_points(wide, points.cast<double>().eval());
  CHECK(is_mapped<double>(wide));
  CHECK_FALSE(is_mapped<float>(wide));
  const std::string numbers = number_bytes<float>({1, 2, 3, 4, 5, 6});
  // Not at a multiple of four bytes.
  CHECK_FALSE(is_mapped<float>(put(directory / "odd.npy", npy_file("<f4", "(3, 2)", numbers))));
  CHECK_FALSE(is_mapped<float>(put(directory / "f.npy", npy_file("<f4", "(3, 2)", numbers, true))));
  CHECK_FALSE(is_mapped<float>(
      put(directory / "b.npy",
          npy_file(">f4", "(3, 2)", number_bytes<float>({1, 2, 3, 4, 5, 6}, true)))));
  CHECK_FALSE(is_mapped<float>(put(directory / "i.npy", npy_file("|u1", "(3, 2)", "abcdef"))));
  const std::string bytes = number_bytes<std::int32_t>({2}) + "ab";
  CHECK_FALSE(is_mapped<float>(put(directory / "p.bvecs", bytes + bytes)));
  CHECK_FALSE(is_mapped<double>(put(directory / "p.csv", "1,2\n3,4\n")));
}

TEST_CASE("mapped files are refused in the words in which read ones are") {
  const TemporaryDirectory directory;
  Points<float> points = some_points(9, 3);
  const std::string whole = fvecs_of(points);
  CHECK(message_when_mapped(put(directory / "t.fvecs", whole.substr(0, whole.size() - 2)))
            .find("has 142 bytes, not a multiple of the 16") == 0);
  std::string other = whole;
  other[std::size_t{5} * 16] = 2;
  CHECK(message_when_mapped(put(directory / "h.fvecs", other))
            .find("vector 5 has 2 dimensions, but vector 0 has 3") == 0);
  points(1, 7) = NAN;
  CHECK(message_when_mapped(put(directory / "n.fvecs", fvecs_of(points)))
            .find("row 7, column 1: nan is not finite") == 0);
  put(directory / "n.npy",
      npy_file("<f4", "(9, 3)", number_bytes(std::vector(points.data(), points.data() + 27))));
  CHECK(message_when_mapped(directory / "n.npy").find("row 7, column 1: nan is not finite") == 0);
  fs::resize_file(directory / "n.npy", fs::file_size(directory / "n.npy") - 1);
  CHECK(message_when_mapped(directory / "n.npy").find("bytes") != std::string::npos);
  CHECK(message_when_mapped(directory / "none.fvecs") == "there is no such file");
}

TEST_CASE("a mapped file that is written to is told, one that is replaced does no harm") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "p.npy";
  const Points<float> points = some_points(20, 2);
  write_points(path, points);
  const MappedPoints<float> first(path);
  write_points(path, some_points(5, 2));  // another file of that name
  first.check_unchanged();
  CHECK(first.view()[19][1] == points(1, 19));
  const MappedPoints<float> second(path);
  fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(1));
  CHECK(message_of([&] { second.check_unchanged(); }) ==
        path.string() + ": has changed while it was read");
  const MappedPoints<float> third(path);
  fs::resize_file(path, fs::file_size(path) + 8);
  CHECK(message_of([&] { third.check_unchanged(); }) ==
        path.string() + ": has changed while it was read");
}

TEST_CASE("mapped vectors are trained with and encoded to the same bits") {
  const TemporaryDirectory directory;
  const Points<float> points = some_points(3000, 5);
  const MappedPoints<float> mapped(put(directory / "p.fvecs", fvecs_of(points)));
  REQUIRE(mapped.mapped());
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    CodebookOptions options;
    options.method = method;
    options.threads = 1;
    const Training read = train_codebook(points, 40, options);
    options.threads = 2;
    const Training seen = train_codebook(mapped.view(), 40, options);
    CHECK(read.codes == seen.codes);
    CHECK(read.codebook.codewords() == seen.codebook.codewords());
    CHECK(read.codebook.encode(points, Coding::weighted, 1) ==
          seen.codebook.encode(mapped.view(), Coding::weighted, 2));
  }
}

#ifdef CCVT_TEST_MEMORY
TEST_CASE("a file that the system does not map is told") {
  const TemporaryDirectory directory;
  const fs::path path = put(directory / "p.fvecs", number_bytes<std::int32_t>({1}));
  fs::resize_file(path, std::uint64_t{1} << 33);  // with holes: it takes no space
  rlimit before = {};
  REQUIRE(::getrlimit(RLIMIT_AS, &before) == 0);
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  rlimit small = before;
  small.rlim_cur = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + 1'000'000'000;
  REQUIRE(::setrlimit(RLIMIT_AS, &small) == 0);
  const std::string message = message_of([&] { MappedPoints<float>{path}; });
  ::setrlimit(RLIMIT_AS, &before);
  CHECK(message == "IoError: " + path.string() + ": cannot be mapped: Cannot allocate memory");
}
#endif

#ifdef CCVT_PROGRAM

#ifdef CCVT_TEST_MEMORY
TEST_CASE("vectors in C order take no memory of quantize and encode, others do") {
  const TemporaryDirectory directory;
  // 320 MB of zeros, with holes: it takes no space.
  const auto large = [&](const char* name, const char* shape, bool fortran) {
    // The data have to start at a multiple of four bytes.
    std::string bytes = npy_file("<f4", shape, "", fortran);
    bytes = npy_file("<f4", shape + std::string((4 - bytes.size() % 4) % 4, ' '), "", fortran);
    REQUIRE(bytes.size() % 4 == 0);
    fs::resize_file(put(directory / name, bytes), bytes.size() + 320'000'000);
  };
  large("c.npy", "(20000, 4000)", false);
  large("fortran.npy", "(20000, 4000)", true);
  write_points(directory / "book.npy", Points<float>::Random(4000, 2).eval());
  const auto limited = [] {
    const rlimit most = {250'000'000, 250'000'000};
    ::setrlimit(RLIMIT_DATA, &most);
  };
  const std::string encode = " --codebook book.npy --threads 2 -q -o codes.npy";
  const std::string quantize =
      " --codewords 2 --method lloyd --seeding random --restarts 1 --max-iterations 0 --threads 2 "
      "-q -o words.npy";
  const std::string memory = "ccvt: error: out of memory\n";
  CHECK(run(directory, "encode fortran.npy" + encode, limited).errors == memory);
  CHECK(run(directory, "quantize fortran.npy" + quantize, limited).errors == memory);
  CHECK(run(directory, "encode c.npy" + encode, limited).errors.empty());
  CHECK(run(directory, "quantize c.npy" + quantize, limited).errors.empty());
  CHECK(fs::exists(directory / "codes.npy"));
  CHECK(fs::exists(directory / "words.npy"));
}
#endif

namespace {

/// Stops the program as soon as it has mapped v.npy, and lets it go on after `change`.
Ran run_and_change(const TemporaryDirectory& directory, const std::string& line,
                   const std::function<void()>& change) {
  Process process(CCVT_PROGRAM, words(line), directory.path());
  const std::string maps = "/proc/" + std::to_string(process.id()) + "/maps";
  while (get(maps).find("/v.npy") == std::string::npos) {
    REQUIRE(process.running());
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  process.send(SIGSTOP);
  change();
  process.send(SIGCONT);
  const int status = process.wait();
  return {status, process.output(), process.errors()};
}

}  // namespace

TEST_CASE("a file that changes while it is mapped ends the program with a line, and no outputs") {
  const TemporaryDirectory directory;
  const fs::path path = directory / "v.npy";
  const Points<float> points = some_points(60'000, 16);
  const std::string quantize =
      "quantize v.npy --codewords 500 --method lloyd --seeding random --max-iterations 30 "
      "-o words.npy --codes-out codes.npy --summary s.json";
  write_points(path, points);
  const Ran shorter = run_and_change(directory, quantize, [&] { fs::resize_file(path, 0); });
  CHECK(shorter.status == 1);
  CHECK(shorter.errors ==
        "ccvt: error: v.npy: cannot be read any more: it became shorter while it was read, or its "
        "disk fails\n");
  CHECK(directory.entries() == 1);
  write_points(path, points);
  const Ran written = run_and_change(directory, quantize, [&] {
    fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(1));
  });
  CHECK(written.status == 2);
  CHECK(written.errors == "ccvt: error: v.npy: has changed while it was read\n");
  CHECK(directory.entries() == 1);
}

#endif

TEST_SUITE_END();

}  // namespace ccvt::test
