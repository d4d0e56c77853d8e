#include <array>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "ccvt/mapped_points.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/streams.h"

namespace ccvt::cli {

namespace {

template <class Scalar>
std::string describe(const Codebook& codebook, PointsView<Scalar> vectors,
                     const std::vector<Index>& codes, double seconds) {
  const CodeUsage usage = code_usage(codes, codebook.size());
  std::array<char, 300> line{};
  std::snprintf(line.data(), line.size(),
                "%zu vectors, %d codewords, distortion %.6g, cells of %d to %d, imbalance %.4g, "
                "entropy %.5g bits, %.3g s\n",
                codes.size(), codebook.size(), codebook.distortion(vectors, codes), usage.smallest,
                usage.largest, usage.imbalance, usage.entropy, seconds);
  return line.data();
}

template <class Scalar>
int encode_vectors(const EncodeArguments& arguments, const PointsHeader& header) {
  const bool mapped = MappedPoints<Scalar>::can_map(arguments.vectors, arguments.reading);
  check_bytes(arguments.vectors.string(), header.count, header.dimension,
              encoding_bytes({header.count, header.dimension, sizeof(Scalar), mapped}));
  const Codebook codebook = Codebook::load(arguments.codebook, arguments.weights);
  tell_if_cut_short(arguments.vectors);
  const MappedPoints<Scalar> points(arguments.vectors, arguments.reading);
  const PointsView<Scalar> vectors = points.view();
  const auto start = std::chrono::steady_clock::now();
  const auto codes = blame(arguments.vectors, [&] {
    return codebook.encode(vectors, arguments.weights.empty() ? Coding::nearest : Coding::weighted,
                           arguments.threads);
  });
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string line =
      arguments.quiet ? std::string() : describe(codebook, vectors, codes, seconds);
  points.check_unchanged();
  Publication outputs;
  write_owners(arguments.output, codes);
  publish(outputs);
  print(line);
  return 0;
}

}  // namespace

int run_encode(const EncodeArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kTableFiles)
      .add_input("VECTORS", arguments.vectors)
      .add_input("--codebook", arguments.codebook)
      .add_input("--weights", arguments.weights)
      .check();
  const PointsHeader header =
      inspect_and_tell(arguments.vectors, arguments.reading, arguments.quiet);
  return header.scalar == ScalarType::float32 ? encode_vectors<float>(arguments, header)
                                              : encode_vectors<double>(arguments, header);
}

}  // namespace ccvt::cli
