#include "results.h"

#include "ccvt/presets.h"
#include "ccvt/publication.h"
#include "checkpoint/digest.h"
#include "cli/outputs.h"
#include "cli/streams.h"
#include "io/formats.h"
#include "number_text.h"
#include "parallel/alike.h"
#include "run.h"

namespace ccvt::mpi {

void require_parts(const std::filesystem::path& path) {
  const std::string extension = io::extension_of(path);
  if (extension == ".npy" || extension == ".fvecs" || extension == ".bvecs") return;
  throw InvalidInput(path.string() +
                     ": several processes read files in .npy, .fvecs and .bvecs, each its part");
}

void require_one_file(const Session& session, const std::filesystem::path& path,
                      const PointsHeader& header) {
  const std::string name = path.string() + ": its number of ";
  require_alike(
      session.ranks(),
      std::vector<Given>{{name + "rows", concat(header.count)},
                         {name + "dimensions", concat(header.dimension)},
                         {name + "bits", header.scalar == ScalarType::float32 ? "32" : "64"}});
}

void require_one_file(const Session& session, const std::filesystem::path& path,
                      const VolumeHeader& header) {
  const std::string name = path.string() + ": its ";
  std::vector<double> places = {header.slope, header.intercept};
  places.insert(places.end(), header.grid.origin.begin(), header.grid.origin.end());
  const auto& axes = header.grid.axes.eigen();
  places.insert(places.end(), axes.data(), axes.data() + axes.size());
  require_alike(
      session.ranks(),
      std::vector<Given>{
          {name + "shape", concat(std::span<const std::int64_t>(header.grid.shape))},
          {name + "type", to_string(header.type)},
          {name + "scale and places", concat(digest_of(std::span<const double>(places))), false}});
}

void require_balanced(const cli::CommonArguments& arguments, const std::string& source,
                      int dimension) {
  if (dimension > kBalancedDimensions) {
    throw InvalidInput(source + ": has " + std::to_string(dimension) +
                       " dimensions; several processes know up to " +
                       std::to_string(kBalancedDimensions));
  }
  if (arguments.preset.empty()) return;
  const Initialization start = find_preset(arguments.preset).options.initialization;
  if (start == Initialization::automatic || start == Initialization::balanced) return;
  throw InvalidInput("--preset: '" + arguments.preset +
                     "' does not start balanced, as several processes do");
}

std::string describe(const cli::RankFigures& figures) {
  const auto megabytes = [](auto bytes) { return text(static_cast<double>(bytes) / 1e6, 3); };
  return std::to_string(figures.ranks) + (figures.ranks == 1 ? " rank sent " : " ranks sent ") +
         megabytes(figures.sent_bytes) + " MB and gathered " + megabytes(figures.gathered_bytes) +
         " MB in " + std::to_string(figures.messages) + " messages; the largest held " +
         megabytes(figures.largest_peak_bytes) + " MB\n";
}

int finish(const Session& session, const cli::CommonArguments& arguments, const Kept& kept,
           const Summary& summary, const std::function<void()>& write,
           const std::optional<PutBack>& put_back) {
  const cli::RankFigures figures = session.figures();
  int status = 0;
  session.together([&] {
    if (!session.is_first()) return;
    Publication outputs;
    cli::write_summary(arguments, summary, put_back, {}, figures);
    write();
    status = cli::finish(arguments, outputs, summary, put_back);
    kept.end(summary);
    if (arguments.quiet) return;
    cli::print(describe(figures));
  });
  MPI_Bcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return status;
}

}  // namespace ccvt::mpi
