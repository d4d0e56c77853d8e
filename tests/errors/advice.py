"""What to do about the errors of each source file, and those that no test can provoke."""

_PARAMETER = ("A value that was given is wrong. The message says which, what it is and what it must "
              "be; headers document the ranges.")
_RANKS = ("Several processes read `.npy`, `.fvecs` and `.bvecs`, write `.npy`, and know some of the "
          "options. `ccvt` knows all.")
_USAGE = "The command line does not fit together. `ccvt COMMAND --help` says what does."
_DAMAGED = ("The file is damaged, cut short or of another kind than its name says. Make it again, or "
            "name it for what it is.")

ADVICE = {
    "include/ccvt/domain.h": _PARAMETER,
    "include/ccvt/grid_values.h": _PARAMETER,
    "include/ccvt/region.h": _PARAMETER,
    "include/ccvt/sampling.h": _PARAMETER,
    "include/ccvt/solver.h": _PARAMETER,
    "include/ccvt/types.h": "Pass a column-major matrix, one point a column; copy it with `.eval()` "
                            "where its memory is strided.",
    "src/bounds.h": "Solve the problem that it was moved to; nothing is left of the other.",
    "src/capacity.cpp": "Capacities are whole numbers, one a site, and sum to the number of points.",
    "src/checkpoint/checkpoint_file.cpp": "What is damaged cannot be continued: remove it, and the run "
                                          "begins anew.",
    "src/checks.h": _PARAMETER,
    "src/cli/analyze.cpp": "Give the box that the points fill (`--box`), and average or compare only "
                           "point sets that agree in dimensions, number and box.",
    "src/cli/analyze_command.cpp": _USAGE,
    "src/cli/argument_kinds.cpp": _USAGE,
    "src/cli/blocks.cpp": "Choose smaller blocks, or a larger picture.",
    "src/cli/memory.cpp": "Take fewer points: fewer sites, or a smaller `--points-per-site`.",
    "src/cli/outputs.cpp": "Give each output a file of its own, with one of the extensions that the "
                           "message lists.",
    "src/cli/particle_arguments.cpp": "Particle loads are periodic and have three dimensions; their "
                                      "options are for `.gadget` and `.hdf5` only.",
    "src/cli/quantize.cpp": _USAGE,
    "src/cli/run.cpp": "Give `--box` all lower bounds, then all upper ones.",
    "src/cli/run.h": "Fixed and initial sites have the dimensions of the points.",
    "src/cli/sample.h": "`sample` fills the unit box; scale fixed sites to it.",
    "src/cli/standard_streams.cpp": "One input and one output may be `-`; kinds are named as in "
                                    "`npy:-`. Redirect binary files, and set TMPDIR to a directory "
                                    "with room for the whole file.",
    "src/cli/stipple.cpp": _USAGE,
    "src/cli/streams.cpp": "Whoever reads the standard output has gone, or its disk is full.",
    "src/cli/tessellate.cpp": _USAGE,
    "src/cli/tessellate_masses.cpp": _USAGE,
    "src/cli/thin.cpp": _USAGE,
    "src/cli/volume.cpp": _USAGE,
    "src/cli/volume_input.cpp": "Choose which values matter with `--map`, and leave cells out with "
                                "`--mask`, a volume of the same cells. Standard input must have the "
                                "data along with the header. A raw file does not say what is in it.",
    "src/cli/volume_mask.cpp": "The mask has the cells of the volume, at the same places; resample it, or "
                               "choose other labels.",
    "src/codebook/codebook.cpp": _PARAMETER,
    "src/codebook/train.cpp": _PARAMETER,
    "src/codebook/vectors.cpp": "Train on a part of the vectors, and encode all.",
    "src/codebook/trainer.h": _PARAMETER,
    "src/domain.cpp": _PARAMETER,
    "src/exact/exchange_ranks.cpp": "Run all ranks on processors of one kind.",
    "src/lloyd.cpp": "It runs on one process only, and so does all else that is not said to take `Ranks`.",
    "src/mpi/kept.h": "Whoever started the ranks ended them, and what has been reached is kept: run the same "
                      "command again.",
    "src/mpi/main.cpp": "Start all ranks with one command line, and one build of the program.",
    "src/mpi/mpi_ranks.cpp": "Take more ranks: each then sends less at a time.",
    "src/mpi/results.cpp": _RANKS,
    "src/mpi/results.h": _RANKS,
    "src/mpi/session.cpp": _USAGE,
    "src/mpi/session.h": "Take more ranks on more machines: each then holds less.",
    "src/mpi/shared_file.cpp": "All ranks need a file system that all of them see, with room.",
    "src/run_ranks.cpp": "Several ranks start balanced, as up to 8 dimensions do by default, or from initial "
                         "owners, of which each has those of its points.",
    "src/no_checkpoint.h": "Only what runs one solver keeps a checkpoint: leave Options::checkpoint "
                           "empty.",
    "src/geometry/linear_map.cpp": "Give a regular matrix.",
    "src/geometry/finite_points.h": "Leave out points that have such a coordinate.",
    "src/geometry/whitening.cpp": "Points that lie in a plane cannot be whitened: take away a dimension.",
    "src/io/byte_stream.cpp": _DAMAGED,
    "src/io/columns.cpp": "Name columns as the header does, or number them from 1.",
    "src/io/finite.h": "Coordinates are finite numbers: leave out rows of others.",
    "src/io/gadget.cpp": "Read formats 1 and 2 of GADGET, little-endian, in one file; join or convert "
                         "others.",
    "src/io/hdf5_absent.cpp": "Build with libhdf5, or use another format.",
    "src/io/hdf5_particles.cpp": "The file must be laid out as GADGET-4, SWIFT and AREPO do it, in "
                                 "one file.",
    "src/io/image.cpp": "Read PNG and JPEG, write PNG; a picture has as many values as pixels, or "
                        "three times as many.",
    "src/io/input_file.cpp": "Check the name, the permissions and whether the file is complete.",
    "src/io/jpeg_decoder.cpp": _DAMAGED + " Convert other kinds of JPEG to 8-bit RGB or grey.",
    "src/io/lines.cpp": _DAMAGED,
    "src/io/mapped_points.cpp": "Replace files when nobody is opening them.",
    "src/io/mapped_file.cpp": "Nobody may write to a file that is mapped; let there be address space "
                              "for all of it.",
    "src/io/mesh_file.cpp": "Meshes need triangles or polygons of vertices that exist; densities are "
                            "properties of vertices, finite and not negative.",
    "src/io/nifti.cpp": _DAMAGED + " Extract one three-dimensional volume of real numbers first.",
    "src/io/npy.cpp": _DAMAGED + " `numpy.save()` writes what is read here.",
    "src/io/npy_points.cpp": "Points have the shape (points, dimensions), are finite, and fit the "
                             "type that is computed with.",
    "src/io/nrrd.cpp": _DAMAGED + " Volumes have three axes in space, encoded raw or by gzip.",
    "src/io/numbers.cpp": "Give one finite number a line, or an array of shape (#,).",
    "src/io/obj.cpp": _DAMAGED,
    "src/io/particles.cpp": _PARAMETER,
    "src/io/ply.cpp": "Vertices need properties x and y, and finite coordinates.",
    "src/io/ply_file.cpp": _DAMAGED,
    "src/io/png_decoder.cpp": _DAMAGED,
    "src/io/png_encoder.cpp": "libpng failed; the message says why.",
    "src/io/point_cloud.cpp": "Write points that carry more than coordinates in the kind of file that "
                              "they came in.",
    "src/io/point_layout.h": "Several processes read a file in parts: `ccvt-mpi`, `ReadOptions::first_row` and `end_row`.",
    "src/io/points.cpp": "Give one point a line, all with as many finite numbers.",
    "src/io/publication.cpp": "Ask for files only that were written within the Publication.",
    "src/io/sample_table.cpp": "Samples have as many weights and radii as sites; other than two and "
                               "three dimensions go into tables.",
    "src/io/text.cpp": "Give one number, or one point, a line, all with as many fields.",
    "src/io/unfinished_file.cpp": "Outputs are regular files in directories that exist and may be "
                                  "written; make room on the disk.",
    "src/io/vecs.cpp": _DAMAGED,
    "src/io/volume_file.cpp": _DAMAGED + " Only `.raw` needs `--shape` and `--type`.",
    "src/metrics/bond_order.cpp": _PARAMETER,
    "src/metrics/distances.cpp": _PARAMETER,
    "src/metrics/point_set.cpp": "Give two points at least, all in a box of positive extent, and sets "
                                 "that agree.",
    "src/metrics/sets.h": _PARAMETER,
    "src/metrics/spectrum.cpp": _PARAMETER,
    "src/options.cpp": _PARAMETER,
    "src/parallel/alike.h": "Ranks are to make the same calls, each with its own points alone.",
    "src/point_count.h": _PARAMETER,
    "src/parallel/together.h": "Make the same calls on all ranks, in the same order, with what all were given.",
    "src/presets.cpp": "Choose one of the names that the message lists.",
    "src/problem.cpp": _PARAMETER,
    "src/relax/filling.h": "Take more sites, or a smaller `tile_sites`: each tile then has fewer points.",
    "src/relax/balance.cpp": "A mistake of the library: please report it.",
    "src/relax/mover.cpp": "A mistake of the library: please report it.",
    "src/schedule/schedule.cpp": "A mistake of the library: please report it.",
    "src/solver.cpp": "Return true from `Options::cancelled`, or call this from `Options::on_iteration`.",
    "src/run_checkpoint.cpp": "A checkpoint is saved from and loaded into a solver that has not ended. "
                              "What is damaged cannot be continued: remove it, and the run begins anew.",
    "src/sampling/density.cpp": "A grid has a value for each cell; of several ranks each has the layers "
                                "that `layers_of_rank()` says.",
    "src/sampling/density_parts.cpp": "Densities are finite and not negative, and positive somewhere.",
    "src/sampling/density_ranks.cpp": _PARAMETER,
    "src/sampling/function.cpp": "Densities are finite and not negative, nowhere above the maximum "
                                 "that was given, and positive somewhere.",
    "src/sampling/region.cpp": _PARAMETER,
    "src/sampling/uniform.cpp": _PARAMETER,
    "src/scales.cpp": "Shift or scale the points, so that coordinates are neither huge nor tiny.",
    "src/stipple/draw.cpp": _PARAMETER,
    "src/stipple/ink.cpp": _PARAMETER,
    "src/stipple/stipple.cpp": "Give a picture that is neither all white nor all black, or say "
                               "`--invert`.",
    "src/surface/mesh.cpp": _PARAMETER,
    "src/surface/preview.cpp": _PARAMETER,
    "src/surface/sample.cpp": "The mesh needs an area, and densities a positive integral over it.",
    "src/surface/samples_output.cpp": _PARAMETER,
    "src/tessellation.cpp": _PARAMETER,
    "src/thin/lift.cpp": _PARAMETER,
    "src/thin/thin.cpp": _PARAMETER,
    "src/thread_count.h": _PARAMETER,
    "src/volume/preview.cpp": _PARAMETER,
    "src/volume/sample.cpp": _PARAMETER,
    "src/volume/mask_entries.h": _PARAMETER,
    "src/volume/sample_ranks.cpp": _PARAMETER,
    "src/volume/volume.cpp": _PARAMETER,
    "src/weighted/inputs.cpp": "Masses are finite and not negative, and capacities sum to theirs.",
    "src/weighted/weighted.cpp": _PARAMETER,
}

_KERNEL = "the system fails to read an open file"
_HUGE = "needs more than 2^31 of them in memory or in a file"

# (file, longest constant part of the message): why.
_MPI = "tests/mpi/program.py provokes it, where there is MPI"
CANNOT_BE_PROVOKED = {
    ("src/mpi/mpi_ranks.cpp", "ranks: messages have more than 256 GB together"): _HUGE,
    ("src/mpi/kept.h", "ended by a signal; the same command, or one with other limits, goes on from "): _MPI,
    ("src/cli/standard_streams.cpp", " reads and writes files only"): _MPI,
    ("src/cli/volume_mask.cpp", " (of two .npy, one is in C order, the other in Fortran order), or from "
                                "the other end: several processes need both alike"): _MPI,
    ("src/mpi/main.cpp", " was started with other arguments than rank 0, or is of another version; all need the "
                         "same, but for --threads"): _MPI,
    ("src/mpi/results.cpp", ": several processes read files in .npy, .fvecs and .bvecs, each its part"): _MPI,
    ("src/mpi/results.cpp", " dimensions; several processes know up to "): _MPI,
    ("src/mpi/results.cpp", "' does not start balanced, as several processes do"): _MPI,
    ("src/mpi/session.cpp", ": with --points-per-site "): _MPI,
    ("src/mpi/session.h", "out of memory"): "needs a machine without any left",
    ("src/exact/exchange_ranks.cpp", "ranks have come to search apart: processors differ too much"):
        "needs processors of different kinds",
    ("src/mpi/results.h", ": what several processes write together goes into .npy"): _MPI,
    ("src/mpi/shared_file.cpp", ": cannot be opened by all ranks: "): "needs machines that do not see the same "
                                                                  "files",
    ("src/cli/analyze.cpp", ": cannot be read"): _KERNEL,
    ("src/io/mapped_points.cpp", "has changed while it was read"):
        "needs a file that is replaced between two system calls",
    ("src/io/input_file.cpp", ": cannot be read: "): _KERNEL,
    ("src/io/input_file.cpp", ": its size is unknown: "): _KERNEL,
    ("src/io/hdf5_absent.cpp",
     ": this ccvt was built without HDF5; with libhdf5-dev (Debian) installed, configure and build "
     "it again"): "only in programs built without HDF5",
    ("src/cli/standard_streams.cpp", "the copy of standard output in "): _KERNEL,
    ("src/io/mesh_file.cpp", " triangles, which is the most supported"): _HUGE,
    ("src/relax/balance.cpp", "balance: more points than can be numbered flow between two sites"): _HUGE,
    ("src/relax/filling.h", "more points wait than can be numbered"): _HUGE,
    ("src/relax/mover.cpp", "balance: more points than can be numbered are in a cell and wait"): _HUGE,
    ("src/io/obj.cpp", "has more than 2147483647 vertices"): _HUGE,
    ("src/io/point_cloud.cpp", "is one point too many; at most 2147483647 are supported"): _HUGE,
    ("src/io/points.cpp", "is one point too many; at most 2147483647 are supported"): _HUGE,
    ("src/io/points.cpp", " coordinates; at most 16777216 are supported"):
        "takes a line of 2^24 numbers",
    ("src/metrics/point_set.cpp", " of them, but at most 2147483647 are supported"): _HUGE,
    ("src/io/png_encoder.cpp", "PNG: cannot be encoded: "): "a failure of libpng",
    ("src/io/volume_file.cpp", "is truncated"): "the file shrinks while it is read",
    ("src/relax/balance.cpp", "balance: surpluses do not sum to zero"): "a mistake of the library",
    ("src/relax/mover.cpp", "balance: a key is not a number"): "a mistake of the library",
    ("src/sampling/uniform.cpp", " dimensions exceed the address space"):
        "takes a box of 2^29 dimensions",
}
