// What help says about files, beside what readers and writers take.
#ifdef CCVT_PROGRAM

#include <doctest/doctest.h>

#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/particles.h"
#include "ccvt/point_cloud.h"
#include "ccvt/surface.h"
#include "ccvt/version.h"
#include "ccvt/volume.h"
#include "support/files.h"
#include "support/message.h"
#include "support/process.h"

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

/// All extensions that anything here reads or writes, and some that nothing does.
const std::vector<std::string> kExtensions = {
    ".npy", ".csv", ".txt", ".ply", ".fvecs", ".bvecs", ".nii", ".nii.gz", ".nrrd", ".nhdr", ".raw",
    ".vtp", ".vtk", ".svg", ".png", ".jpg",   ".dat",   ".gz",  ".gadget", ".hdf5", ".obj"};

/// What the help of a command says about one option or argument.
std::string help_of(const TemporaryDirectory& directory, const std::string& command,
                    const std::string& option) {
  std::istringstream lines(run(directory, command + " --help").output);
  std::string text;
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    const auto begin = line.find_first_not_of(' ');
    // Options start in column 2; what goes on from the line before stands further right.
    if (begin == 2) {
      std::string names = line.substr(2, line.find(' ', 2) - 2);
      inside = ("," + names + ",").find("," + option + ",") != std::string::npos;
    } else if (begin != std::string::npos && begin < 2) {
      inside = false;
    }
    if (inside) text += line + "\n";
  }
  return text;
}

/// Whether `text` has the extension as a word: ".gz" is none of those of ".nii.gz".
bool lists(const std::string& text, const std::string& extension) {
  for (auto at = text.find(extension); at != std::string::npos; at = text.find(extension, at + 1)) {
    const char before = at == 0 ? ' ' : text[at - 1];
    const std::size_t end = at + extension.size();
    const char after = end < text.size() ? text[end] : ' ';
    if (before == ' ' &&
        (after == ' ' || after == ',' || after == ';' || after == '.' || after == '\n')) {
      return true;
    }
  }
  return false;
}

bool knows(const std::function<void(const fs::path&)>& use, const fs::path& path) {
  return message_of([&] { use(path); }).find("unknown extension") == std::string::npos;
}

}  // namespace

TEST_SUITE_BEGIN("cli");

TEST_CASE("help lists the extensions that readers and writers take, and no others") {
  const TemporaryDirectory directory;
  const auto read_as_points = [](const fs::path& path) { read_points<float>(path); };
  const auto read_as_indices = [](const fs::path& path) { read_indices(path); };
  const auto read_as_volume = [](const fs::path& path) { inspect_volume(path); };
  const auto read_as_mesh = [](const fs::path& path) { read_mesh(path); };
  const auto write_as_points = [](const fs::path& path) {
    write_points(path, Points<float>::Zero(2, 2).eval());
  };
  const auto write_as_sites = [](const fs::path& path) {
    try {
      check_particles(path, 2, 4, {});
    } catch (const InvalidInput& error) {
      if (std::string(error.what()).find("unknown extension") == std::string::npos) throw;
      write_points(path, Points<float>::Zero(2, 2).eval());
    }
  };
  const auto write_as_owners = [](const fs::path& path) {
    write_owners(path, std::vector<Index>{1});
  };
  const auto write_as_samples = [](const fs::path& path) {
    VolumeSamples samples;
    samples.sites = Points<double>::Zero(3, 1);
    samples.capacities = {1};
    samples.weights = samples.radii = {1.0};
    write_samples(path, samples);
  };
  const auto write_as_cloud = [](const fs::path& path) {
    PointCloud cloud;
    cloud.points = Points<double>::Zero(3, 1);
    write_point_cloud(path, cloud, std::vector<Index>{0}, std::vector<Index>{1});
  };
  const auto write_as_picture = [](const fs::path& path) { write_png(path, Image{1, 1, {0.5F}}); };
  struct Case {
    std::string command;
    std::string option;
    std::function<void(const fs::path&)> use;
  };
  const Case cases[] = {
      {"sample", "--output", write_as_sites},
      {"sample", "--points-out", write_as_points},
      {"sample", "--owners-out", write_as_owners},
      {"tessellate", "POINTS", read_as_points},
      {"tessellate", "--initial-sites", read_as_points},
      {"tessellate", "--capacities", read_as_indices},
      {"tessellate", "--output", write_as_points},
      {"tessellate", "--owners-out", write_as_owners},
      {"analyze", "POINTS", read_as_points},
      {"analyze", "--compare", read_as_points},
      {"volume", "FILE", read_as_volume},
      {"volume", "--mask", read_as_volume},
      {"volume", "--output", write_as_samples},
      {"volume", "--preview", write_as_picture},
      {"surface", "MESH", read_as_mesh},
      {"surface", "--output", write_as_samples},
      {"surface", "--preview", write_as_picture},
      {"quantize", "VECTORS", read_as_points},
      {"quantize", "--seeding", read_as_points},
      {"quantize", "--capacities", read_as_indices},
      {"quantize", "--output", write_as_points},
      {"quantize", "--codes-out", write_as_owners},
      {"quantize", "--weights-out", write_as_points},
      {"quantize", "--image-out", write_as_picture},
      {"thin", "POINTS", read_as_points},
      {"thin", "--output", write_as_cloud},
      {"thin", "--indices-out", write_as_owners},
      {"thin", "--owners-out", write_as_owners},
      {"encode", "VECTORS", read_as_points},
      {"encode", "--codebook", read_as_points},
      {"encode", "--weights", read_as_points},
      {"encode", "--output", write_as_owners},
  };
  for (const Case& c : cases) {
    CAPTURE(c.command);
    CAPTURE(c.option);
    const std::string help = help_of(directory, c.command, c.option);
    CAPTURE(help);
    REQUIRE(help != "");
    for (const std::string& extension : kExtensions) {
      CAPTURE(extension);
      const fs::path path = put(directory / ("file" + extension), "?");
      CHECK(lists(help, extension) == knows(c.use, path));
      fs::remove(path);
    }
  }
}

TEST_CASE("mistyped commands and options: what was likely meant") {
  const TemporaryDirectory directory;
  struct Case {
    std::string line;
    std::string told;
  };
  const Case cases[] = {
      {"tesselate p.csv", "unknown command 'tesselate'; did you mean tessellate? See ccvt --help"},
      {"stiple", "unknown command 'stiple'; did you mean stipple? See ccvt --help"},
      {"draw", "unknown command 'draw', not one of sample, "},
      {"sample --sitse 8",
       "unknown argument '--sitse'; did you mean --sites? See ccvt sample --help"},
      {"sample --sites=8 --periodc",
       "'--periodc'; did you mean --periodic? See ccvt sample --help"},
      {"sample --thread=2", "unknown argument '--thread=2'; did you mean --threads? See"},
      {"volume v.nii --interpol linear", "'--interpol'; did you mean --interpolation? See"},
      {"analyze a.npy --owners-out o.npy", "unknown argument '--owners-out'; see ccvt analyze"},
      // It begins --points-out and --points-per-site.
      {"sample --points", "unknown argument '--points'; see ccvt sample --help"},
      {"--versoin", "unknown argument '--versoin'; did you mean --version? See ccvt --help"},
      {"sample -", "unknown argument '-'; see ccvt sample --help"},
      {"sample --sites 5 --dim 2 -o=s.csv",
       "--output: '=s.csv' begins with '='; a file of that name is './=s.csv'"},
      {"--sites 5 sample",
       "'--sites' is out of place: options stand behind the command, and before any '--'; see "
       "ccvt sample --help"},
      {"sample --sites 5 --dim 2 -o s.csv -- --seed 3", "'--seed' is out of place: "},
      {"tessellate -- p.csv --sites 5",
       "what follows '--' is taken for files; options go before it; see ccvt tessellate --help"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.line);
    const Ran ran = run(directory, c.line);
    CAPTURE(ran.errors);
    CHECK(ran.status == 2);
    CHECK(ran.output == "");
    CHECK(ran.errors.find(c.told) != std::string::npos);
  }
}

TEST_CASE("help fits into 100 columns, in groups") {
  const TemporaryDirectory directory;
  for (const char* const command : {"sample", "tessellate", "stipple", "volume", "surface", "thin",
                                    "analyze", "quantize", "encode"}) {
    CAPTURE(command);
    const std::string help = run(directory, command + std::string(" --help")).output;
    CHECK(help.find("\nOutput:\n  -o,--output ") != std::string::npos);
    CHECK(help.find("\nRun:\n") != std::string::npos);
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) {
      CAPTURE(line);
      CHECK(line.size() <= 100);
    }
  }
}

TEST_CASE("thin writes what it has read, in whatever it computes") {
  const TemporaryDirectory directory;
  const std::string help = run(directory, "thin --help").output;
  CHECK(help.find("--float                         Choose in float32\n") != std::string::npos);
  CHECK(help.find("Compute and write") == std::string::npos);
}

TEST_CASE("help is a command, too") {
  const TemporaryDirectory directory;
  for (const auto& [line, same] : {std::pair("help", "--help"), {"help thin", "thin --help"}}) {
    const Ran ran = run(directory, line);
    CHECK(ran.status == 0);
    CHECK(ran.output == run(directory, same).output);
  }
  CHECK(run(directory, "help thn").errors.find("unknown command 'thn'; did you mean thin?") !=
        std::string::npos);
}

TEST_CASE("the version says what the program is made of") {
  const TemporaryDirectory directory;
  CHECK(run(directory, "-V").output == run(directory, "--version").output);
  const std::string text = run(directory, "--version").output;
  CHECK(text.starts_with("ccvt " CCVT_VERSION "\ncompiler: "));
  for (const char* const part :
       {"\ninstruction set: ", "\nthreads: ", "\npoints from: .npy .csv"}) {
    CHECK(text.find(part) != std::string::npos);
  }
#ifdef CCVT_TEST_HDF5
  CHECK(text.find(".gadget .hdf5\n") != std::string::npos);
#else
  CHECK(text.find(".hdf5") == std::string::npos);
#endif
}

TEST_SUITE_END();

}  // namespace ccvt::test

#endif  // CCVT_PROGRAM
