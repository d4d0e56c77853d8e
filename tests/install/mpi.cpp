#include <ccvt/ccvt.h>
#include <ccvt/mpi.h>

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  {
    ccvt::MpiRanks ranks(MPI_COMM_WORLD);
    const Eigen::Matrix2Xd points = Eigen::Matrix2Xd::Random(2, 100);
    const ccvt::Problem<double> problem(ranks, ccvt::view_points(points), 10);
    const bool whole = ccvt::tessellate(problem).sites.cols() == 10;
    if (!whole) MPI_Abort(MPI_COMM_WORLD, 1);
  }
  MPI_Finalize();
}
