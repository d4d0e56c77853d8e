#include "cli/surface.h"

#include <algorithm>
#include <cstdint>

#include "cli/argument_kinds.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/streams.h"
#include "number_text.h"

namespace ccvt::cli {

namespace {

constexpr std::uint64_t kBytesOfTriangle = 80;  // while sheets are looked for

/// What the closing line does not say.
void tell(const SurfaceArguments& arguments, const SurfaceSamples& samples) {
  if (arguments.quiet) return;
  if (samples.turned > 0) {
    print(concat("turned: ", samples.turned,
                 " triangles face the other way than the rest of their sheet, and got its "
                 "normal\n"));
  }
  print(concat("area ", text(samples.area, 6), ", sheets ", samples.sheets,
               ", sites moved onto the surface by up to ", text(samples.farthest_moved, 3), "\n"));
}

template <class Scalar>
int sample(const SurfaceArguments& arguments) {
  const TriangleMesh mesh = read_mesh(arguments.mesh, arguments.density);
  const auto triangles = static_cast<std::uint64_t>(mesh.triangles.cols());
  const auto vertices = static_cast<std::uint64_t>(mesh.vertices.cols());
  const int dimension = arguments.normal_weight > 0 ? 6 : 3;
  const std::string needed =
      check_memory(arguments.sites, arguments.points_per_site, dimension, sizeof(Scalar),
                   (kBytesOfTriangle + 12) * triangles + 24 * vertices);
  if (!arguments.quiet) {
    print(concat(vertices, " vertices, ", triangles, " triangles; needs about ", needed,
                 " of memory\n"));
  }
  SurfaceOptions options;
  options.points_per_site = arguments.points_per_site;
  options.normal_weight = arguments.normal_weight;
  const SurfaceSamples samples = blame(arguments.mesh, [&] {
    Progress progress(arguments.quiet, arguments.time_limit);
    options.tessellation = make_options(arguments, options.tessellation, arguments.sites, progress);
    return sample_surface<Scalar>(mesh, arguments.sites, options);
  });
  Publication outputs;
  if (!arguments.preview.empty())
    write_png(arguments.preview, preview(mesh, samples, 720, arguments.up));
  write_summary(arguments, samples.summary);
  write_samples(arguments.output, samples);
  const int status = finish(arguments, outputs, samples.summary);
  tell(arguments, samples);
  return status;
}

}  // namespace

CLI::App* add_surface(CLI::App& app, SurfaceArguments& arguments) {
  auto* const command = app.add_subcommand("surface", "Samples on a triangle mesh");
  add_input(*command, "MESH", arguments.mesh, "The surface", io::kMeshFiles)->required();
  add_sites(*command, arguments.sites, "Number of samples", true);
  add_points_per_site(*command, arguments.points_per_site);
  command
      ->add_option_function<std::string>(
          "--density", [&arguments](const std::string& name) { arguments.density = name; },
          "Samples are as dense as this property of the vertices says, linear between them; of "
          ".obj: red, green or blue [the same everywhere]")
      ->type_name("PROPERTY");
  add_number<double>(*command, "--normal-weight", arguments.normal_weight,
                     "How far apart sheets that face apart are held, in spacings of the samples; "
                     "0: not at all [" +
                         text(arguments.normal_weight) + "]",
                     "W", {.least = 0, .most = 100});
  add_common(*command, arguments, io::kSampleFiles, "float32");
  describe_samples(*command);
  auto* const preview = add_output(*command, "--preview", arguments.preview,
                                   "Draw the surface with the samples on it", io::kPictureFiles);
  add_parsed(
      *command, "--up", arguments.up,
      [](const std::string& name, int& axis) {
        const std::size_t found = name.size() == 1 ? std::string("xyz").find(name) : 3;
        if (found > 2) return "'" + name + "' is not x, y or z";
        axis = static_cast<int>(found);
        return std::string();
      },
      "Of --preview: which axis points up, x, y or z [z]", "AXIS")
      ->needs(preview);
  command->footer(
      "Example: ccvt surface bunny.obj --sites 5000 -o samples.ply --preview bunny.png");
  return command;
}

int run_surface(const SurfaceArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kSampleFiles)
      .add("--preview", arguments.preview, io::kPictureFiles)
      .add("--summary", arguments.summary)
      .add_input("MESH", arguments.mesh)
      .check();
  return arguments.scalar == ScalarType::float64 ? sample<double>(arguments)
                                                 : sample<float>(arguments);
}

}  // namespace ccvt::cli
