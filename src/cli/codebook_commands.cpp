#include <limits>
#include <map>
#include <string>

#include "cli/argument_kinds.h"
#include "cli/commands.h"
#include "cli/standard_streams.h"

namespace ccvt::cli {

CLI::App* add_quantize(CLI::App& app, QuantizeArguments& arguments) {
  auto* const command = app.add_subcommand("quantize", "A codebook for given vectors");
  add_input(*command, "VECTORS", arguments.vectors,
            "With --image-blocks a PNG or JPEG, else vectors", io::kPointFiles)
      ->required();
  add_columns(*command, arguments.reading);
  add_number<Index>(*command, "--codewords", arguments.codewords, "Number of codewords", "K",
                    {.least = 1})
      ->required();
  static const std::map<std::string, CodebookMethod> names = {
      {"exact", CodebookMethod::exact},
      {"pairwise", CodebookMethod::pairwise},
      {"lloyd", CodebookMethod::lloyd}};
  command
      ->add_option_function<std::string>(
          "--method", [&arguments](const std::string& name) { arguments.method = names.at(name); },
          "exact: equal cells, cheapest assignment; pairwise: equal cells, as tessellate; lloyd: "
          "k-means, cells of any size [exact]")
      ->type_name("NAME")
      ->check(CLI::Validator(
          [](std::string& name) {
            if (names.contains(name)) return std::string();
            return "'" + name + "' is not one of exact, pairwise, lloyd";
          },
          ""));
  command
      ->add_option_function<std::string>(
          "--seeding",
          [&arguments](const std::string& text) {
            arguments.seeding = file_of("--seeding", text, Stream::input, io::kPointFiles).string();
          },
          "kmeans++, random, or a file of codewords to start from, " +
              io::list_of(io::kPointFiles) + " [kmeans++]")
      ->type_name("HOW");
  add_number<int>(*command, "--restarts", arguments.restarts,
                  "Seedings tried on a sample; the best is used; 0: as many as pay, 1 or 4 [0]",
                  "R", {.least = 0, .most = 1'000'000});
  add_number<int>(
      *command, "--effort", arguments.effort,
      "Codebooks bred from the seedings on a sample, toward the best equal cells whatever "
      "the seed [32 to 64 for up to 128 codewords and dimensions, else 0]",
      "E", {.least = 0, .most = 1'000'000});
  add_number<double>(*command, "--gap", arguments.gap,
                     "Assignments that cost at most this share more than the cheapest will do [0]",
                     "G", {.least = 0, .most = 1, .open_above = true});
  add_number<Index>(*command, "--train-sample", arguments.train_sample,
                    "Train on so many vectors, drawn at random, and assign all once, in the end "
                    "[all]",
                    "N", {.least = 1, .most = std::numeric_limits<Index>::max()});
  add_input(*command, "--capacities", arguments.capacities,
            "How many vectors each codeword gets, summing to their number [equal]",
            io::kTableFiles);
  add_output(*command, "-o,--output", arguments.output, "Where the codewords go", io::kTableFiles)
      ->required();
  add_output(*command, "--codes-out", arguments.codes_out, "Write the code of each vector too",
             io::kTableFiles);
  add_output(*command, "--weights-out", arguments.weights_out,
             "Write the weights of the codewords too, for ccvt encode --weights", io::kTableFiles);
  add_number<int>(*command, "--image-blocks", arguments.image_blocks,
                  "Take the B x B blocks of a picture for vectors of 3 B^2 values, 0 to 255", "B",
                  {.least = 1, .most = 256});
  add_output(*command, "--image-out", arguments.image_out,
             "Write the picture that the codes stand for", io::kPictureFiles);
  add_run(*command, arguments);
  command->footer(
      "Example: ccvt quantize vectors.fvecs --codewords 1024 -o codebook.npy --codes-out "
      "codes.npy");
  return command;
}

CLI::App* add_encode(CLI::App& app, EncodeArguments& arguments) {
  auto* const command = app.add_subcommand("encode", "The code of each vector");
  add_input(*command, "VECTORS", arguments.vectors, "Vectors", io::kPointFiles)->required();
  add_columns(*command, arguments.reading);
  add_input(*command, "--codebook", arguments.codebook, "The codewords, from ccvt quantize",
            io::kPointFiles)
      ->required();
  add_input(*command, "--weights", arguments.weights,
            "Their weights: codes are used as evenly as in training [nearest codeword]",
            io::kPointFiles);
  add_output(*command, "-o,--output", arguments.output, "Where the codes go", io::kTableFiles)
      ->required();
  add_number<int>(*command, "--threads", arguments.threads,
                  "Threads; 0: one per processor [0]. The result is the same for any number", "T",
                  {.least = 0, .most = 4096});
  add_flag(*command, "-q,--quiet", arguments.quiet, "Print nothing but errors");
  command->footer(
      "Example: ccvt encode new.fvecs --codebook codebook.npy --weights w.npy -o codes.npy");
  return command;
}

}  // namespace ccvt::cli
