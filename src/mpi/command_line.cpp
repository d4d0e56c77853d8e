#include "command_line.h"

#include "cli/command_line.h"
#include "cli/commands.h"
#include "help.h"

namespace ccvt::mpi {
namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  mpirun -n 4 ccvt-mpi sample --dim 3 --sites 262144 --periodic -o sites.npy\n"
    "  mpirun -n 4 ccvt-mpi tessellate points.npy --sites 1000 -o sites.npy\n"
    "  mpirun -n 4 ccvt-mpi quantize vectors.fvecs --codewords 1024 -o codebook.npy\n"
    "  mpirun -n 4 ccvt-mpi encode vectors.fvecs --codebook codebook.npy -o codes.npy\n"
    "  mpirun -n 4 ccvt-mpi volume scan.nii --sites 20000 -o samples.ply\n"
    "\n"
    "Each of the processes that mpirun starts has its part of the points; what comes out is what\n"
    "ccvt gives, to the bit. The options are those of ccvt; points and vectors are read from\n"
    ".npy, .fvecs and .bvecs, and what there is for each of them is written to .npy. Of a\n"
    "volume each reads its layers.\n"
    "\n"
    "Open MPI's mpirun answers Ctrl-C by ending all: only what --checkpoint keeps is left then.\n"
    "Files are files: no FILE may be -. Exit status: as of ccvt.";

}  // namespace

CommandLine::CommandLine()
    : app("Capacity-constrained Voronoi tessellation by several processes", "ccvt-mpi") {
  cli::set_up(app);
  app.footer(kExamples);
  sample.command = add_sample(app, sample.arguments);
  tessellate.command = add_tessellate(app, tessellate.arguments);
  quantize.command = add_quantize(app, quantize.arguments);
  encode.command = add_encode(app, encode.arguments);
  volume.command = add_volume(app, volume.arguments);
  fit_help(app);
}

}  // namespace ccvt::mpi
