#include "session.h"

#include <algorithm>
#include <cstdint>
#include <thread>

#include "cli/memory.h"
#include "number_text.h"
#include "numbers.h"

namespace ccvt::mpi {

int Session::count_here() {
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  int ranks_here = 1;
  MPI_Comm_size(machine, &ranks_here);
  MPI_Comm_free(&machine);
  return ranks_here;
}

int Session::own_threads() const {
  const auto processors = static_cast<int>(std::thread::hardware_concurrency());
  return std::max(1, processors / ranks_here_);
}

void Session::check_count(Index sites, Index points_per_site) {
  const std::int64_t all = std::int64_t{sites} * points_per_site;
  if (all <= kMostPointsOfAll) return;
  throw InvalidInput(concat("--sites ", sites, ": with --points-per-site ", points_per_site,
                            " there are ", all, " points, but at most ", kMostPointsOfAll,
                            " are supported"));
}

cli::RankFigures Session::figures() const {
  const MpiRanks::Traffic& own = ranks_.traffic();
  std::int64_t sums[] = {own.messages, own.sent_bytes, own.gathered_bytes};
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  std::uint64_t peak = cli::peak_memory_bytes();
  MPI_Allreduce(MPI_IN_PLACE, &peak, 1, MPI_UINT64_T, MPI_MAX, MPI_COMM_WORLD);
  double seconds = own.seconds / ranks_.count();
  MPI_Allreduce(MPI_IN_PLACE, &seconds, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return {ranks_.count(), sums[0], sums[1], sums[2], seconds, peak};
}

}  // namespace ccvt::mpi
