#include "cli/encode.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "ccvt/mapped_points.h"
#include "ccvt/publication.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/streams.h"
#include "commands.h"
#include "results.h"

namespace ccvt::mpi {
namespace {

using cli::EncodeArguments;
using Clock = std::chrono::steady_clock;

/// What a rank reads.
template <class Scalar>
struct Inputs {
  std::optional<MappedPoints<Scalar>> vectors;
  std::optional<Codebook> codebook;
};

template <class Scalar>
Inputs<Scalar> read(const Session& session, const Session::Share& share,
                    const EncodeArguments& arguments, const PointsHeader& header) {
  const bool mapped = MappedPoints<Scalar>::can_map(arguments.vectors, arguments.reading);
  const std::uint64_t here = session.on_machine(share.size());
  cli::check_bytes(arguments.vectors.string(), here, header.dimension,
                   cli::encoding_bytes({here, header.dimension, sizeof(Scalar), mapped}),
                   session.processes_here());
  Inputs<Scalar> inputs;
  inputs.codebook.emplace(Codebook::load(arguments.codebook, arguments.weights));
  cli::tell_if_cut_short(arguments.vectors);
  inputs.vectors.emplace(arguments.vectors, share.of(arguments.reading));
  return inputs;
}

template <class Scalar>
int encode(const Session& session, const EncodeArguments& arguments, const PointsHeader& header) {
  const Session::Share share = session.share(static_cast<std::int64_t>(header.count));
  Inputs<Scalar> read_here;
  session.together([&] { read_here = read<Scalar>(session, share, arguments, header); });
  const Codebook& codebook = *read_here.codebook;
  const PointsView<Scalar> own = read_here.vectors->view();
  const auto start = Clock::now();
  const std::vector<Index> codes = cli::blame(arguments.vectors, [&] {
    return codebook.encode(session.ranks(), own,
                           arguments.weights.empty() ? Coding::nearest : Coding::weighted,
                           arguments.threads);
  });
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const double distortion = codebook.distortion(session.ranks(), own, codes);
  const CodeUsage usage = code_usage(session.ranks(), codes, codebook.size());
  session.together([&] { read_here.vectors->check_unchanged(); });
  OwnersFile file(session, arguments.output, static_cast<std::int64_t>(header.count));
  file.write(share.begin, codes);
  const cli::RankFigures figures = session.figures();
  session.together([&] {
    if (!session.is_first()) return;
    Publication outputs;
    file.publish();
    cli::publish(outputs);
    if (arguments.quiet) return;
    cli::print(cli::describe_codes(static_cast<std::int64_t>(header.count), codebook.size(),
                                   distortion, usage, seconds) +
               describe(figures));
  });
  return 0;
}

}  // namespace

int run_encode(const Session& session, const EncodeArguments& given) {
  const EncodeArguments arguments = session.own(given);
  PointsHeader header;
  session.together([&] {
    require_npy("--output", arguments.output);
    require_parts(arguments.vectors);
    if (session.is_first()) cli::check_outputs(arguments);
    header = cli::inspect_and_tell(arguments.vectors, arguments.reading, arguments.quiet);
  });
  require_one_file(session, arguments.vectors, header);
  return header.scalar == ScalarType::float32 ? encode<float>(session, arguments, header)
                                              : encode<double>(session, arguments, header);
}

}  // namespace ccvt::mpi
