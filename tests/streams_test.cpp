// Files named `-` and `FORMAT:-`, and what goes to terminals.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "support/files.h"
#include "support/pipe.h"
#include "support/process.h"
#include "support/room.h"
#include "support/terminal.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

/// Runs the program with the bytes of a file on standard input, from a pipe, as programs meet it.
Ran run_piped(const Room& room, const std::string& input, const std::string& line) {
  const std::string command =
      (input.empty() ? "" : "cat " + input + " | ") + std::string(CCVT_PROGRAM) + " " + line;
  Process process("/bin/sh", {"-c", command}, room.directory.path(), [&] { room.enter(); });
  const int status = process.wait();
  return {status, process.output(), process.errors()};
}

void put_inputs(const TemporaryDirectory& directory) {
  const auto points = sample_uniform<double>(Box::unit(2), 400, 1);
  write_points(directory / "p.csv", points);
  write_points(directory / "p.npy", points);
  write_points(directory / "w.csv", sample_uniform<double>(Box::unit(2), 4, 2));
  put(directory / "c.csv", "100\n100\n100\n100\n");
  put(directory / "v.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\n\n" +
                                std::string(64, '\x07'));
  put(directory / "d.nrrd",
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: raw\ndata file: v.raw\n");
  put(directory / "v.raw", std::string(64, '\x07'));
  put(directory / "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n");
  put(directory / "c.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 1\n");
  Image image{16, 16, std::vector<float>(256, 0.3F)};
  write_png(directory / "i.png", image);
}

struct Case {
  std::string input;  ///< the file that is read, or none
  std::string stream_in;
  std::string line;        ///< IN and OUT are to be replaced
  std::string output;      ///< the file that is written
  std::string stream_out;  ///< how it is called on standard output
};

std::string with(std::string line, const std::string& input, const std::string& output) {
  if (const auto at = line.find("IN"); at != std::string::npos) line.replace(at, 2, input);
  if (const auto at = line.find("OUT"); at != std::string::npos) line.replace(at, 3, output);
  return line;
}

std::string without_seconds(const std::string& text) {
  return std::regex_replace(text, std::regex("[0-9.e+-]+ s\\b"), "… s");
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("a stream has the bytes of a file") {
  const Room room;
  const TemporaryDirectory& directory = room.directory;
  put_inputs(directory);
  const std::vector<Case> cases = {
      {"p.csv", "-", "tessellate IN --sites 4 -o OUT", "o.csv", "-"},
      {"p.csv", "csv:-", "tessellate IN --sites 4 -o OUT", "o.csv", "csv:-"},
      {"p.npy", "npy:-", "tessellate IN --sites 4 -o OUT", "o.npy", "npy:-"},
      {"p.csv", "txt:-", "tessellate IN --sites 4 -o s.csv --owners-out OUT", "o.csv", "-"},
      {"c.csv", "-", "tessellate p.csv --sites 4 --capacities IN -o OUT", "o.csv", "-"},
      {"w.csv", "-", "tessellate p.csv --initial-sites IN -o OUT", "o.csv", "-"},
      {"", "", "sample --dim 3 --sites 9 -o OUT", "o.csv", "-"},
      {"", "", "sample --dim 2 --sites 9 -o OUT", "o.txt", "txt:-"},
      {"", "", "sample --dim 3 --sites 9 --periodic -o OUT", "o.gadget", "gadget:-"},
      {"w.csv", "-", "sample --dim 2 --sites 9 --fixed-sites IN -o OUT", "o.csv", "-"},
      {"c.ply", "ply:-", "thin IN --sites 2 -o OUT", "o.ply", "ply:-"},
      {"p.csv", "-", "thin IN --sites 20 -o OUT", "o.csv", "-"},
      {"p.csv", "-", "thin IN --sites 20 -o s.csv --indices-out OUT", "o.npy", "npy:-"},
      {"p.csv", "-", "quantize IN --codewords 4 -o OUT", "o.csv", "-"},
      {"w.csv", "-", "quantize p.csv --codewords 4 --seeding IN -o s.csv --codes-out OUT", "o.csv",
       "-"},
      {"i.png", "-", "quantize IN --image-blocks 4 --codewords 4 -o s.csv --image-out OUT", "o.png",
       "-"},
      {"p.csv", "-", "encode IN --codebook w.csv -o OUT", "o.csv", "-"},
      {"w.csv", "-", "encode p.npy --codebook IN -o OUT", "o.npy", "npy:-"},
      {"v.nrrd", "nrrd:-", "volume IN --sites 8 -o OUT", "o.csv", "-"},
      {"v.nrrd", "nrrd:-", "volume IN --sites 8 -o OUT", "o.ply", "ply:-"},
      {"v.nrrd", "nrrd:-", "volume v.nrrd --mask IN --sites 8 -o OUT", "o.csv", "-"},
      {"m.obj", "obj:-", "surface IN --sites 8 -o OUT", "o.csv", "-"},
      {"c.ply", "-", "thin ply:- --sites 2 -o OUT", "o.csv", "-"},
      {"i.png", "-", "stipple IN --sites 8 -o OUT", "o.csv", "-"},
      {"i.png", "-", "stipple IN --sites 8 -o OUT", "o.svg", "svg:-"},
      {"i.png", "-", "stipple IN --sites 8 -o OUT", "o.png", "png:-"},
  };
  for (const Case& each : cases) {
    // A kind that is told by the name of the file only is told by that of the stream.
    const std::string file_line = with(each.line, each.input, each.output);
    const std::string stream_line = with(each.line, each.stream_in, each.stream_out);
    CAPTURE(stream_line);
    const bool named_in_line = each.line.find("ply:-") != std::string::npos;
    const Ran file = run(directory, named_in_line ? "thin c.ply --sites 2 -o o.csv" : file_line);
    CAPTURE(file.errors);
    REQUIRE(file.status == 0);
    const std::string bytes = get(directory / each.output);
    REQUIRE(!bytes.empty());
    const Ran streams = run_piped(room, each.input, stream_line);
    CAPTURE(streams.errors);
    CHECK(streams.status == 0);
    CHECK(streams.output == bytes);
    // What is printed otherwise, but for seconds.
    CHECK(without_seconds(streams.errors) == without_seconds(file.errors + file.output));
    CHECK(streams.errors.find("ccvt-") == std::string::npos);
    CHECK(run_piped(room, each.input, stream_line + " -q").errors.empty());
    CHECK(room.left() == 0);
  }
}

TEST_CASE("a summary and an analysis go through streams too") {
  const Room room;
  put_inputs(room.directory);
  const Ran summary = run_piped(room, "p.csv", "tessellate - --sites 4 -o s.csv --summary -");
  REQUIRE(summary.status == 0);
  CHECK(nlohmann::json::parse(summary.output)["sites"] == 4);
  CHECK(fs::exists(room.directory / "s.csv"));

  const Ran analysis = run_piped(room, "p.csv", "analyze p.npy --compare same=- -o out");
  CAPTURE(analysis.errors);
  REQUIRE(analysis.status == 0);
  CHECK(analysis.output.find("points") != std::string::npos);
  const auto metrics = nlohmann::json::parse(get(room.directory / "out/metrics.json"));
  CHECK(metrics["compare"]["same"]["radial"] == metrics["radial"]);
  CHECK(metrics["compare"]["same"]["files"][0] == "standard input");
  CHECK(run_piped(room, "p.csv", "analyze - -o alone").status == 0);
  CHECK(room.left() == 0);
}

TEST_CASE("streams that cannot be are refused") {
  const Room room;
  put_inputs(room.directory);
  put(room.directory / "bad.csv", "1 2\n3 x\n");
  put(room.directory / "none.csv", "");
  const std::string once = "already; one file only may be a stream\n";
  const std::string no_data =
      "standard input: its header names a data file, which a stream has no directory for; name the "
      "header as a file\n";
  const std::vector<std::array<std::string, 3>> cases = {
      {"p.csv", "tessellate - --initial-sites - -o s.csv",
       "--initial-sites: standard input is that of POINTS " + once},
      {"p.csv", "analyze - csv:- -o out", "POINTS: standard input is that of POINTS " + once},
      {"p.csv", "tessellate p.csv --sites 2 -o - --owners-out -",
       "--owners-out: standard output is that of --output " + once},
      {"p.csv", "tessellate xyz:- --sites 2 -o -",
       "POINTS: 'xyz:-' has an unknown format; must be npy:-, csv:-, txt:-, ply:-, fvecs:-, "
       "bvecs:- or gadget:-\n"},
      {"p.csv", "tessellate hdf5:- --sites 2 -o -",
       "POINTS: 'hdf5:-' cannot be a stream: .hdf5 is not read and written from its start to its "
       "end; name a file\n"},
      {"", "sample --dim 3 --periodic --sites 2 -o hdf5:-",
       "--output: 'hdf5:-' cannot be a stream: .hdf5 is not read and written from its start to "
       "its end; name a file\n"},
      {"v.nrrd", "volume nhdr:- --sites 2 -o -",
       "FILE: 'nhdr:-' cannot be a stream: .nhdr has its data in another file; name a file\n"},
      {"d.nrrd", "volume nrrd:- --sites 2 -o -", no_data},
      {"d.nrrd", "volume v.nrrd --mask nrrd:- --sites 2 -o -", no_data},
      {"", "sample --dim 2 --sites 2 -o s.csv --summary json:-",
       "--summary: 'json:-' names a format, but there is one only; say -\n"},
      {"", "analyze p.csv -o -",
       "--output: '-' cannot be a stream: a directory of files is written; see ccvt analyze "
       "--help\n"},
      {"bad.csv", "tessellate - --sites 1 -o -",
       "standard input: line 2: field 2: 'x' is not a number\n"},
      {"none.csv", "tessellate - --sites 1 -o -", "standard input: is empty\n"},
  };
  for (const auto& [input, refused, message] : cases) {
    const std::string& line = refused;  // lambdas of Clang 14 cannot have what is bound
    CAPTURE(line);
    const Ran ran = run_piped(room, input, line);
    CHECK(ran.status == 2);
    CHECK(ran.output.empty());
    CHECK(ran.errors == "ccvt: error: " + message);
    CHECK(room.left() == 0);
  }
  // A file of such a name is still to be had.
  CHECK(run(room.directory, "sample --dim 2 --sites 2 -o s.csv --summary ./-").status == 0);
  CHECK(fs::exists(room.directory / "-"));
}

TEST_CASE("outputs are checked before standard input is read") {
  const Room room;
  put_inputs(room.directory);
  for (const char* const line :
       {"tessellate - --sites 2 -o none/s.csv", "volume nrrd:- --sites 2 -o none/s.csv",
        "volume v.nrrd --mask nrrd:- --sites 2 -o none/s.csv"}) {
    CAPTURE(line);
    const std::string bytes = get(room.directory / "v.nrrd");
    Pipe pipe;
    REQUIRE(pipe.write(bytes));
    pipe.close_writing();
    const Ran early = run(room.directory, line, [&] { ::dup2(pipe.reading(), STDIN_FILENO); });
    CHECK(early.status == 2);
    CHECK(early.errors ==
          "ccvt: error: none/s.csv: cannot be written: there is no directory 'none'\n");
    CHECK(pipe.read() == bytes);
  }
}

TEST_CASE("streams that fail give one line, and nothing is replaced") {
  const Room room;
  const TemporaryDirectory& directory = room.directory;
  put_inputs(directory);
  const std::string line = "tessellate p.csv --sites 4 -q -o - --owners-out o.csv --summary j.json";
  const auto nowhere = [&] {
    room.enter();
    Pipe pipe;
    pipe.close_reading();
    ::dup2(pipe.writing(), STDOUT_FILENO);
  };
  const Ran closed_pipe = run(directory, line, nowhere);
  CHECK(closed_pipe.status == 1);
  CHECK(closed_pipe.errors == "ccvt: error: standard output: cannot be written: Broken pipe\n");
  const Ran full = run(directory, line, [&] {
    room.enter();
    ::dup2(::open("/dev/full", O_WRONLY), STDOUT_FILENO);
  });
  CHECK(full.status == 1);
  CHECK(full.errors ==
        "ccvt: error: standard output: cannot be written: No space left on device\n");
  const Ran closed = run(directory, line, [] { ::close(STDOUT_FILENO); });
  CHECK(closed.status == 2);
  CHECK(closed.errors == "ccvt: error: --output: standard output is closed\n");
  const Ran no_input =
      run(directory, "tessellate - --sites 4 -o s.csv", [] { ::close(STDIN_FILENO); });
  CHECK(no_input.status == 2);
  CHECK(no_input.errors == "ccvt: error: POINTS: standard input is closed\n");
  const Ran no_file = run(directory, "tessellate - --sites 4 -o s.csv",
                          [] { ::dup2(::open(".", O_RDONLY), STDIN_FILENO); });
  CHECK(no_file.status == 1);
  CHECK(no_file.errors == "ccvt: error: standard input: cannot be read: Is a directory\n");
  const Ran no_room = run(directory, "tessellate - --sites 4 -o s.csv",
                          [&] { ::setenv("TMPDIR", (directory / "gone").c_str(), 1); });
  CHECK(no_room.status == 1);
  CHECK(no_room.errors.rfind(
            "ccvt: error: standard input: there is no directory for temporary files", 0) == 0);
  const Ran no_place =
      run(directory, "tessellate - --sites 4 -o s.csv", [] { ::setenv("TMPDIR", "/proc", 1); });
  CHECK(no_place.status == 1);
  CHECK(no_place.errors.rfind("ccvt: error: standard input: cannot be kept in /proc: ", 0) == 0);
  // As on a full disk for temporary files.
  const auto short_of_room = [&] {
    room.enter();
    const rlimit most = {1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &most);
    ::dup2(::open((directory / "p.csv").c_str(), O_RDONLY), STDIN_FILENO);
  };
  const std::string where = (directory / "tmp").string();
  const Ran no_copy = run(directory, "sample --dim 2 --sites 99 -q -o -", short_of_room);
  CHECK(no_copy.status == 1);
  CHECK(no_copy.output.empty());
  CHECK(no_copy.errors == "ccvt: error: the copy of standard output in " + where +
                              " cannot be written: File too large\n");
  const Ran not_kept = run(directory, "tessellate - --sites 4 -o s.csv", short_of_room);
  CHECK(not_kept.status == 1);
  CHECK(not_kept.errors ==
        "ccvt: error: standard input: cannot be kept in " + where + ": File too large\n");
  for (const char* const name : {"o.csv", "j.json", "s.csv"}) CHECK(!fs::exists(directory / name));
  CHECK(room.left() == 0);
}

TEST_CASE("a terminal gets no binary files, no colours and no escape codes") {
  const Room room;
  const TemporaryDirectory& directory = room.directory;
  const std::string sample = "sample --dim 2 --sites 2000 --points-per-site 512 -o ";
  const Ran binary = run_on_terminal(directory, sample + "npy:-", {.output = true});
  CHECK(binary.status == 2);
  CHECK(binary.errors ==
        "ccvt: error: --output: .npy is not for a terminal; redirect standard output, or say "
        "csv:-\r\n");
  const Ran text = run_on_terminal(directory, "sample --dim 2 --sites 3 -q -o -", {.output = true});
  CHECK(text.status == 0);
  CHECK(std::count(text.errors.begin(), text.errors.end(), '\n') == 3);

  for (const char* const colour : {"NO_COLOR=", "NO_COLOR=1", "CLICOLOR_FORCE=1"}) {
    CAPTURE(colour);
    const Ran drawn =
        run_on_terminal(directory, sample + "s.npy", {.environment = {"TERM=xterm", colour}});
    CHECK(drawn.status == 0);
    CHECK(drawn.errors.find("level 1/") != std::string::npos);
    CHECK(drawn.errors.ends_with(" \r"));  // the line is cleared
    CHECK(drawn.errors.find('\x1b') == std::string::npos);
    const Ran dumb =
        run_on_terminal(directory, sample + "s.npy", {.environment = {"TERM=dumb", colour}});
    CHECK(dumb.status == 0);
    CHECK(dumb.errors.empty());
    for (const char* const line : {"--help", "sample --help", "--version", "smaple", "sample -o"}) {
      CAPTURE(line);
      const Ran said = run_on_terminal(
          directory, line, {.environment = {"TERM=xterm-256color", colour}, .output = true});
      CHECK(!said.errors.empty());
      CHECK(said.errors.find('\x1b') == std::string::npos);
    }
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif
