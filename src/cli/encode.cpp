#include "cli/encode.h"

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

std::string describe_codes(std::int64_t vectors, Index codewords, double distortion,
                           const CodeUsage& usage, double seconds) {
  std::array<char, 300> line{};
  std::snprintf(line.data(), line.size(),
                "%lld vectors, %d codewords, distortion %.6g, cells of %lld to %lld, imbalance "
                "%.4g, entropy %.5g bits, %.3g s\n",
                static_cast<long long>(vectors), codewords, distortion,
                static_cast<long long>(usage.smallest), static_cast<long long>(usage.largest),
                usage.imbalance, usage.entropy, seconds);
  return line.data();
}

void check_outputs(const EncodeArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kTableFiles)
      .add_input("VECTORS", arguments.vectors)
      .add_input("--codebook", arguments.codebook)
      .add_input("--weights", arguments.weights)
      .check();
}

namespace {

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
      arguments.quiet
          ? std::string()
          : describe_codes(vectors.count, codebook.size(), codebook.distortion(vectors, codes),
                           code_usage(codes, codebook.size()), seconds);
  points.check_unchanged();
  Publication outputs;
  write_owners(arguments.output, codes);
  publish(outputs);
  print(line);
  return 0;
}

}  // namespace

int run_encode(const EncodeArguments& arguments) {
  check_outputs(arguments);
  const PointsHeader header =
      inspect_and_tell(arguments.vectors, arguments.reading, arguments.quiet);
  return header.scalar == ScalarType::float32 ? encode_vectors<float>(arguments, header)
                                              : encode_vectors<double>(arguments, header);
}

}  // namespace ccvt::cli
