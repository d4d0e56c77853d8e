#include "cli/quantize.h"

#include <cstdint>
#include <optional>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "ccvt/mapped_points.h"
#include "ccvt/problem.h"
#include "ccvt/publication.h"
#include "cli/outputs.h"
#include "cli/progress.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/streams.h"
#include "codebook/vectors.h"
#include "commands.h"
#include "results.h"

namespace ccvt::mpi {
namespace {

using cli::QuantizeArguments;

void require_supported(const QuantizeArguments& arguments) {
  require_npy("--codes-out", arguments.codes_out);
  require_parts(arguments.vectors);
}

/// What a rank reads.
template <class Scalar>
struct Inputs {
  std::optional<MappedPoints<Scalar>> vectors;
  std::optional<Points<double>> codewords;
  std::vector<Index> capacities;
};

/// Throws InvalidInput unless all ranks on this machine have memory to train. Vectors that all
/// ranks gather are there three times meanwhile: what one sends, what comes, and what is kept.
template <class Scalar>
void check_memory(const Session& session, const QuantizeArguments& arguments,
                  const PointsHeader& header, std::int64_t own) {
  const auto count = static_cast<std::int64_t>(header.count);
  const bool few = are_few(count, header.dimension, sizeof(Scalar));
  const double all = 1.0 * sizeof(Scalar) * header.dimension * static_cast<double>(count);
  const bool gathered = few || arguments.method == CodebookMethod::pairwise;
  cli::check_memory(arguments, header, static_cast<std::uint64_t>(few ? count : own),
                    gathered ? 3 * all : 0, session.processes_here());
}

template <class Scalar>
Training train(const Session& session, const QuantizeArguments& arguments,
               const Inputs<Scalar>& inputs) {
  cli::Progress progress(arguments.quiet, arguments.time_limit);
  CodebookOptions options = cli::make_codebook_options(arguments, progress);
  options.capacities = inputs.capacities;
  const PointsView<Scalar> own = inputs.vectors->view();
  if (!inputs.capacities.empty()) {
    auto problem = cli::blame(arguments.vectors, [&] {
      return Problem<Scalar>(session.ranks(), own, arguments.codewords);
    });
    cli::blame(arguments.capacities, [&] { problem.set_capacities(inputs.capacities); });
  }
  if (inputs.codewords) {
    return cli::blame(arguments.seeding, [&] {
      return train_codebook_from(session.ranks(), own, *inputs.codewords, options);
    });
  }
  return cli::blame(arguments.vectors, [&] {
    return train_codebook(session.ranks(), own, arguments.codewords, options);
  });
}

template <class Scalar>
int quantize(const Session& session, const QuantizeArguments& arguments,
             const PointsHeader& header) {
  const Session::Share share = session.share(static_cast<std::int64_t>(header.count));
  Inputs<Scalar> inputs;
  session.together([&] {
    cli::check_codewords(arguments, header);
    check_memory<Scalar>(session, arguments, header, share.size());
    inputs.codewords = cli::read_codewords(arguments);
    if (!arguments.capacities.empty()) inputs.capacities = read_indices(arguments.capacities);
    cli::tell_if_cut_short(arguments.vectors);
    inputs.vectors.emplace(arguments.vectors, share.of(arguments.reading));
  });
  const Training training = train(session, arguments, inputs);
  session.share_interrupt();
  session.together([&] { inputs.vectors->check_unchanged(); });
  OwnersFile codes(session, arguments.codes_out, static_cast<std::int64_t>(header.count));
  codes.write(share.begin, training.codes);
  const cli::RankFigures figures = session.figures();
  int status = 0;
  session.together([&] {
    if (!session.is_first()) return;
    Publication outputs;
    codes.publish();
    cli::write_summary(arguments, training.summary, {}, figures);
    training.codebook.save(arguments.output, arguments.weights_out);
    status = cli::publish(outputs);
    cli::warn(arguments.quiet, training.summary.warnings);
    if (!arguments.quiet) cli::print(training.summary.brief() + "\n" + describe(figures));
  });
  MPI_Bcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return status;
}

}  // namespace

int run_quantize(const Session& session, const QuantizeArguments& given) {
  const QuantizeArguments arguments = session.own(given);
  PointsHeader header;
  session.together([&] {
    cli::check_arguments(arguments);
    require_supported(arguments);
    if (session.is_first()) cli::check_outputs(arguments);
    header = cli::inspect_and_tell(arguments.vectors, arguments.reading, arguments.quiet);
  });
  require_one_file(session, arguments.vectors, header);
  return header.scalar == ScalarType::float32 ? quantize<float>(session, arguments, header)
                                              : quantize<double>(session, arguments, header);
}

}  // namespace ccvt::mpi
