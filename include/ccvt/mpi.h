#pragma once

#include <mpi.h>

#include <cstdint>
#include <list>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/ranks.h"

namespace ccvt {

/// A message that one rank could not make, send or take in: others wait for it, and cannot be told.
/// Whoever catches it ends them all, as by MPI_Abort. No std::exception, so that nothing takes it
/// for an error that all ranks hear of.
struct MpiFailure {
  std::string message;
};

/// The processes of an MPI communicator. Made of it by all of them; MPI is initialized, for calls
/// from one thread at least (MPI_THREAD_FUNNELED), and not finalized before the last of these is
/// gone. Calls come from the thread that calls the library.
///
///     ccvt::MpiRanks ranks(MPI_COMM_WORLD);
///     ccvt::Problem<float> problem(ranks, ccvt::view_points(own_points), sites);
///     auto [all_sites, owners_of_own_points, summary] = ccvt::tessellate(problem);
///
/// Its functions throw MpiFailure. What is thrown while this lives is best caught while it lives,
/// and ends all ranks unless it was thrown on all: see Ranks. MPI's own errors end the program.
class MpiRanks final : public Ranks, public MessageProgress {
 public:
  /// Works on a duplicate of `communicator`.
  explicit MpiRanks(MPI_Comm communicator);
  /// Waits until what was sent has come; not while an exception passes, when nobody may take it.
  ~MpiRanks() override;

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int count() const override { return count_; }
  [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> own) override;
  void share(std::span<std::byte> all, std::span<const std::size_t> sizes) override;
  [[nodiscard]] std::vector<Bytes> exchange(std::vector<Bytes> to) override;
  void exchange_parts(std::span<const std::span<const std::byte>> to,
                      std::span<const std::span<std::byte>> from) override;
  void send(int to, Bytes message) override;
  [[nodiscard]] Bytes receive(int from) override;
  [[nodiscard]] bool has_come(int from) override;
  void progress() noexcept override;

  /// What this rank has sent since it was made: by send(), exchange() and exchange_parts() to
  /// others, and by gather() and share(), where what it hands in counts once.
  struct Traffic {
    std::int64_t messages = 0;
    std::int64_t sent_bytes = 0;
    std::int64_t gathered_bytes = 0;
    double seconds = 0;  ///< that it took, with what this rank waited for others
  };
  [[nodiscard]] const Traffic& traffic() const { return traffic_; }

 private:
  /// A message that may be on its way.
  struct Sent {
    Bytes message;
    std::vector<MPI_Request> requests;  ///< of its pieces
  };
  void forget_delivered();

  MPI_Comm communicator_ = MPI_COMM_NULL;
  int rank_ = 0;
  int count_ = 1;
  std::list<Sent> sent_;    ///< that may be on their way
  std::thread::id sender_;  ///< the thread that calls
  Traffic traffic_;
};

}  // namespace ccvt
