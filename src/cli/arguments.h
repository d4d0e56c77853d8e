#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "ccvt/options.h"
#include "ccvt/sampling.h"
#include "ccvt/types.h"
#include "ccvt/volume.h"
#include "cli/mass_arguments.h"
#include "cli/particle_arguments.h"

namespace ccvt::cli {

/// What all commands understand.
struct CommonArguments {
  std::string command;
  std::filesystem::path output;
  std::filesystem::path summary;  ///< empty: none
  std::uint64_t seed = 0;
  int threads = 0;
  std::optional<int> max_iterations;
  double energy_tolerance = 0;
  double time_limit = 0;
  std::filesystem::path checkpoint;  ///< a directory; empty: none
  double checkpoint_every = 600;     ///< seconds
  std::optional<Until> until;
  std::string preset;  ///< empty: the default options
  std::optional<ScalarType> scalar;
  bool quiet = false;
};

struct SampleArguments : CommonArguments {
  int dimension = 0;
  Index sites = 0;
  Index points_per_site = 256;
  bool periodic = false;
  std::filesystem::path fixed_sites;  ///< empty: none
  Distribution distribution = Distribution::jittered;
  std::filesystem::path points_out;
  std::filesystem::path owners_out;
  ParticleArguments particles;  ///< where the sites go into a file of particles
};

struct TessellateArguments : CommonArguments {
  std::filesystem::path points;
  ReadOptions reading;                  ///< of the points
  Index sites = 0;                      ///< 0: as many as there are initial sites
  std::filesystem::path initial_sites;  ///< empty: drawn from the points
  std::filesystem::path fixed_sites;    ///< empty: none
  std::filesystem::path capacities;     ///< empty: equal
  bool periodic = false;
  std::vector<int> periodic_along;  ///< dimensions from 1; empty: all or none
  std::vector<double> units;        ///< of each dimension; empty: 1
  bool whiten = false;
  std::vector<double> box;  ///< all lower bounds, then all upper bounds; empty: none
  std::filesystem::path owners_out;
  MassArguments mass;
};

struct StippleArguments : CommonArguments {
  std::filesystem::path image;
  Index sites = 0;
  Index points_per_site = 256;
  bool invert = false;
  double gamma = 1;
  double dot_radius = 0;  ///< 0: automatic
};

/// Files of one kind of point set, each a run.
struct PointFiles {
  std::string name;
  std::vector<std::filesystem::path> files;
};

struct AnalyzeArguments {
  std::vector<PointFiles> sets;
  ReadOptions reading;  ///< of all files
  bool periodic = false;
  std::vector<double> box;  ///< all lower bounds, then all upper bounds; empty: the unit box
  double max_frequency = 2;
  std::uint64_t seed = 0;
  int threads = 0;
  bool quiet = false;
  std::filesystem::path output;  ///< a directory
};

struct VolumeArguments : CommonArguments {
  std::filesystem::path volume;
  Index sites = 0;
  Index points_per_site = 256;
  ValueMap map;
  Interpolation interpolation = Interpolation::linear;
  std::filesystem::path mask;        ///< empty: none
  std::vector<std::int64_t> labels;  ///< of the mask; empty: all but 0
  std::filesystem::path preview;     ///< empty: none
  VolumeLayout layout;
  VolumeLayout mask_layout;  ///< type and byte order of a mask, where they are not the layout's
};

struct QuantizeArguments : CommonArguments {
  std::filesystem::path vectors;
  ReadOptions reading;  ///< of the vectors
  Index codewords = 0;
  CodebookMethod method = CodebookMethod::exact;
  std::string seeding = "kmeans++";  ///< or "random", or a file of codewords
  int restarts = 0;
  std::optional<int> effort;
  double gap = 0;
  Index train_sample = 0;            ///< 0: all vectors
  std::filesystem::path capacities;  ///< empty: equal
  std::filesystem::path codes_out;
  std::filesystem::path weights_out;
  int image_blocks = 0;  ///< 0: vectors come from a file of points
  std::filesystem::path image_out;
};

struct EncodeArguments {
  std::filesystem::path vectors;
  ReadOptions reading;  ///< of the vectors
  std::filesystem::path codebook;
  std::filesystem::path weights;  ///< empty: nearest codewords
  std::filesystem::path output;
  int threads = 0;
  bool quiet = false;
};

/// Each runs one command and returns the exit status. They throw InvalidInput, IoError and
/// std::bad_alloc.
int run_sample(const SampleArguments& arguments);
int run_tessellate(const TessellateArguments& arguments);
int run_stipple(const StippleArguments& arguments);
int run_analyze(const AnalyzeArguments& arguments);
int run_volume(const VolumeArguments& arguments);
int run_quantize(const QuantizeArguments& arguments);
int run_encode(const EncodeArguments& arguments);

}  // namespace ccvt::cli
